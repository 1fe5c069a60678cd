"""Triangle meshes of the ground as grids of heights."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.surfaces.terrain import Terrain

DEFAULT_SAMPLES = 4_000_000
"""Number of heights of the grid: for a terrain of 120 m this is a height every 6 cm, exact but in the cells that edges
cross."""

_CHUNK = 100_000
"""Pairs of a triangle and a sample worked on at a time: about as many as fit into the caches of a processor."""


def terrain_from_mesh(
    vertices_m: NDArray[np.float64], triangles: NDArray[np.intp], spacing_m: float | None = None
) -> Terrain:
    """Resample a mesh that is a function of x and y; samples that no triangle covers are NaN.

    Args:
        vertices_m: shape (v, 3).
        triangles: indices of vertices, shape (t, 3), in either order of rotation. Where several lie one above the
            other, any of them counts.
        spacing_m: distance of the grid's heights; None: as fine as :data:`DEFAULT_SAMPLES` allow.

    Raises:
        ValueError: if the mesh covers no sample.
    """
    lower, upper = vertices_m[:, :2].min(axis=0), vertices_m[:, :2].max(axis=0)
    if spacing_m is None:
        spacing_m = float(np.sqrt(np.prod(upper - lower) / DEFAULT_SAMPLES))
    if not spacing_m > 0.0:
        raise ValueError("the mesh has no horizontal extent")
    columns, rows = np.floor((upper - lower) / spacing_m + 1e-9).astype(int) + 1
    heights = np.full((rows, columns), np.nan)
    corners = vertices_m[triangles]
    corners[:, :, :2] = (corners[:, :, :2] - lower) / spacing_m
    first = np.maximum(np.ceil(corners[:, :, :2].min(axis=1) - 1e-9), 0).astype(int)
    last = np.minimum(np.floor(corners[:, :, :2].max(axis=1) + 1e-9), [columns - 1, rows - 1]).astype(int)
    sizes = np.maximum(last - first + 1, 0)
    pairs = np.cumsum(sizes[:, 0] * sizes[:, 1])
    begin = 0
    while begin < len(pairs):
        done = pairs[begin - 1] if begin else 0
        end = max(begin + 1, int(np.searchsorted(pairs, done + _CHUNK)))
        _fill(heights, corners[begin:end], first[begin:end], sizes[begin:end])
        begin = end
    return Terrain(float(lower[0]), float(lower[1]), spacing_m, heights)


def _fill(
    heights: NDArray[np.float64], corners: NDArray[np.float64], first: NDArray[np.intp], sizes: NDArray[np.intp]
) -> None:
    """Write the heights of the samples inside triangles, whose corners are (column, row, z), shape (t, 3, 3)."""
    counts = sizes[:, 0] * sizes[:, 1]
    within = (np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)).astype(np.int32)
    rows, columns = np.divmod(within, np.repeat(sizes[:, 0].astype(np.int32), counts))
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = np.moveaxis(corners, 0, -1)
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    area[area == 0.0] = np.nan
    dx, dy = first[:, 0] - ax, first[:, 1] - ay

    def over_samples(at_first: NDArray[np.float64], by_column: NDArray[np.float64], by_row: NDArray[np.float64]) -> Any:
        """Return what is linear in column and row, at all samples."""
        return np.repeat(at_first, counts) + np.repeat(by_column, counts) * columns + np.repeat(by_row, counts) * rows

    share_b = over_samples((dx * (cy - ay) - dy * (cx - ax)) / area, (cy - ay) / area, (ax - cx) / area)
    share_c = over_samples((dy * (bx - ax) - dx * (by - ay)) / area, (ay - by) / area, (bx - ax) / area)
    inside = (share_b >= -1e-9) & (share_c >= -1e-9) & (share_b + share_c <= 1.0 + 1e-9)
    z = np.repeat(az, counts) + share_b * np.repeat(bz - az, counts) + share_c * np.repeat(cz - az, counts)
    row, column = rows + np.repeat(first[:, 1], counts), columns + np.repeat(first[:, 0], counts)
    heights[row[inside], column[inside]] = z[inside]
