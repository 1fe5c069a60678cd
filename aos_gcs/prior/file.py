"""Files of priors: read once, and laid over search areas."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Final

import numpy as np

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.input_values import require_file
from aos_gcs.prior.grid import read_grid
from aos_gcs.prior.model import AreaPrior, FloatArray, Prior
from aos_gcs.prior.shapes import inside_ring, read_shapes

RASTERS: Final = (".tif", ".tiff")
SHAPES: Final = (".geojson", ".json")
_CELLS_ALONG: Final = 160
"""Cells along the longer side of an area at most."""
_FINEST_CELL_M: Final = 2.0
_PARTS: Final = 3
"""Places along each side of a cell at which the prior is looked up."""

Polygon = tuple[tuple[float, float], ...]


def read_prior(name: str) -> Prior:
    """Return the prior of a file; one that was read before and has not changed is not read again.

    Args:
        name: path of a GeoTIFF or a GeoJSON file.

    Raises:
        InputDataError: it cannot be used; the text names the file and the remedy.
        ConfigurationError: a library is missing.
    """
    return _read_prior(name, _version(name))


def prior_over(name: str, origin: GeodeticPosition, area_enu_m: Polygon) -> AreaPrior:
    """Return the prior within a search area.

    Args:
        name: path of a GeoTIFF or a GeoJSON file.
        origin: origin of the local frame of the area.
        area_enu_m: search area.

    Raises:
        InputDataError: the file cannot be used, or does not meet the area; the text names the file and the remedy.
        ConfigurationError: a library is missing.
    """
    found = _prior_over(name, _version(name), origin, tuple(area_enu_m))
    if found.share <= 0.0:
        raise InputDataError(
            f"The prior {name} does not meet the search area, or is 0 everywhere in it: check its coordinate system, "
            "move the area, or search without a prior (search.prior)."
        )
    return found


def _version(name: str) -> tuple[int, int]:
    """Return what changes when the file is replaced."""
    path = Path(name)
    if not name.isprintable() or path.suffix.lower() not in {*RASTERS, *SHAPES}:
        raise InputDataError(f"The prior {name!a} must be a GeoTIFF (.tif) or a GeoJSON file (.geojson).")
    require_file(path, f"The prior {name}")
    status = path.stat()
    return status.st_mtime_ns, status.st_size


@lru_cache(maxsize=2)
def _read_prior(name: str, _file_version: tuple[int, int]) -> Prior:
    path = Path(name)
    return read_grid(path) if path.suffix.lower() in RASTERS else read_shapes(path)


@lru_cache(maxsize=4)
def _prior_over(name: str, file_version: tuple[int, int], origin: GeodeticPosition, area_enu_m: Polygon) -> AreaPrior:
    return lay_over(_read_prior(name, file_version), origin, area_enu_m)


def lay_over(prior: Prior, origin: GeodeticPosition, area_enu_m: Polygon) -> AreaPrior:
    """Return a prior within a search area, which it may not meet."""
    corners_m: FloatArray = np.array(area_enu_m, dtype=np.float64)
    low_m, high_m = corners_m.min(axis=0), corners_m.max(axis=0)
    extent_m = high_m - low_m
    cell_m = max(_FINEST_CELL_M, float(extent_m.max()) / _CELLS_ALONG)
    columns, rows = (max(1, int(count)) for count in np.ceil(extent_m / cell_m))
    fine_m = cell_m / _PARTS
    east_m = low_m[0] + (np.arange(columns * _PARTS) + 0.5) * fine_m
    north_m = high_m[1] - (np.arange(rows * _PARTS) + 0.5) * fine_m
    places_m = np.stack(np.meshgrid(east_m, north_m), axis=-1).reshape(-1, 2)
    inside = inside_ring(places_m, corners_m)
    mass = np.zeros(len(places_m))
    if inside.any():
        mass[inside] = prior.density_per_m2(LocalFrame(origin), places_m[inside]) * fine_m**2
    by_cell = mass.reshape(rows, _PARTS, columns, _PARTS).sum(axis=(1, 3))
    return AreaPrior(float(low_m[0]), float(high_m[1]), cell_m, by_cell)
