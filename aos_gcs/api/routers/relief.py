"""The relief about the mission, from its elevation model: hill shading and contour lines."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Header, Response

from aos_gcs.api.convert import relief as relief_convert
from aos_gcs.api.dependencies import Mission, Reliefs, Terrain
from aos_gcs.api.errors import NotFoundError
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.relief import ContoursModel, ReliefModel
from aos_gcs.api.relief_maps import ReliefMap
from aos_gcs.planning.terrain.relief import HeightUnit

router = APIRouter(prefix="/api/relief", tags=["relief"], responses={422: {"model": ErrorModel}})

_NONE = (
    "The mission has no elevation model, or no origin yet: name files in the section [terrain] of the configuration."
)


@router.get("")
async def read_relief(mission: Mission, terrain: Terrain, reliefs: Reliefs) -> ReliefModel:
    """Return where the relief about the mission is; it changes with the plan, and the addresses with it."""
    made = await reliefs.about(mission.snapshot(), terrain)
    if made is None:
        return ReliefModel(shading_url=None, contours_url=None, contours_ft_url=None, corners=[])
    return ReliefModel(
        shading_url=f"/api/relief/shading.png?version={made.version}",
        contours_url=f"/api/relief/contours?version={made.version}",
        contours_ft_url=f"/api/relief/contours?version={made.version}&unit={HeightUnit.FOOT}",
        corners=relief_convert.corners(made.relief.bounds, made.origin),
    )


@router.get(
    "/shading.png",
    response_class=Response,
    responses={
        200: {"content": {"image/png": {}}, "description": "A north-up raster, transparent where the ground is level."},
        304: {"description": "The client has this picture already."},
        404: {"model": ErrorModel},
    },
)
async def read_shading(
    mission: Mission, terrain: Terrain, reliefs: Reliefs, if_none_match: Annotated[str | None, Header()] = None
) -> Response:
    """Return the hill shading about the mission."""
    made = _existing(await reliefs.about(mission.snapshot(), terrain))
    return _answer(made, made.shading_png, "image/png", if_none_match)


@router.get(
    "/contours",
    response_model=ContoursModel,
    responses={304: {"description": "The client has these lines already."}, 404: {"model": ErrorModel}},
)
async def read_contours(
    mission: Mission,
    terrain: Terrain,
    reliefs: Reliefs,
    unit: HeightUnit = HeightUnit.METRE,
    if_none_match: Annotated[str | None, Header()] = None,
) -> Response:
    """Return the contour lines about the mission, at round numbers of a unit."""
    made = _existing(await reliefs.about(mission.snapshot(), terrain))
    return _answer(made, await reliefs.contours_json(made, unit), "application/json", if_none_match)


def _existing(made: ReliefMap | None) -> ReliefMap:
    if made is None:
        raise NotFoundError(_NONE)
    return made


def _answer(made: ReliefMap, content: bytes, media_type: str, if_none_match: str | None) -> Response:
    etag = f'"{made.version}"'
    headers = {"ETag": etag, "Cache-Control": "no-cache"}
    if if_none_match == etag:
        return Response(status_code=304, headers=headers)
    return Response(content, media_type=media_type, headers=headers)
