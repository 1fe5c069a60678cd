"""Files of the searched ground."""

from __future__ import annotations

from typing import Annotated, Any, Final

from fastapi import APIRouter, Query, Response

from aos_gcs.api.dependencies import Viewer
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.groundmap.detection import Posture
from aos_gcs.mission.viewing import GroundFile

router = APIRouter(prefix="/api/ground", tags=["ground"])

_MEDIA_TYPES: Final = {GroundFile.RASTER: "image/tiff", GroundFile.GAPS: "application/geo+json"}
_FAILURES: dict[int | str, dict[str, Any]] = {status: {"model": ErrorModel} for status in (404, 422, 503)}


@router.get(
    ".{kind}",
    response_class=Response,
    responses={
        200: {
            "content": {media_type: {} for media_type in _MEDIA_TYPES.values()},
            "description": "tif: views and probabilities of detection, a cloud-optimised GeoTIFF; geojson: polygons of "
            "the search area where the probability of detection is below a value.",
        },
        **_FAILURES,
    },
)
async def read_ground_file(
    kind: GroundFile,
    viewer: Viewer,
    posture: Annotated[Posture, Query(description="For geojson.")] = Posture.STANDING,
    below: Annotated[float, Query(gt=0.0, le=1.0, description="For geojson.")] = 0.8,
) -> Response:
    """Return a file of the searched ground, as it was recorded last."""
    content = await viewer.ground_file(kind, posture, below)
    headers = {"Content-Disposition": f'attachment; filename="searched.{kind}"', "Cache-Control": "no-cache"}
    return Response(content, media_type=_MEDIA_TYPES[kind], headers=headers)
