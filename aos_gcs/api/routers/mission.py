"""Reading the mission, and what operators do in it: actions, overrides, acknowledgements."""

from __future__ import annotations

import hashlib
from typing import Annotated, Any

from fastapi import APIRouter, Header, Query, Response

from aos_gcs.api.convert.mission import action_results, preflight_check
from aos_gcs.api.dependencies import (
    IN_CONTROL,
    Commands,
    ControlOfSwarm,
    CurrentSession,
    Hub,
    Mission,
    OnceOnly,
    SeenState,
    SeenStateIfAny,
    require_seen,
)
from aos_gcs.api.errors import NotFoundError
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.mission import ActionRequest, ActionResponse, MissionModel
from aos_gcs.api.models.notices import AcknowledgeRequest
from aos_gcs.api.models.preflight import OverrideRequest, PreflightCheckModel
from aos_gcs.api.models.steps import StepModel
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.steps import PictureKind

router = APIRouter(prefix="/api", tags=["mission"])

_OF_FOREST = {PictureKind.VISIBILITY, PictureKind.DETECTION}
_REFUSED: dict[int | str, dict[str, Any]] = {status: {"model": ErrorModel} for status in (403, 409, 422, 428)}


@router.get("/mission")
async def read_mission(hub: Hub, response: Response) -> MissionModel:
    """Return the whole mission at this moment; the header X-Seen names it for commands."""
    response.headers["X-Seen"] = hub.seen()
    return hub.mission()


@router.get("/mission/steps")
async def read_steps(hub: Hub, after: Annotated[int, Query(ge=0)] = 0) -> list[StepModel]:
    """Return the steps after a number, oldest first, at most 500; then ask for those after the last one."""
    return hub.steps(after)


@router.get(
    "/mission/pictures/{kind}.png",
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
        needs = ", if the configuration has the section [forest]" if kind in _OF_FOREST else ""
        raise NotFoundError(
            f"There is no {kind} picture yet; the first one comes with the first step of the scan{needs}."
        )
    # The hash tells apart equal steps of two missions that one browser has seen.
    etag = f'"{hashlib.blake2b(picture.png, digest_size=12).hexdigest()}"'
    headers = {"ETag": etag, "X-Step": str(picture.step), "Cache-Control": "no-cache"}
    if if_none_match == etag:
        return Response(status_code=304, headers=headers)
    return Response(picture.png, media_type="image/png", headers=headers)


@router.post("/mission/actions", responses=_REFUSED)
async def act(
    request: ActionRequest,
    commands: Commands,
    session: CurrentSession,
    *,
    once: OnceOnly,
    desk: ControlOfSwarm,
    seen: SeenStateIfAny,
    hub: Hub,
    response: Response,
) -> ActionResponse:
    """Carry out an operator's action; answers when every vehicle has done it or refused.

    All but hold require the header X-Seen, and are refused when that state is out of date.
    """
    if request.action is not Action.HOLD:
        await desk.claim(session)
        seen = require_seen(seen)
    vehicle_ids = tuple(dict.fromkeys(request.vehicle_ids)) if request.vehicle_ids is not None else None
    key = None if request.request_id is None else (session.name, request.action, vehicle_ids, request.request_id)
    results = await once.run(
        key,
        lambda: commands.act(request.action, vehicle_ids, request.focal_height_m, operator=session.name, seen=seen),
    )
    response.headers["X-Seen"] = hub.seen()
    return action_results(request.action, results)


@router.post("/preflight/override", responses=_REFUSED, dependencies=[IN_CONTROL])
async def override(
    request: OverrideRequest, commands: Commands, session: CurrentSession, seen: SeenState
) -> PreflightCheckModel:
    """Override a failed check, so that it no longer blocks the launch, or withdraw the override; return the check."""
    check = await commands.override_check(
        request.vehicle_id, request.check, request.reason, operator=session.name, seen=seen
    )
    return preflight_check(check)


@router.post("/notices/acknowledge", status_code=204, responses=_REFUSED)
async def acknowledge(request: AcknowledgeRequest, commands: Commands, session: CurrentSession) -> None:
    """Acknowledge notices on behalf of all operators; ``MissionModel.acknowledgements`` lists them from then on."""
    await commands.acknowledge(request.notice_ids, operator=session.name)
