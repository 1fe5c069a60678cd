"""Reading the mission and acting on it."""

from __future__ import annotations

import hashlib
from typing import Annotated

from fastapi import APIRouter, Header, Response

from aos_gcs.api import convert
from aos_gcs.api.dependencies import CurrentSession, Hub, Mission
from aos_gcs.api.errors import NotFoundError
from aos_gcs.api.models import ActionRequest, ActionResponse, ErrorModel, MissionModel, StepModel
from aos_gcs.mission.model import PictureKind

router = APIRouter(prefix="/api/mission", tags=["mission"])


@router.get("")
async def read_mission(hub: Hub) -> MissionModel:
    """Return the whole mission at this moment."""
    return hub.mission()


@router.get("/steps")
async def read_steps(hub: Hub) -> list[StepModel]:
    """Return all steps so far, oldest first."""
    return hub.steps()


@router.get(
    "/pictures/{kind}.png",
    response_class=Response,
    responses={
        200: {"content": {"image/png": {}}, "description": "A north-up raster; its step is in the header X-Step."},
        304: {"description": "The client has this picture already."},
        404: {"model": ErrorModel},
        422: {"model": ErrorModel},
    },
)
async def read_picture(
    kind: PictureKind, mission: Mission, if_none_match: Annotated[str | None, Header()] = None
) -> Response:
    """Return the latest raster of a kind."""
    picture = mission.picture(kind)
    if picture is None:
        needs = ", if the configuration has the section [forest]" if kind is PictureKind.VISIBILITY else ""
        raise NotFoundError(
            f"There is no {kind} picture yet; the first one comes with the first step of the scan{needs}."
        )
    # The hash tells apart equal steps of two missions that one browser has seen.
    etag = f'"{hashlib.blake2b(picture.png, digest_size=12).hexdigest()}"'
    headers = {"ETag": etag, "X-Step": str(picture.step), "Cache-Control": "no-cache"}
    if if_none_match == etag:
        return Response(status_code=304, headers=headers)
    return Response(picture.png, media_type="image/png", headers=headers)


@router.post("/actions", responses={403: {"model": ErrorModel}, 409: {"model": ErrorModel}, 422: {"model": ErrorModel}})
async def act(request: ActionRequest, mission: Mission, session: CurrentSession) -> ActionResponse:
    """Carry out an operator's action; answers when every vehicle has done it or refused."""
    vehicle_ids = tuple(dict.fromkeys(request.vehicle_ids)) if request.vehicle_ids is not None else None
    results = await mission.act(request.action, vehicle_ids, request.focal_height_m, operator=session.name)
    return convert.action_results(request.action, results)
