"""Trees that sway in the wind: every ray meets the forest sheared by the sway at the place where it enters the canopy.

A shear keeps rays straight, so that swaying trees cost no other mesh: the ray is sheared instead. The ground, and what
stands on it, stays where it is. Crowns sway together over metres, twigs over half a metre; from one moment to the next
both are drawn afresh.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_sim.errors.wind import Wind
from aos_sim.world.mesh import FloatArray

STILL_S = 0.5
"""Images of the same interval show the same sway; those of different ones have nothing in common."""
_TOP_M = 18.0
"""Height to which the sway belongs; it grows with the height."""
_MIDDLE_M = 12.0
"""Height at which the place of a ray counts."""
_CELL_M = 0.5
_CELLS = 256
_CROWN_CELLS = 4.0
"""Standard deviation of the filter that makes sways of crowns from white noise, in cells."""
_DOWNWARDS = -0.05


class Sway:
    """The sway of one forest.

    Args:
        wind: how much it sways.
        seed: of the draws.
    """

    def __init__(self, wind: Wind, seed: int) -> None:
        self._seed = seed
        crown_m, twig_m = wind.sway_m
        self.moves = crown_m > 0.0 or twig_m > 0.0
        rng = np.random.default_rng([seed, 0x5A])
        white = rng.standard_normal((2, _CELLS, _CELLS, 2)).astype(np.float32)
        border = 3 * int(_CROWN_CELLS)
        wrapped = np.pad(white[0], ((border, border), (border, border), (0, 0)), mode="wrap")
        crowns = cv2.GaussianBlur(wrapped, (0, 0), _CROWN_CELLS)[border:-border, border:-border]
        self._field_m = crowns / crowns.std() * np.float32(crown_m) + white[1] * np.float32(twig_m)

    def shear(
        self, origin_m: NDArray[np.float64], directions: FloatArray, at_s: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return rays that meet the resting forest where the given ones meet the swaying one, both (n, 3).

        Distances along them, in lengths of the direction, are the same. Rays that do not look down stay as they are.

        Args:
            origin_m: of all rays, shape (3,).
            directions: shape (n, 3).
            at_s: moment, which decides the sway.
        """
        origin = origin_m.astype(np.float32)
        reach = (np.float32(_MIDDLE_M) - origin[2]) / np.minimum(directions[:, 2], np.float32(_DOWNWARDS))
        offset = np.random.default_rng([self._seed, 0x5B, int(at_s / STILL_S)]).integers(0, _CELLS, 2)
        cells = np.floor((origin[:2] + reach[:, None] * directions[:, :2]) / np.float32(_CELL_M)).astype(np.intp)
        column, row = ((cells + offset) % _CELLS).T
        sway_m = self._field_m[row, column] / np.float32(_TOP_M)
        sway_m[directions[:, 2] > _DOWNWARDS] = 0.0
        origins = np.broadcast_to(origin, directions.shape).copy()
        sheared = directions.copy()
        origins[:, :2] -= sway_m * origin[2]
        sheared[:, :2] -= sway_m * directions[:, 2:]
        return origins, sheared
