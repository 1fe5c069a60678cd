"""Plans over relief: an elevation model of any ground, in a file, and the settings that name it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.terrain import Polynomials
from aos_gcs.elevation.model import ModelKind
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.planning.settings import TerrainSettings
from tests.fakes.elevation_files import PLACE_DEG

ORIGIN = GeodeticPosition(*PLACE_DEG, 600.0)
"""Origin of the plans, on the ground."""
CRS = "EPSG:32633+5773"
Relief = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]
"""Height of the ground above the origin, of east and north."""


def write_relief(
    path: Path,
    relief: Relief,
    *,
    cell: float = 5.0,
    reach_m: float = 400.0,
    origin: GeodeticPosition = ORIGIN,
) -> Path:
    """Write the model of a ground up to a distance from the origin; where the relief is NaN there is a hole."""
    import pyproj  # noqa: PLC0415 - tests without the extra are skipped
    import rasterio  # noqa: PLC0415 - tests without the extra are skipped
    from rasterio.transform import Affine  # noqa: PLC0415

    count = int(2 * reach_m / cell)
    to_crs = pyproj.Transformer.from_crs("EPSG:4326", "EPSG:32633", always_xy=True)
    x, y = to_crs.transform(origin.longitude_deg, origin.latitude_deg)
    columns, rows = np.meshgrid(np.arange(count) + 0.5, np.arange(count) + 0.5)
    xs, ys = x - reach_m + columns.ravel() * cell, y + reach_m - rows.ravel() * cell
    longitudes, latitudes = to_crs.transform(xs, ys, direction="INVERSE")
    middle = np.array((origin.latitude_deg, origin.longitude_deg))
    places_m = _to_enu(origin).at(np.column_stack((latitudes, longitudes)) - middle)
    heights = origin.altitude_amsl_m + relief(places_m[:, 0], places_m[:, 1]).reshape(count, count)
    profile = {"driver": "GTiff", "height": count, "width": count, "count": 1, "dtype": "float32", "nodata": -9999.0}
    transform = Affine(cell, 0.0, x - reach_m, 0.0, -cell, y + reach_m)
    with rasterio.open(path, "w", crs=CRS, transform=transform, **profile) as dataset:
        dataset.write(np.where(np.isnan(heights), -9999.0, heights).astype(np.float32), 1)
    return path


def _to_enu(origin: GeodeticPosition) -> Polynomials:
    """Return east and north of latitude and longitude about the origin, within a centimetre."""
    frame, steps = LocalFrame(origin), np.linspace(-0.01, 0.01, 8)
    nodes = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    middle = np.array((origin.latitude_deg, origin.longitude_deg))
    places = [GeodeticPosition(*(node + middle), origin.altitude_amsl_m) for node in nodes]
    return Polynomials.fitted(nodes, np.array([frame.to_enu(place)[:2] for place in places]))


def terrain(*paths: Path, kind: ModelKind = ModelKind.TERRAIN, **values: Any) -> TerrainSettings:
    """Return the settings that name files."""
    return TerrainSettings(files=tuple(map(str, paths)), kind=kind, **values)


def hill(east_m: float, north_m: float, height_m: float, radius_m: float = 30.0) -> Relief:
    """Return a level ground with one round hill."""
    return lambda east, north: height_m * np.exp(-((east - east_m) ** 2 + (north - north_m) ** 2) / radius_m**2)


def level(height_m: float) -> Relief:
    """Return a level ground above the origin."""
    return lambda east, _: np.full_like(east, height_m)
