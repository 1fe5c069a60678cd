"""The list of what was found: read, judge, export."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path, Query, Request, Response

from aos_gcs.api.convert import findings as convert
from aos_gcs.api.dependencies import CurrentSession, FindingChanges, Mission, known_origin, viewer_of
from aos_gcs.api.errors import NotFoundError
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.findings import FindingChangeRequest, FindingModel, FindingRequest
from aos_gcs.errors import InputDataError
from aos_gcs.exports.finding_files import FORMATS, PlacedFinding
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.mission.control import MissionView
from aos_gcs.mission.model.findings import MAX_DISTANCE_M, Finding, FindingChange
from aos_gcs.mission.viewing import ViewKind, ViewWindow

router = APIRouter(prefix="/api/findings", tags=["findings"])

_THUMBNAIL_HALF_WIDTH_M = 4.0

FindingId = Annotated[int, Path(ge=1)]
_REFUSED: dict[int | str, dict[str, Any]] = {status: {"model": ErrorModel} for status in (403, 409, 422)}


@router.get("")
async def read_findings(mission: Mission) -> list[FindingModel]:
    """Return all findings, oldest first."""
    snapshot = mission.snapshot()
    return [convert.finding(one, snapshot.origin) for one in snapshot.findings]


@router.post("", status_code=201, responses=_REFUSED)
async def add_finding(
    body: FindingRequest, mission: Mission, commands: FindingChanges, session: CurrentSession
) -> FindingModel:
    """Mark a place by hand."""
    origin = known_origin(mission)
    place = GeodeticPosition(body.latitude_deg, body.longitude_deg, origin.altitude_amsl_m)
    east_m, north_m, _ = map(float, LocalFrame(origin).to_enu(place))
    if max(abs(east_m), abs(north_m)) > MAX_DISTANCE_M:
        raise InputDataError(
            f"latitude_deg, longitude_deg: the place is more than {MAX_DISTANCE_M / 1000:.0f} km from the mission."
        )
    finding = await commands.add_finding((east_m, north_m, 0.0), body.comment, operator=session.name)
    return convert.finding(finding, origin)


@router.patch("/{finding_id}", responses=_REFUSED | {404: {"model": ErrorModel}})
async def change_finding(
    finding_id: FindingId,
    body: FindingChangeRequest,
    mission: Mission,
    commands: FindingChanges,
    session: CurrentSession,
) -> FindingModel:
    """Confirm, reject, comment or assign a finding."""
    _find(mission, finding_id)
    change = FindingChange(body.status, body.comment, body.assignee)
    finding = await commands.change_finding(finding_id, change, operator=session.name)
    return convert.finding(finding, mission.snapshot().origin)


@router.get(
    "/{finding_id}/{kind}.png",
    response_class=Response,
    responses={
        200: {"content": {"image/png": {}}, "description": "What the frames show of it, north up."},
        404: {"model": ErrorModel},
        422: {"model": ErrorModel},
    },
)
async def read_thumbnail(
    finding_id: FindingId,
    kind: ViewKind,
    mission: Mission,
    request: Request,
    above_m: Annotated[float, Query(ge=-10.0, le=100.0, allow_inf_nan=False)] = 0.0,
    *,
    nearest: bool = False,
) -> Response:
    """Return a finding's surroundings in the integral of the last step that shows it.

    The focal plane lies ``above_m`` above the finding. ``nearest``: the frame of the nearest camera instead of all.
    """
    finding = _find(mission, finding_id)
    if finding.step < 1:
        raise NotFoundError(f"Finding {finding_id} was marked before the first step; no frame shows it.")
    viewer = await viewer_of(request, finding.found_in)
    east_m, north_m, up_m = finding.position_enu_m
    if not finding.sightings:
        up_m = (await viewer.describe(finding.step)).focal_height_m
    window = ViewWindow(east_m, north_m, _THUMBNAIL_HALF_WIDTH_M, nearest_only=nearest)
    view = await viewer.view(finding.step, kind, up_m + above_m, window)
    return Response(view.data, media_type="image/png", headers={"Cache-Control": "no-cache"})


@router.get(".{suffix}", response_class=Response, responses={409: {"model": ErrorModel}})
async def export(suffix: Literal["geojson", "kml", "gpx"], mission: Mission) -> Response:
    """Return all findings as a file."""
    origin = known_origin(mission)
    frame = LocalFrame(origin)
    snapshot = mission.snapshot()
    placed = [
        PlacedFinding(one, frame.to_geodetic(one.position_enu_m), snapshot.started_utc_s) for one in snapshot.findings
    ]
    media_type, write = FORMATS[suffix]
    headers = {"Content-Disposition": f'attachment; filename="findings.{suffix}"'}
    return Response(write(placed), media_type=media_type, headers=headers)


def _find(mission: MissionView, finding_id: int) -> Finding:
    for finding in mission.snapshot().findings:
        if finding.finding_id == finding_id:
            return finding
    raise NotFoundError(f"There is no finding {finding_id}.")
