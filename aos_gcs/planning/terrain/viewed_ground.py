"""Ground that a search looks at: how far below the altitude layers each place is, from which its views are predicted.

Level layers see less of the upper end of a slope, and more of its lower one, than of level ground. The ground is held
as a coarse raster over the search area, so that it is small enough to be handed to a worker.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.polygon import Polygon
from aos_gcs.airspace.reference_surface import FINEST_STEP_M, LEVEL, ReferenceSurface
from aos_gcs.airspace.terrain import GroundRaster

FloatArray = NDArray[np.float64]

_MOST_NODES: Final = 100
"""Nodes along each axis."""


@dataclass(frozen=True, slots=True, eq=False)
class ViewedGround:
    """Ground of a search area, and the surface that its altitude layers are offset from."""

    ground: ReferenceSurface
    """Heights above the origin; NaN where the ground is not known."""
    layers: ReferenceSurface

    @property
    def is_level(self) -> bool:
        """Whether layers are everywhere as high above the ground as above the origin."""
        return self.ground is LEVEL and self.layers.is_level and self.layers.lowest_m == 0.0

    def rises_m(self, places_enu_m: FloatArray) -> FloatArray:
        """Return by how much places, shape (n, 2), are nearer to the layers above them than level ground would be."""
        return self.ground.height_m(places_enu_m) - self.layers.height_m(places_enu_m)


LEVEL_GROUND: Final = ViewedGround(LEVEL, LEVEL)
"""Level ground at the height of the origin, below level layers."""


def viewed_ground(area_enu_m: Polygon, ground: GroundRaster | None, layers: ReferenceSurface | None) -> ViewedGround:
    """Return the ground of a search area.

    Args:
        area_enu_m: search area.
        ground: ground as the vehicles see it; None: it counts as level.
        layers: surface that the altitude layers are offset from; None: it is not known yet, and counts as level.
    """
    if ground is None or not area_enu_m:
        return LEVEL_GROUND
    corners_m = np.array(area_enu_m, dtype=np.float64)
    (west_m, south_m), extent_m = corners_m.min(axis=0).tolist(), np.ptp(corners_m, axis=0)
    step_m = max(FINEST_STEP_M, float(extent_m.max()) / (_MOST_NODES - 1))
    columns, rows = (math.ceil(along_m / step_m) + 1 for along_m in extent_m.tolist())
    east_m, north_m = np.meshgrid(west_m + step_m * np.arange(columns), south_m + step_m * np.arange(rows))
    heights_m = ground.heights_at(np.column_stack((east_m.ravel(), north_m.ravel()))).reshape(rows, columns)
    return ViewedGround(ReferenceSurface(west_m, south_m, step_m, heights_m), layers or LEVEL)
