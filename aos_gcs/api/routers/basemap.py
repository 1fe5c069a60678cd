"""The base map: a PMTiles file on this machine, of which browsers read the parts that they show."""

from __future__ import annotations

from typing import Final

from fastapi import APIRouter
from starlette.responses import FileResponse

from aos_gcs.api.dependencies import BasemapFile
from aos_gcs.api.errors import NotFoundError
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.service import BasemapModel

router = APIRouter(prefix="/api/basemap", tags=["basemap"])

_URL: Final = "/api/basemap/tiles.pmtiles"


@router.get("")
async def read_basemap(file: BasemapFile) -> BasemapModel:
    """Return where the base map is, if there is one."""
    return BasemapModel(url=None if file is None else _URL)


@router.get(
    "/tiles.pmtiles",
    response_class=FileResponse,
    responses={
        200: {"content": {"application/vnd.pmtiles": {}}, "description": "The file; ranges are answered with 206."},
        404: {"model": ErrorModel},
    },
)
async def read_tiles(file: BasemapFile) -> FileResponse:
    """Return the file, or the range of it that is asked for."""
    if file is None or not file.is_file():
        raise NotFoundError("There is no base map; name a PMTiles file as api.basemap in the configuration.")
    return FileResponse(file, media_type="application/vnd.pmtiles", headers={"Cache-Control": "max-age=3600"})
