"""The base map: a PMTiles file on this machine, of which browsers read the parts that they show."""

from __future__ import annotations

import asyncio
import pathlib
from typing import Annotated

from fastapi import APIRouter, Path
from starlette.responses import FileResponse

from aos_gcs.api.dependencies import BasemapFile
from aos_gcs.api.errors import NotFoundError
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.service import BasemapModel

Version = Annotated[str, Path(max_length=64, description="Any: it tells files apart in browsers.")]

router = APIRouter(prefix="/api/basemap", tags=["basemap"])


@router.get("")
async def read_basemap(file: BasemapFile) -> BasemapModel:
    """Return where the base map is, if there is one; another file has another address."""
    version = None if file is None else await asyncio.to_thread(_version, file)
    return BasemapModel(url=None if version is None else f"/api/basemap/{version}.pmtiles")


@router.get(
    "/{version}.pmtiles",
    response_class=FileResponse,
    responses={
        200: {"content": {"application/vnd.pmtiles": {}}, "description": "The file; ranges are answered with 206."},
        404: {"model": ErrorModel},
    },
)
async def read_tiles(version: Version, file: BasemapFile) -> FileResponse:  # noqa: ARG001 - for browsers' caches only
    """Return the file, or the range of it that is asked for."""
    if file is None or not file.is_file():
        raise NotFoundError("There is no base map; name a PMTiles file as api.basemap in the configuration.")
    return FileResponse(file, media_type="application/vnd.pmtiles", headers={"Cache-Control": "max-age=3600"})


def _version(file: pathlib.Path) -> str | None:
    """Return what changes when the file is replaced; None if there is none."""
    try:
        found = file.stat()
    except OSError:
        return None
    return f"{found.st_mtime_ns:x}-{found.st_size:x}"
