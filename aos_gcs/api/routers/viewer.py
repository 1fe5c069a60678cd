"""Views of a recorded step: integrals on other focal planes, and single frames."""

from __future__ import annotations

from typing import Annotated, Final

from fastapi import APIRouter, Path, Query, Request, Response

from aos_gcs.api.convert import viewer as viewer_convert
from aos_gcs.api.dependencies import Viewer
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.viewer import FocusFoundModel, ViewedStepModel
from aos_gcs.mission.viewing import FrameKind, PictureFormat, ViewKind

router = APIRouter(
    prefix="/api/viewer",
    tags=["viewer"],
    responses={404: {"model": ErrorModel}, 422: {"model": ErrorModel}, 503: {"model": ErrorModel}},
)

_FOREVER = "private, max-age=86400, immutable"
"""Recorded frames never change."""
_MEDIA_TYPES: Final = {PictureFormat.PNG: "image/png", PictureFormat.JPEG: "image/jpeg"}

StepNumber = Annotated[int, Path(ge=1, le=1_000_000)]
Metres = Annotated[float, Query(ge=-100_000.0, le=100_000.0, allow_inf_nan=False)]


@router.get("/{step}")
async def describe(step: StepNumber, viewer: Viewer) -> ViewedStepModel:
    """Return the views that a step offers."""
    return viewer_convert.viewed_step(await viewer.describe(step))


@router.get(
    "/{step}/integrals/{kind}.{picture_format}",
    response_class=Response,
    responses={
        200: {
            "content": {media_type: {} for media_type in _MEDIA_TYPES.values()},
            "description": "A north-up raster: png is exact, and transparent where no frame covers; jpg is a draft. "
            "Headers: X-Height-M, X-Visibility-M2, X-Bounds-M (west, south, east, north).",
        }
    },
)
async def read_integral(
    step: StepNumber, kind: ViewKind, picture_format: PictureFormat, viewer: Viewer, height_m: Metres | None = None
) -> Response:
    """Return the integral of a step's frames on a horizontal plane; without a height, on the mission's own."""
    view = await viewer.view(step, kind, height_m, picture_format=picture_format)
    bounds_m = (view.west_m, view.south_m, view.east_m, view.north_m)
    headers = {
        "Cache-Control": "no-cache",
        "X-Height-M": f"{view.height_m:.3f}",
        "X-Visibility-M2": f"{view.visibility_m2:.4f}",
        "X-Bounds-M": ",".join(f"{value:.3f}" for value in bounds_m),
    }
    return Response(view.data, media_type=_MEDIA_TYPES[picture_format], headers=headers)


@router.get(
    "/{step}/frames/{vehicle_id}/{kind}.png",
    response_class=Response,
    responses={200: {"content": {"image/png": {}}, "description": "The frame as it was taken."}},
)
async def read_frame(
    request: Request,
    step: StepNumber,
    vehicle_id: Annotated[int, Path(ge=0, le=255)],
    kind: FrameKind,
    viewer: Viewer,
    *,
    width_px: Annotated[int | None, Query(ge=16, le=8192)] = None,
) -> Response:
    """Return one vehicle's frame of a step, reduced to a width if it is wider."""
    png = await viewer.frame(step, vehicle_id, kind, width_px)
    # Without the mission's name, the same address shows a frame of another mission later.
    cached = _FOREVER if "mission_id" in request.query_params else "no-cache"
    return Response(png, media_type="image/png", headers={"Cache-Control": cached})


@router.get("/{step}/autofocus")
async def autofocus(
    step: StepNumber,
    east_m: Metres,
    north_m: Metres,
    viewer: Viewer,
    half_width_m: Annotated[float, Query(gt=0.0, le=100.0)] = 10.0,
) -> FocusFoundModel:
    """Search for the height at which a step's frames agree best within a square."""
    return viewer_convert.focus_found(await viewer.autofocus(step, (east_m, north_m), half_width_m))
