"""The shape of ground that is not level: a height field of triangles, beyond whose edge the ground goes on level.

Frame: ENU metres, the origin lies on the ground. Two triangles to a cell, so that the same ground is met by rays, which
are traced against the triangles, and by feet, trunks and landing gears, which ask for its height.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aos_sim.world.mesh import FloatArray

Float = TypeVar("Float", bound=np.floating[Any])

_FAR_M = 10_000.0
"""Distance that the ground reaches beyond its edge: farther than cameras see."""
_HALVINGS = 24
"""Halvings of the part of a ray that can meet the ground: a kilometre becomes less than a millimetre."""


@dataclass(frozen=True, slots=True, eq=False)
class Relief:
    """Heights at the corners of square cells. The diagonal of a cell runs from its south-east to its north-west."""

    heights_m: NDArray[np.float64]
    """Heights above the origin, shape (rows, columns), two of each at least; row 0 is the southern edge."""
    west_m: float
    """East coordinate of column 0."""
    south_m: float
    """North coordinate of row 0."""
    cell_m: float

    @property
    def lowest_m(self) -> float:
        """Height of the lowest place."""
        return float(self.heights_m.min())

    @property
    def highest_m(self) -> float:
        """Height of the highest place."""
        return float(self.heights_m.max())

    def height_m(self, east_m: ArrayLike, north_m: ArrayLike) -> NDArray[np.float64]:
        """Return the heights of places, of their common shape."""
        return self._plane(east_m, north_m)[0]

    def gradient(self, east_m: ArrayLike, north_m: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the rise towards east and towards north, metres per metre; level beyond the edge."""
        _, rise_east, rise_north = self._plane(east_m, north_m)
        east, north = np.broadcast_arrays(np.asarray(east_m, np.float64), np.asarray(north_m, np.float64))
        rows, columns = self.heights_m.shape
        inside_east = (east >= self.west_m) & (east <= self.west_m + (columns - 1) * self.cell_m)
        inside_north = (north >= self.south_m) & (north <= self.south_m + (rows - 1) * self.cell_m)
        return np.where(inside_east, rise_east, 0.0), np.where(inside_north, rise_north, 0.0)

    def normal(self, east_m: ArrayLike, north_m: ArrayLike) -> NDArray[np.float64]:
        """Return unit vectors out of the ground, shape (..., 3)."""
        rise_east, rise_north = self.gradient(east_m, north_m)
        upwards = np.stack([-rise_east, -rise_north, np.ones_like(rise_east)], axis=-1)
        return np.asarray(upwards / np.linalg.norm(upwards, axis=-1, keepdims=True))

    def lifted(self, points_enu_m: NDArray[Float]) -> NDArray[Float]:
        """Return points above level ground, shape (..., 3), as high above this ground at their own places."""
        lifted = points_enu_m.copy()
        lifted[..., 2] += self.height_m(points_enu_m[..., 0], points_enu_m[..., 1]).astype(lifted.dtype)
        return lifted

    def triangles_enu_m(self) -> FloatArray:
        """Return the triangles of the ground and of what lies beyond its edge, shape (n, 3, 3)."""
        rows, columns = self.heights_m.shape
        east = _with_far_ends(self.west_m + self.cell_m * np.arange(columns))
        north = _with_far_ends(self.south_m + self.cell_m * np.arange(rows))
        corners = np.dstack([*np.meshgrid(east, north), np.pad(self.heights_m, 1, mode="edge")]).astype(np.float32)
        south_west, south_east = corners[:-1, :-1], corners[:-1, 1:]
        north_west, north_east = corners[1:, :-1], corners[1:, 1:]
        lower = np.stack([south_west, south_east, north_west], axis=2)
        upper = np.stack([north_east, north_west, south_east], axis=2)
        return np.concatenate([lower.reshape(-1, 3, 3), upper.reshape(-1, 3, 3)])

    def reach(self, origin_m: NDArray[np.floating], directions: NDArray[np.floating]) -> NDArray[np.float64]:
        """Return how far rays from above go to the ground, in lengths of their directions, shape of them without axes.

        Made for a ground that they meet once. Those that do not look down never do: infinite.

        Args:
            origin_m: above the ground, shape (3,).
            directions: shape (..., 3).
        """
        along = directions.astype(np.float64)
        falls = along[..., 2] < 0.0
        down = np.where(falls, along[..., 2], -1.0)
        near, far = (np.maximum((height_m - origin_m[2]) / down, 0.0) for height_m in (self.highest_m, self.lowest_m))
        for _ in range(_HALVINGS):
            middle = (near + far) / 2
            ground_m = self.height_m(origin_m[0] + middle * along[..., 0], origin_m[1] + middle * along[..., 1])
            is_below = origin_m[2] + middle * down < ground_m
            near, far = np.where(is_below, near, middle), np.where(is_below, middle, far)
        return np.where(falls, far, np.inf)

    def _plane(
        self, east_m: ArrayLike, north_m: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return the height, and the rise towards east and north, of the triangle at each place, or next to it."""
        rows, columns = self.heights_m.shape
        column = np.clip((np.asarray(east_m, np.float64) - self.west_m) / self.cell_m, 0.0, columns - 1.0)
        row = np.clip((np.asarray(north_m, np.float64) - self.south_m) / self.cell_m, 0.0, rows - 1.0)
        first_column = np.minimum(column.astype(np.intp), columns - 2)
        first_row = np.minimum(row.astype(np.intp), rows - 2)
        across, along = column - first_column, row - first_row
        south_east, north_west = (
            self.heights_m[first_row, first_column + 1],
            self.heights_m[first_row + 1, first_column],
        )
        is_lower = across + along <= 1.0
        corner = np.where(
            is_lower, self.heights_m[first_row, first_column], self.heights_m[first_row + 1, first_column + 1]
        )
        rise_east = np.where(is_lower, south_east - corner, corner - north_west)
        rise_north = np.where(is_lower, north_west - corner, corner - south_east)
        from_corner = np.where(is_lower, 0.0, 1.0)
        height = corner + rise_east * (across - from_corner) + rise_north * (along - from_corner)
        return height, rise_east / self.cell_m, rise_north / self.cell_m


def ground_below(position_enu_m: NDArray[np.float64], relief: Relief | None) -> NDArray[np.float64]:
    """Return the heights of the ground below places, shape (n, 3), as an array (n,); without relief it is level."""
    if relief is None:
        return np.zeros(len(position_enu_m))
    return relief.height_m(position_enu_m[:, 0], position_enu_m[:, 1])


def _with_far_ends(coordinates_m: NDArray[Float]) -> NDArray[Float]:
    return np.concatenate([[coordinates_m[0] - _FAR_M], coordinates_m, [coordinates_m[-1] + _FAR_M]])
