"""Elevation models in files, of a ground that is known everywhere."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

PLACE_DEG = 47.5, 14.25
"""Middle of the models."""


def ground_m(latitude_deg: ArrayLike, longitude_deg: ArrayLike) -> NDArray[np.float64]:
    """Height of the ground: a slope of about 20 % with hills."""
    north_m = (np.asarray(latitude_deg) - PLACE_DEG[0]) * 111_200.0
    east_m = (np.asarray(longitude_deg) - PLACE_DEG[1]) * 75_200.0
    return np.asarray(800.0 + 0.2 * east_m + 12.0 * np.sin(north_m / 60.0) * np.cos(east_m / 80.0))


def write_model(
    path: Path,
    crs: str = "EPSG:32633",
    *,
    cell: float = 5.0,
    size: tuple[int, int] = (120, 100),
    first: tuple[int, int] = (0, 0),
    heights: NDArray[np.float32] | None = None,
    **profile: Any,
) -> Path:
    """Write a GeoTIFF of the ground.

    Args:
        path: file.
        crs: coordinate system, with a vertical part if wanted.
        cell: edge of a cell in units of the coordinate system.
        size: rows and columns of the file.
        first: row and column of its first cell on a grid about the middle that files can share.
        heights: other heights than those of the ground.
        profile: further properties of the file.
    """
    import rasterio  # noqa: PLC0415 - tests without the extra are skipped
    from rasterio.transform import Affine  # noqa: PLC0415

    x0, y0 = _corner(crs, cell)
    transform = Affine(cell, 0.0, x0 + first[1] * cell, 0.0, -cell, y0 - first[0] * cell)
    rows, columns = np.meshgrid(first[0] + np.arange(size[0]), first[1] + np.arange(size[1]), indexing="ij")
    latitude, longitude = centres_deg(crs, cell, rows.ravel(), columns.ravel())
    values = ground_m(latitude, longitude).reshape(size) if heights is None else heights
    driver = "AAIGrid" if path.suffix == ".asc" else "GTiff"
    options = {"driver": driver, "height": size[0], "width": size[1], "count": 1, "dtype": "float32", "nodata": -9999.0}
    options |= {"crs": crs, "transform": transform} | profile
    with rasterio.open(path, "w", **options) as dataset:
        dataset.write(np.where(np.isnan(values), options["nodata"] or np.nan, values).astype(np.float32), 1)
    return path


def centres_deg(
    crs: str, cell: float, rows: NDArray[np.int64], columns: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return latitudes and longitudes of the centres of cells."""
    x0, y0 = _corner(crs, cell)
    longitude, latitude = _to_crs(crs).transform(
        x0 + (columns + 0.5) * cell, y0 - (rows + 0.5) * cell, direction="INVERSE"
    )
    return np.asarray(latitude), np.asarray(longitude)


def _corner(crs: str, cell: float) -> tuple[float, float]:
    """Return x and y of the corner of the grid's first cell: 60 rows and 50 columns before the middle."""
    x, y = _to_crs(crs).transform(PLACE_DEG[1], PLACE_DEG[0])
    return x - 50 * cell, y + 60 * cell


def _to_crs(crs: str) -> Any:
    import pyproj  # noqa: PLC0415 - tests without the extra are skipped

    return pyproj.Transformer.from_crs("EPSG:4326", pyproj.CRS.from_user_input(crs).to_2d(), always_xy=True)


def write_geoid(path: Path, undulation_m: float, slope_m_per_deg: float = 0.0) -> Path:
    """Write a grid of PROJ (GTX) about the middle: rows from south to north, of big-endian numbers."""
    rows, columns, step_deg = 9, 9, 0.25
    south, west = PLACE_DEG[0] - 1.0, PLACE_DEG[1] - 1.0
    values = (
        undulation_m + slope_m_per_deg * (np.arange(rows)[:, np.newaxis] * step_deg - 1.0) + np.zeros((rows, columns))
    )
    path.write_bytes(
        struct.pack(">4d2i", south, west, step_deg, step_deg, rows, columns) + values.astype(">f4").tobytes()
    )
    return path
