"""The ground below a mission: a raster over its local frame, and how far straight segments are above it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_SHIFT_BITS = 8
"""Fractional bits of corners in OpenCV."""


@dataclass(frozen=True, slots=True)
class Polynomials:
    """Several cubic polynomials of two coordinates, which are scaled to about 1."""

    scale: float
    coefficients: FloatArray
    """Shape (10, m)."""

    @classmethod
    def fitted(cls, inputs: FloatArray, outputs: FloatArray) -> Polynomials:
        """Return the polynomials that fit outputs, shape (n, m), at inputs, shape (n, 2)."""
        scale = max(1e-9, float(np.abs(inputs).max()))
        coefficients, *_ = np.linalg.lstsq(_powers(inputs / scale), outputs, rcond=None)
        return cls(scale, np.asarray(coefficients, dtype=np.float64))

    def at(self, inputs: FloatArray) -> FloatArray:
        """Return the values at inputs, shape (n, 2), as shape (n, m)."""
        return np.asarray(_powers(inputs / self.scale) @ self.coefficients)


def _powers(inputs: FloatArray) -> FloatArray:
    x, y = inputs[:, 0], inputs[:, 1]
    xx, yy, xy = x * x, y * y, x * y
    return np.column_stack((np.ones(len(x)), x, y, xx, xy, yy, xx * x, xx * y, yy * x, yy * y))


@dataclass(frozen=True, slots=True)
class GroundCells:
    """Cells of a raster, with what the ground in each is between."""

    places_enu_m: FloatArray
    """Centres of the cells, shape (n, 2)."""
    lowest_m: FloatArray
    """Heights above the origin, shape (n,); NaN where they are not known."""
    highest_m: FloatArray


@dataclass(frozen=True, eq=False)
class GroundRaster:
    """Lowest and highest ground of every cell of a raster; no ground in a cell lies outside of them.

    Heights are metres above the mission's origin, along its up axis.
    """

    lowest_m: NDArray[np.float32]
    """Heights above the origin, on a level surface; NaN where the model has a hole. Shape (rows, columns)."""
    highest_m: NDArray[np.float32]
    to_cells: Polynomials
    """Row, column and drop of the level surface below the local frame's plane, of east and north in metres."""
    to_enu: Polynomials
    """East and north in metres, of row and column."""
    offsets_m: tuple[float, float] = (0.0, 0.0)
    """What is to be added to the lowest and to the highest ground, as launch points show it."""

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        rows, columns = self.highest_m.shape
        return rows, columns

    @cached_property
    def bottom_m(self) -> float:
        """Height above the origin that no known ground is below; 0 where none is known."""
        if np.isnan(self.lowest_m).all():
            return 0.0
        rows, columns = self.shape
        corners = np.array([(row, column) for row in (0.0, rows) for column in (0.0, columns)])
        drop_m = float(self.to_cells.at(self.to_enu.at(corners))[:, 2].max())
        return float(np.nanmin(self.lowest_m)) - max(0.0, drop_m) + self.offsets_m[0]

    def bounds_at(self, places_enu_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the lowest and the highest ground in the cells of places, shape (n, 2); NaN where it is not known."""
        cells = self.to_cells.at(np.asarray(places_enu_m, dtype=np.float64))
        return self._bounds(np.floor(cells[:, 0]), np.floor(cells[:, 1]), cells[:, 2])

    def heights_at(self, places_enu_m: FloatArray) -> FloatArray:
        """Return the middle between both bounds at places, shape (n, 2); NaN where the ground is not known."""
        return np.asarray(np.mean(self.bounds_at(places_enu_m), axis=0))

    def model_height_m(self, place_enu_m: FloatArray) -> float:
        """Return the height of the ground at a place, shape (2,), by the model alone; NaN where it is not known."""
        lowest_m, highest_m = self.bounds_at(place_enu_m[None, :])
        return float(lowest_m[0] - self.offsets_m[0] + highest_m[0] - self.offsets_m[1]) / 2.0

    def highest_around(self, places_enu_m: FloatArray, reach_m: float) -> FloatArray:
        """Return the highest known ground near places, shape (n, 2); NaN where none is known.

        Args:
            places_enu_m: the places.
            reach_m: distance along east and north up to which ground counts.
        """
        corners_m = reach_m * np.array([(0.0, 0.0), (-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)])
        middle_m = places_enu_m.mean(axis=0)
        spans = np.abs(np.diff(self.to_cells.at(middle_m + corners_m)[[0, 1, 0, 2], :2], axis=0)[::2]).max(axis=0)
        half_rows, half_columns = (np.ceil(spans).astype(np.int64) + 1).tolist()
        known_m = np.where(np.isnan(self.highest_m), -np.inf, self.highest_m).astype(np.float32)
        padded_m = cv2.copyMakeBorder(
            known_m, half_rows, half_rows, half_columns, half_columns, cv2.BORDER_CONSTANT, value=-np.inf
        )
        highest_m = cv2.dilate(padded_m, np.ones((2 * half_rows + 1, 2 * half_columns + 1), dtype=np.uint8))
        cells = self.to_cells.at(np.asarray(places_enu_m, dtype=np.float64))
        rows, columns = self.shape
        row = np.floor(cells[:, 0]).astype(np.int64) + half_rows
        column = np.floor(cells[:, 1]).astype(np.int64) + half_columns
        is_near = (row >= 0) & (row < rows + 2 * half_rows) & (column >= 0) & (column < columns + 2 * half_columns)
        found_m = highest_m[np.where(is_near, row, 0), np.where(is_near, column, 0)].astype(np.float64)
        found_m = found_m - cells[:, 2] + self.offsets_m[1]
        return np.where(is_near & np.isfinite(found_m), found_m, np.nan)

    def within(self, outlines_enu_m: Sequence[FloatArray]) -> GroundCells:
        """Return the cells that polygons, shape (k, 2), touch. What lies beyond the raster counts as not known."""
        corners = [self.to_cells.at(np.asarray(outline_m, dtype=np.float64))[:, :2] for outline_m in outlines_enu_m]
        least = np.floor(np.min([each.min(axis=0) for each in corners], axis=0)).astype(np.int64) - 1
        most = np.ceil(np.max([each.max(axis=0) for each in corners], axis=0)).astype(np.int64) + 1
        mask = np.zeros(tuple(most - least + 1), dtype=np.uint8)
        for each in corners:
            pixels = (each - least - 0.5)[:, ::-1]
            fixed = np.round(pixels * 2**_SHIFT_BITS).astype(np.int32)
            cv2.fillPoly(mask, [fixed], 1, shift=_SHIFT_BITS)
        cells = np.argwhere(cv2.dilate(mask, np.ones((3, 3), dtype=np.uint8))) + least
        places_m = self.to_enu.at(cells + 0.5)
        drop_m = self.to_cells.at(places_m)[:, 2]
        lowest_m, highest_m = self._bounds(cells[:, 0].astype(np.float64), cells[:, 1].astype(np.float64), drop_m)
        return GroundCells(places_m, lowest_m, highest_m)

    def along(self, starts_enu_m: FloatArray, ends_enu_m: FloatArray) -> GroundProfile:
        """Return the ground below straight segments, shape (n, 3) each, in intervals of a metre of climb at most."""
        ends = self.to_cells.at(np.vstack((starts_enu_m[:, :2], ends_enu_m[:, :2])))[:, :2]
        ways = np.abs(ends[len(starts_enu_m) :] - ends[: len(starts_enu_m)]).max(axis=1)
        climbs_m = np.abs(ends_enu_m[:, 2] - starts_enu_m[:, 2])
        counts = np.maximum(1, np.ceil(np.maximum(2.0 * ways, climbs_m))).astype(np.int64)
        # All samples of all segments in one array: a segment has one more than it has intervals.
        rows = np.repeat(np.arange(len(counts)), counts + 1)
        firsts = np.concatenate(([0], np.cumsum(counts + 1)[:-1]))
        fractions = (np.arange(len(rows)) - firsts[rows]) / counts[rows]
        places_m = starts_enu_m[rows] + fractions[:, None] * (ends_enu_m - starts_enu_m)[rows]
        cells = self.to_cells.at(places_m[:, :2])
        row, column = np.floor(cells[:, 0]), np.floor(cells[:, 1])
        begins = np.flatnonzero(np.diff(rows, append=-1) == 0)
        # Between two samples less than a cell apart a segment touches no cells but these.
        around = [self._bounds(row[begins + i], column[begins + j], cells[begins, 2]) for i in (0, 1) for j in (0, 1)]
        return GroundProfile(
            segments=rows[begins],
            fractions=fractions[begins],
            places_enu_m=places_m[begins],
            least_up_m=np.minimum(places_m[begins, 2], places_m[begins + 1, 2]),
            most_up_m=np.maximum(places_m[begins, 2], places_m[begins + 1, 2]),
            lowest_m=np.fmin.reduce([lowest_m for lowest_m, _ in around]),
            highest_m=np.fmax.reduce([highest_m for _, highest_m in around]),
            is_known=np.logical_and.reduce([np.isfinite(highest_m) for _, highest_m in around]),
        )

    def _bounds(self, row: FloatArray, column: FloatArray, drop_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        rows, columns = self.shape
        is_inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        inside = np.where(is_inside, row, 0).astype(np.int64), np.where(is_inside, column, 0).astype(np.int64)
        low_m, high_m = (np.where(is_inside, heights[inside], np.nan) for heights in (self.lowest_m, self.highest_m))
        return low_m - drop_m + self.offsets_m[0], high_m - drop_m + self.offsets_m[1]


@dataclass(frozen=True, slots=True)
class GroundProfile:
    """Intervals of segments, one after the other, each with the ground below it; arrays of one length."""

    segments: NDArray[np.int64]
    """Segment of each interval."""
    fractions: FloatArray
    """Share of the segment that lies before the interval."""
    places_enu_m: FloatArray
    """Begin of the interval, shape (n, 3)."""
    least_up_m: FloatArray
    most_up_m: FloatArray
    lowest_m: FloatArray
    """Lowest ground that is known; NaN if none is."""
    highest_m: FloatArray
    is_known: NDArray[np.bool_]
    """Whether all the ground below the interval is known."""
