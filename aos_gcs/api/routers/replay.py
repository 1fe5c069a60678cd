"""Moving in a recorded mission."""

from __future__ import annotations

from fastapi import APIRouter

from aos_gcs.api.convert import replay as convert
from aos_gcs.api.dependencies import Replay
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.replay import ReplayModel, ReplayRequest, TimelineModel

router = APIRouter(prefix="/api/replay", tags=["replay"], responses={404: {"model": ErrorModel}})


@router.get("")
async def read_replay(replay: Replay) -> TimelineModel:
    """Return where the replay is, and what lies where in it."""
    return convert.timeline(replay.replay(), replay.timeline())


@router.post("", responses={403: {"model": ErrorModel}, 422: {"model": ErrorModel}})
async def control_replay(body: ReplayRequest, replay: Replay) -> ReplayModel:
    """Go to a time, play or stop; all clients see the same. After a jump each of them is greeted anew."""
    replay.seek(time_s=body.time_s, speed=body.speed, playing=body.playing)
    return convert.replay_state(replay.replay())
