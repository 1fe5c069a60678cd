"""Terrain as a focal surface: a regular grid of heights."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

MAX_MARCH_STEPS = 64
"""Along a ray between the terrain's lowest and highest point; narrower ridges than one step may be looked through."""

_Array: TypeAlias = NDArray[np.float64]

_REFINEMENTS = 24
_TOLERANCE_M = 1e-7


@dataclass(frozen=True, slots=True, eq=False)
class Terrain:
    """Heights on a regular grid of any Cartesian world, bilinear in between.

    Raises:
        ValueError: if there are fewer than 2 x 2 samples, the spacing is not positive, or no height is known.
    """

    x_m: float
    """x coordinate of the samples in column 0."""
    y_m: float
    """y coordinate of the samples in row 0."""
    spacing_m: float
    """Distance between samples, on both axes; columns follow +x and rows +y."""
    heights_m: NDArray[np.float64]
    """z of the samples, shape (rows, columns); NaN where it is unknown."""

    def __post_init__(self) -> None:
        if self.heights_m.ndim != 2 or min(self.heights_m.shape) < 2:
            raise ValueError(f"a terrain needs at least 2 x 2 heights, got shape {self.heights_m.shape}")
        if not self.spacing_m > 0.0:
            raise ValueError(f"the spacing of a terrain must be positive, got {self.spacing_m}")
        if not np.isfinite(self.heights_m).any():
            raise ValueError("a terrain needs at least one known height")

    def moved(self, z_m: float) -> Terrain:
        """Return the terrain shifted along z."""
        return replace(self, heights_m=self.heights_m + z_m)

    @property
    def lower_m(self) -> NDArray[np.float64]:
        """Corner of the bounding box with the smallest coordinates, shape (3,)."""
        return np.array([self.x_m, self.y_m, np.nanmin(self.heights_m)])

    @property
    def upper_m(self) -> NDArray[np.float64]:
        """Corner of the bounding box with the largest coordinates, shape (3,)."""
        rows, columns = self.heights_m.shape
        x_m, y_m = self.x_m + (columns - 1) * self.spacing_m, self.y_m + (rows - 1) * self.spacing_m
        return np.array([x_m, y_m, np.nanmax(self.heights_m)])

    def z_m(self, x_m: ArrayLike, y_m: ArrayLike) -> NDArray[np.float64]:
        """Return z at horizontal positions of any shape; NaN outside and beside unknown heights."""
        columns, rows = np.broadcast_arrays(
            (np.asarray(x_m, dtype=np.float64) - self.x_m) / self.spacing_m,
            (np.asarray(y_m, dtype=np.float64) - self.y_m) / self.spacing_m,
        )
        # By attribute: SciPy imports its parts when they are first used, and most processes have no terrain.
        flat = scipy.ndimage.map_coordinates(
            self.heights_m, (rows.ravel(), columns.ravel()), order=1, mode="constant", cval=np.nan
        )
        return np.asarray(flat, dtype=np.float64).reshape(rows.shape)

    def intersect(self, origin_m: ArrayLike, rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return where rays first meet the terrain, shape (n, 3); NaN where they never do.

        Args:
            origin_m: origin of all rays, shape (3,), on either side of the terrain.
            rays: directions, shape (n, 3).
        """
        origin = np.asarray(origin_m, dtype=np.float64)
        # Rays must be able to pass the lowest and the highest point, which may be those of a level terrain.
        margin = np.array([0.0, 0.0, self.spacing_m])
        start, end = _inside_box(origin, rays, self.lower_m - margin, self.upper_m + margin)
        points = np.full(rays.shape, np.nan)
        hits = np.flatnonzero(start < end)
        if hits.size:
            rays = rays[hits]
            near, far, bracketed = self._march(origin, rays, start[hits], end[hits])
            rays, hits = rays[bracketed], hits[bracketed]
            points[hits] = origin + self._refine(origin, rays, near[bracketed], far[bracketed])[:, np.newaxis] * rays
        return points

    def _clearance_m(self, origin: NDArray[np.float64], rays: NDArray[np.float64], at: NDArray[np.float64]) -> _Array:
        points = origin + at[:, np.newaxis] * rays
        return points[:, 2] - self.z_m(points[:, 0], points[:, 1])

    def _march(
        self, origin: NDArray[np.float64], rays: NDArray[np.float64], start: _Array, end: _Array
    ) -> tuple[_Array, _Array, NDArray[np.bool]]:
        """Return the last position before each ray's first crossing, the next one, and which rays cross at all."""
        travel_m = float(((end - start) * np.hypot(rays[:, 0], rays[:, 1])).max())
        steps = int(np.clip(np.ceil(travel_m / self.spacing_m), 2, MAX_MARCH_STEPS))
        near, far = start.copy(), end.copy()
        # Rounding must not put the very first and last points just outside of the box: those are known to lie inside.
        inset = 1e-9 * (end - start)
        positions, step = start + inset, (end - start - 2.0 * inset) / steps
        clearance = self._clearance_m(origin, rays, positions)
        active = np.arange(len(rays))
        crossed = np.zeros(len(rays), dtype=np.bool)
        for _ in range(steps):
            following = positions + step
            next_clearance = self._clearance_m(origin, rays[active], following)
            crosses = clearance * next_clearance <= 0.0
            near[active[crosses]], far[active[crosses]] = positions[crosses], following[crosses]
            crossed[active[crosses]] = True
            ongoing = ~crosses
            active, positions, step = active[ongoing], following[ongoing], step[ongoing]
            clearance = next_clearance[ongoing]
            if not active.size:
                break
        return near, far, crossed

    def _refine(self, origin: NDArray[np.float64], rays: NDArray[np.float64], near: _Array, far: _Array) -> _Array:
        """Return the crossings within brackets: regula falsi with the Illinois rule, all rays at once."""
        f_near, f_far = self._clearance_m(origin, rays, near), self._clearance_m(origin, rays, far)
        at = far
        for _ in range(_REFINEMENTS):
            span = f_far - f_near
            at = near - f_near * (far - near) / np.where(span == 0.0, 1.0, span)
            f_at = self._clearance_m(origin, rays, at)
            if np.nanmax(np.abs(f_at), initial=0.0) < _TOLERANCE_M:
                break
            opposite = f_at * f_far < 0.0
            # The end that stays has its value halved, so that it cannot stay for ever.
            near, f_near = np.where(opposite, far, near), np.where(opposite, f_far, f_near / 2.0)
            far, f_far = at, f_at
        return np.asarray(at)


def _inside_box(origin: _Array, rays: _Array, lower: _Array, upper: _Array) -> tuple[_Array, _Array]:
    """Return where rays enter and leave a box, in multiples of themselves; the end is not behind the start if never."""
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = (lower - origin) / rays, (upper - origin) / rays
    # A ray along a face of the box (0 / 0) is inside as far as that axis is concerned.
    start = np.nan_to_num(np.minimum(one, other), nan=-np.inf).max(axis=1)
    end = np.nan_to_num(np.maximum(one, other), nan=np.inf).min(axis=1)
    finite = np.isfinite(rays).all(axis=1)
    return np.where(finite, np.maximum(start, 0.0), np.inf), np.where(finite, end, -np.inf)
