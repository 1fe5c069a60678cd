"""Control of a replay."""

from __future__ import annotations

from fastapi import APIRouter

from aos_gcs.api.convert import replay as convert
from aos_gcs.api.dependencies import ChosenSortie, Replay
from aos_gcs.api.errors import NotFoundError
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.replay import ReplayModel, ReplayRequest, TimelineModel

router = APIRouter(prefix="/api/replay", tags=["replay"], responses={404: {"model": ErrorModel}})


@router.get("")
async def read_replay(replay: Replay) -> TimelineModel:
    """Return the position of the replay, and its timeline."""
    return convert.timeline(replay.replay(), replay.timeline())


@router.post("", responses={403: {"model": ErrorModel}, 422: {"model": ErrorModel}})
async def control_replay(body: ReplayRequest, replay: Replay, choice: ChosenSortie) -> ReplayModel:
    """Choose a sortie, seek, play or stop, for all clients. After a jump each of them receives a new hello."""
    if body.mission_id is not None and (choice is None or not await choice.show(body.mission_id)):
        raise NotFoundError(f"The operation has no mission {body.mission_id}.")
    replay.seek(time_s=body.time_s, speed=body.speed, playing=body.playing)
    return convert.replay_state(replay.replay())
