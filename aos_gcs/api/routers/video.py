"""Videos of the wall: made of the record, one at a time."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Response
from fastapi.responses import StreamingResponse

from aos_gcs.api.dependencies import Videos
from aos_gcs.api.errors import NotFoundError
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.wall import VideoModel, VideoRequest
from aos_gcs.errors import InputDataError
from aos_gcs.wall.model import TileName
from aos_gcs.wall.video import VideoState

router = APIRouter(prefix="/api/wall/video", tags=["wall"])

_UNRECORDED: dict[int | str, dict[str, Any]] = {404: {"model": ErrorModel}}
_FAILURES: dict[int | str, dict[str, Any]] = {status: {"model": ErrorModel} for status in (404, 422, 503)}


@router.get("", responses=_UNRECORDED)
async def read_video(videos: Videos) -> VideoModel:
    """Return the state of the video that was asked for last."""
    return _model(videos.state())


@router.post("", status_code=202, responses=_FAILURES)
async def begin_video(request: VideoRequest, videos: Videos) -> VideoModel:
    """Begin a video of the record so far; it takes the place of the one before."""
    try:
        tiles = tuple(map(TileName.parse, request.tiles))
    except ValueError as error:
        raise InputDataError(f"tiles: {error}") from error
    return _model(videos.begin(tiles, request.notation))


@router.delete("", responses=_UNRECORDED)
async def give_up_video(videos: Videos) -> VideoModel:
    """End the video that is being made, or remove the one that is ready."""
    return _model(videos.give_up())


@router.get(
    ".mp4",
    response_class=Response,
    responses={200: {"content": {"video/mp4": {}}, "description": "The video that is ready."}, **_UNRECORDED},
)
async def download_video(videos: Videos) -> Response:
    """Return the video that is ready."""
    video = videos.read()
    if video is None:
        raise NotFoundError("No video is ready: make one in the view Wall.")
    size, parts = video
    headers = {"Content-Disposition": "attachment", "Content-Length": str(size), "Cache-Control": "no-cache"}
    return StreamingResponse(parts, media_type="video/mp4", headers=headers)


def _model(state: VideoState) -> VideoModel:
    return VideoModel(
        phase=state.phase,
        number=state.number,
        done=state.done,
        tiles=list(map(str, state.tiles)),
        duration_s=state.duration_s,
        bytes=state.bytes,
        unreadable=state.unreadable,
        reason=state.reason,
    )
