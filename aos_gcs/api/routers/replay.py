"""Control of a replay."""

from __future__ import annotations

from fastapi import APIRouter

from aos_gcs.api.convert import replay as convert
from aos_gcs.api.dependencies import Replay
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.replay import ReplayModel, ReplayRequest, TimelineModel

router = APIRouter(prefix="/api/replay", tags=["replay"], responses={404: {"model": ErrorModel}})


@router.get("")
async def read_replay(replay: Replay) -> TimelineModel:
    """Return the position of the replay, and its timeline."""
    return convert.timeline(replay.replay(), replay.timeline())


@router.post("", responses={403: {"model": ErrorModel}, 422: {"model": ErrorModel}})
async def control_replay(body: ReplayRequest, replay: Replay) -> ReplayModel:
    """Seek, play or stop, for all clients. After a jump each of them receives a new hello."""
    replay.seek(time_s=body.time_s, speed=body.speed, playing=body.playing)
    return convert.replay_state(replay.replay())
