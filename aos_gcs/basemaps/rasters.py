"""Raster files as sources of tiles: GeoTIFF and GeoPackage, in any coordinate system, read in parts by GDAL."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np

from aos_gcs.basemaps.mercator import HALF_WORLD_M, TILE_PX, WorldBox
from aos_gcs.basemaps.pyramid import Rgba
from aos_gcs.errors import InputDataError
from aos_gcs.extras import load_extra

_DRIVERS: Final = {b"II*\0": "GTiff", b"MM\0*": "GTiff", b"II+\0": "GTiff", b"MM\0+": "GTiff", b"SQLi": "GPKG"}
"""GDAL's driver by the first bytes of a file. No others are used: some follow links to other machines."""
_GDAL_OPTIONS: Final = {"GDAL_CACHEMAX": 64}
"""Memory of blocks that were read, in megabytes."""

_PURPOSE = "Making a base map of GeoTIFF and GeoPackage files"
_WARP_MEMORY_MB = 64
_GREY, _COLOUR = (1, 2), (3, 4)
"""Numbers of bands, without and with opacity."""


class RasterSource:
    """A raster that is warped to Web Mercator, tile by tile."""

    def __init__(self, warped: Any, dataset: Any, path: Path, rasterio: Any) -> None:
        self._warped, self._path, self._rasterio = warped, path, rasterio
        self._palette = _palette(dataset)
        self._bands = dataset.count
        west, south, east, north = warped.bounds
        self.box = WorldBox(_world(west), _world(-north), _world(east), _world(-south))
        self.pixel = abs(warped.transform.a) / (2.0 * HALF_WORLD_M)

    @property
    def attribution(self) -> str:
        """Holder of the rights, as the file says."""
        return str(self._warped.src_dataset.tags().get("TIFFTAG_COPYRIGHT", "")).strip()

    def tile(self, zoom: int, column: int, row: int) -> Rgba | None:
        """Return its pixels in a tile, or None."""
        side_m = 2.0 * HALF_WORLD_M / (1 << zoom)
        west_m, north_m, pixel_m = column * side_m - HALF_WORLD_M, HALF_WORLD_M - row * side_m, side_m / TILE_PX
        transform = self._rasterio.Affine(pixel_m, 0.0, west_m, 0.0, -pixel_m, north_m)
        try:
            with self._rasterio.vrt.WarpedVRT(
                self._warped.src_dataset, **_warping(self._warped), transform=transform, width=TILE_PX, height=TILE_PX
            ) as part:
                bands = part.read()
        except self._rasterio.errors.RasterioError as error:
            raise InputDataError(f"{self._path} cannot be read: {_reason(error)}.") from error
        return self._coloured(bands)

    def _coloured(self, bands: Any) -> Rgba | None:
        opacity = bands[-1]
        if not opacity.any():
            return None
        if self._palette is not None:
            rgba = self._palette[bands[0]]
            rgba[..., 3] = np.minimum(rgba[..., 3], opacity)
            return np.asarray(rgba, dtype=np.uint8)
        colours = [bands[0]] * 3 if self._bands in _GREY else list(bands[:3])
        return np.stack((*colours, opacity), axis=-1).astype(np.uint8)


@contextmanager
def raster_sources(path: Path) -> Iterator[list[RasterSource]]:
    """Open a raster file, of which a GeoPackage may hold several rasters.

    Raises:
        ConfigurationError: rasterio is not installed.
        InputDataError: the file holds no picture, or does not say where it is.
    """
    rasterio: Any = load_extra("rasterio", "geo", _PURPOSE)
    load_extra("rasterio.vrt", "geo", _PURPOSE)
    # It logs what GDAL says before it raises the same words.
    logging.getLogger("rasterio").setLevel(logging.ERROR)
    with ExitStack() as stack:
        stack.enter_context(rasterio.Env(**_GDAL_OPTIONS))
        stack.enter_context(warnings.catch_warnings())
        warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)
        try:
            outer = stack.enter_context(rasterio.open(path, driver=_driver(path)))
            names = outer.subdatasets if outer.count == 0 else ()
            datasets = [stack.enter_context(rasterio.open(name)) for name in names] or [outer]
        except rasterio.errors.RasterioError as error:
            raise InputDataError(f"{path} is no GeoTIFF or GeoPackage with a raster: {_reason(error)}.") from error
        yield [_opened(stack, dataset, path, rasterio) for dataset in datasets]


