"""Areas of polygons that overlap, by counting cells."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.polygon import Polygon

CELLS_ALONG = 400
"""Cells along the longer side: an area is known to about a quarter of a per cent per edge."""


@dataclass(frozen=True, slots=True, eq=False)
class PlanRaster:
    """A north-up grid around a polygon."""

    west_m: float
    north_m: float
    resolution_m: float
    shape: tuple[int, int]

    @classmethod
    def around(cls, polygon_enu_m: Polygon) -> PlanRaster:
        """Return the grid around a polygon."""
        points_m = np.array(polygon_enu_m)
        low_m, high_m = points_m.min(axis=0), points_m.max(axis=0)
        extent_m = high_m - low_m
        resolution_m = float(extent_m.max()) / CELLS_ALONG
        rows, columns = (max(1, math.ceil(extent / resolution_m)) for extent in extent_m[::-1])
        return cls(float(low_m[0]), float(high_m[1]), resolution_m, (rows, columns))

    def inside(self, polygons_enu_m: Sequence[Polygon]) -> NDArray[np.bool_]:
        """Return which cells lie in at least one of the polygons, shape (rows, columns)."""
        mask = np.zeros(self.shape, dtype=np.uint8)
        for polygon_enu_m in polygons_enu_m:
            east_m, north_m = np.array(polygon_enu_m).T
            columns, rows = (east_m - self.west_m) / self.resolution_m, (self.north_m - north_m) / self.resolution_m
            # A cell's centre has integer coordinates in OpenCV.
            corners = np.column_stack((columns, rows)) - 0.5
            cv2.fillPoly(mask, [np.clip(np.round(corners), -30_000, 30_000).astype(np.int32)], 1)
        return mask.astype(np.bool_)

    def area_m2(self, cells: NDArray[np.bool_]) -> float:
        """Return the area of some cells."""
        return float(np.count_nonzero(cells)) * self.resolution_m**2
