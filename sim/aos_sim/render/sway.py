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
_LEVEL = np.float32(0.0)


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
        field_m = crowns / crowns.std() * np.float32(crown_m) + white[1] * np.float32(twig_m)
        # Per metre of height, one row per axis.
        self._field_m = np.ascontiguousarray(field_m.reshape(-1, 2).T / np.float32(_TOP_M))

    def shear(
        self,
        origin_m: NDArray[np.float64],
        directions: FloatArray,
        at_s: float,
        ground_m: FloatArray | np.float32 = _LEVEL,
    ) -> tuple[FloatArray, FloatArray]:
        """Return rays that meet the resting forest where the given ones meet the swaying one, both (n, 3).

        Distances along them, in lengths of the direction, are the same. Rays that do not look down stay as they are.

        Args:
            origin_m: of all rays, shape (3,).
            directions: shape (n, 3).
            at_s: moment, which decides the sway.
            ground_m: height of the ground that the trees of each ray stand on, shape (n,) or ().
        """
        origin = origin_m.astype(np.float32)
        down = directions[:, 2]
        above_ground_m = origin[2] - ground_m
        reach = (np.float32(_MIDDLE_M) - above_ground_m) / np.minimum(down, np.float32(_DOWNWARDS))
        offset = np.random.default_rng([self._seed, 0x5B, int(at_s / STILL_S)]).integers(0, _CELLS, 2)
        column, row = (_cells(origin[axis] + reach * directions[:, axis], int(offset[axis])) for axis in (0, 1))
        sways = down <= _DOWNWARDS
        cell = row * _CELLS + column
        origins, sheared = np.empty_like(directions), np.empty_like(directions)
        origins[:, 2], sheared[:, 2] = origin[2], down
        # One axis at a time: arrays of two columns take several times as long.
        for axis, field_m in enumerate(self._field_m):
            sway_m = field_m[cell] * sways
            origins[:, axis] = origin[axis] - sway_m * above_ground_m
            sheared[:, axis] = directions[:, axis] - sway_m * down
        return origins, sheared


def _cells(along_m: FloatArray, offset: int) -> NDArray[np.int32]:
    """Return the row or column of each place in the field, which repeats itself."""
    return np.asarray((np.floor(along_m / np.float32(_CELL_M)).astype(np.int32) + offset) % _CELLS, dtype=np.int32)
