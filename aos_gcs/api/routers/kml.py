"""A mission in flight for Google Earth and CalTopo, and findings with their pictures as one file."""

from __future__ import annotations

from typing import Final

from fastapi import APIRouter, Request, Response

from aos_gcs.api.dependencies import Mission, known_origin, viewer_of
from aos_gcs.api.errors import NotFoundError
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.exports.finding_files import FORMATS, PlacedFinding
from aos_gcs.exports.kmz import MEDIA_TYPE, to_kmz
from aos_gcs.exports.live_kml import live_kml, network_link
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.model.findings import Finding
from aos_gcs.mission.viewing import ViewKind, ViewWindow

router = APIRouter(prefix="/api", tags=["kml"])

MAX_PICTURED: Final = 60
"""Findings of a file that have pictures, the latest ones: each takes the views' process up to a second."""
_HALF_WIDTH_M: Final = 4.0
_KML: Final = FORMATS["kml"][0]


@router.get("/live.kml", response_class=Response, responses={409: {"model": ErrorModel}})
async def read_live(mission: Mission) -> Response:
    """Return vehicles, search area, legs flown and findings as KML."""
    origin = known_origin(mission)
    return Response(live_kml(mission.snapshot(), origin), media_type=_KML, headers={"Cache-Control": "no-cache"})


@router.get("/network-link.kml", response_class=Response)
async def read_network_link(request: Request, mission: Mission) -> Response:
    """Return a file that Google Earth and CalTopo open once, and that has them read ``live.kml`` every 10 s."""
    # The address by which this file was asked for is one by which the station is reached.
    address = str(request.url_for("read_live"))
    name = f"aos-gcs, mission {mission.snapshot().mission_id}"
    headers = {"Content-Disposition": 'attachment; filename="aos-gcs.kml"'}
    return Response(network_link(address, name), media_type=_KML, headers=headers)


@router.get("/findings.kmz", response_class=Response, responses={409: {"model": ErrorModel}})
async def export_kmz(request: Request, mission: Mission) -> Response:
    """Return all findings with their pictures, those of the last steps that show them."""
    origin, snapshot = known_origin(mission), mission.snapshot()
    findings, start_utc_s = snapshot.findings, snapshot.started_utc_s
    frame = LocalFrame(origin)
    placed = [PlacedFinding(one, frame.to_geodetic(one.position_enu_m), start_utc_s) for one in findings]
    pictures = {one.finding_id: await _pictures(request, one) for one in findings[-MAX_PICTURED:]}
    headers = {"Content-Disposition": 'attachment; filename="findings.kmz"'}
    return Response(to_kmz(placed, pictures), media_type=MEDIA_TYPE, headers=headers)


async def _pictures(request: Request, finding: Finding) -> dict[str, bytes]:
    """Return the pictures of a finding that there are."""
    found: dict[str, bytes] = {}
    east_m, north_m, up_m = finding.position_enu_m
    for kind in (ViewKind.INTEGRAL, ViewKind.THERMAL):
        if finding.step < 1:
            break
        try:
            viewer = await viewer_of(request, finding.found_in)
            height_m = up_m if finding.sightings else None
            view = await viewer.view(finding.step, kind, height_m, ViewWindow(east_m, north_m, _HALF_WIDTH_M))
        except (ConfigurationError, InputDataError, NotFoundError):
            continue  # Not recorded, or a camera without this band.
        found[kind.value] = view.data
    return found
