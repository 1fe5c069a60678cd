"""Heights above the WGS84 ellipsoid, which other systems expect, from altitudes above mean sea level."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

from aos_gcs.elevation.geoid import find_geoid
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry import heights
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import EllipsoidalM

UndulationM = Callable[[float, float], float | None]
"""Returns the geoid's height above the ellipsoid at a latitude and longitude, degrees; None if it is not known."""

_CELL_DEG = 0.001
"""Raster on which the undulation is read: it changes by less than 2 cm across a cell of it."""


def undulations(grid: str | None) -> UndulationM | None:
    """Return the undulation of the geoid; None if no grid is found.

    Args:
        grid: file of the grid; None: looked for in PROJ's folders.

    Raises:
        ConfigurationError: the file does not exist, or pyproj is not installed to read it.
        InputDataError: it is not a grid.
    """
    try:
        geoid = find_geoid(None if grid is None else Path(grid))
    except ConfigurationError:
        if grid is not None:
            raise
        return None
    if geoid is None:
        return None

    @lru_cache(maxsize=4096)
    def at_cell(row: int, column: int) -> float | None:
        height_m = float(geoid.undulation_m(row * _CELL_DEG, column * _CELL_DEG))
        return height_m if math.isfinite(height_m) else None

    def undulation_m(latitude_deg: float, longitude_deg: float) -> float | None:
        return at_cell(round(latitude_deg / _CELL_DEG), round(longitude_deg / _CELL_DEG))

    return undulation_m


def ellipsoidal_m(position: GeodeticPosition, undulation_m: UndulationM | None) -> EllipsoidalM | None:
    """Return a position's height above the ellipsoid; None where the geoid is not known, never the altitude itself."""
    undulation = None if undulation_m is None else undulation_m(position.latitude_deg, position.longitude_deg)
    return None if undulation is None else heights.ellipsoidal_m(position.altitude_amsl_m, undulation)