def _driver(path: Path) -> str:
    try:
        with path.open("rb") as file:
            start = file.read(4)
    except OSError as error:
        raise InputDataError(f"{path} cannot be read: {error.strerror or error}.") from error
    if start not in _DRIVERS:
        raise InputDataError(f"{path} is neither GeoTIFF, GeoPackage, KMZ nor MBTiles: a base map is made of these.")
    return _DRIVERS[start]


def _opened(stack: ExitStack, dataset: Any, path: Path, rasterio: Any) -> RasterSource:
    _refuse_unplaced(dataset, path)
    _refuse_what_is_no_picture(dataset, path)
    try:
        warped = stack.enter_context(rasterio.vrt.WarpedVRT(dataset, **_warping_of(dataset, rasterio)))
    except (rasterio.errors.RasterioError, rasterio.errors.CRSError) as error:
        raise InputDataError(f"{path} cannot be put on a map of the world: {_reason(error)}.") from error
    return RasterSource(warped, dataset, path, rasterio)


def _warping_of(dataset: Any, rasterio: Any) -> dict[str, Any]:
    has_opacity = rasterio.enums.ColorInterp.alpha in dataset.colorinterp
    nearest, bilinear = rasterio.enums.Resampling.nearest, rasterio.enums.Resampling.bilinear
    return {
        "crs": "EPSG:3857",
        # Numbers of colours cannot be averaged.
        "resampling": nearest if _palette(dataset) is not None else bilinear,
        "add_alpha": not has_opacity,
        "warp_mem_limit": _WARP_MEMORY_MB,
    }


def _warping(warped: Any) -> dict[str, Any]:
    return {
        "crs": warped.crs,
        "resampling": warped.resampling,
        "add_alpha": warped.count > warped.src_dataset.count,
        "warp_mem_limit": _WARP_MEMORY_MB,
    }


def _refuse_unplaced(dataset: Any, path: Path) -> None:
    if dataset.crs is None:
        raise InputDataError(
            f"{path} does not state its coordinate system, so that its place is not known: give it one (gdal_edit.py "
            "-a_srs EPSG:CODE), or export the picture with its reference."
        )
    transform = dataset.transform
    if transform.is_identity or not np.isfinite(tuple(transform)).all() or transform.determinant == 0.0:
        raise InputDataError(
            f"{path} does not state where its pixels lie: export the picture with its reference (GeoTIFF)."
        )


def _refuse_what_is_no_picture(dataset: Any, path: Path) -> None:
    kinds = set(dataset.dtypes)
    if kinds != {"uint8"}:
        raise InputDataError(
            f"{path} holds {', '.join(sorted(kinds))} values, which are no picture of 8 bits: convert it "
            "(gdal_translate -ot Byte -scale IN OUT). An elevation model belongs into [terrain] of the configuration."
        )
    if dataset.count not in (*_GREY, *_COLOUR):
        raise InputDataError(
            f"{path} has {dataset.count} bands: extract red, green and blue (gdal_translate -b 1 -b 2 -b 3 IN OUT)."
        )


def _palette(dataset: Any) -> Any:
    """Return the colours of a raster's numbers, shape (256, 4); None where it has none."""
    if dataset.count != 1 or dataset.colorinterp[0].name != "palette":
        return None
    palette = np.zeros((256, 4), dtype=np.uint8)
    for number, colour in dataset.colormap(1).items():
        palette[number] = colour
    return palette


def _world(metres: float) -> float:
    """Return a coordinate of EPSG:3857, y downwards, as a share of the world."""
    return min(1.0, max(0.0, metres / (2.0 * HALF_WORLD_M) + 0.5))


def _reason(error: Exception) -> str:
    """Return what GDAL says, in one line."""
    said = error.__cause__ or error
    return " ".join(str(said).split()).rstrip(".")
