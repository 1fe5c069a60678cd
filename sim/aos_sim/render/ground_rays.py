"""Rays that meet ground that is not level."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aos_sim.render.raycaster import RayCaster
from aos_sim.world.mesh import FloatArray
from aos_sim.world.relief import Relief

HORIZON = -1e-3
"""Vertical component below which a ray meets the ground."""


class GroundRays:
    """Intersections of rays with the ground; immutable, as the caster is.

    Args:
        relief: shape of the ground; None: the plane z = 0, which needs no tracing.
    """

    def __init__(self, relief: Relief | None) -> None:
        self.relief = relief
        self._caster = RayCaster(np.empty((0, 3, 3), np.float32) if relief is None else relief.triangles_enu_m())
        self._lowest_m = 0.0 if relief is None else relief.lowest_m

    def reach(self, origin_m: NDArray[np.float64], directions: FloatArray) -> FloatArray:
        """Return how far rays go to the ground, in lengths of their directions, shape (n,); infinite where to the sky.

        Args:
            origin_m: above the ground, shape (3,).
            directions: shape (n, 3).
        """
        _, reach = self._caster.first_hit_with_distance(origin_m, directions)
        # Rounding lets a ray through between two triangles once in a while; the lowest plane stops it.
        lost = np.flatnonzero(np.isinf(reach) & (directions[:, 2] < HORIZON))
        reach[lost] = np.float32(self._lowest_m - origin_m[2]) / directions[lost, 2]
        return reach
