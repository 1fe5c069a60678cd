"""Directions from which a place was looked at: which of its views pass the canopy through gaps of their own.

Two lines of sight to one place, whose horizontal distances per metre of height differ by t, pass the canopy at height z
at a distance z t from each other. Occluders of the size d hide the place from both while that is less than d: views
repeat each other below t = d / z (the rule of :mod:`aos_gcs.imaging.aperture`, after Kurmi, Schedl and Bimber, IEEE
Sensors Journal 19(20), 2019), whatever the height they are taken from. What hides a person is finer than the twigs that
hide the ground as a whole: d is ``GAP_SHARE`` of their size, as fitted to simulated forests (docs/ground-map.md).

Directions are sorted into squares of that edge, and a view counts where its square is new. Two views that differ by
(t_x, t_y) fall into different squares with the probability 1 - (1 - |t_x| z / d) (1 - |t_y| z / d) over all places of
the squares: one minus the share that the shadows of a square occluder have in common, which is the model's correlation.
Between neighbouring cells of the ground the squares lie elsewhere, so that a mean over cells is not biased.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.aperture import smallest_spacing_m

MAX_TANGENT: Final = 1.0
"""Largest horizontal distance per metre of height of a view that counts, on both axes: 45 degrees off the nadir."""
FINEST_STEP: Final = 1.0 / 32.0
"""Smallest edge of a square; a finer canopy is counted with it, which gives too few views rather than too many."""
GAP_SHARE: Final = 0.25
"""Size of what hides a person from one direction and not from another, as a share of the occluders' size."""
USUAL_STEP: Final = FINEST_STEP
"""Edge of a square for a forest that nobody has described: occluders of 1.4 m at a height of 11.2 m."""


def direction_step(crown_base_m: float, canopy_height_m: float, occluder_size_m: float) -> float:
    """Return the difference of two directions, as tangents, from which on a canopy hides them independently.

    Args:
        crown_base_m: height at which crowns begin, above the ground.
        canopy_height_m: height of the tree tops.
        occluder_size_m: diameter of what hides the ground as a whole.

    Raises:
        ConfigurationError: if a number is out of its range.
    """
    occluder_height_m = (crown_base_m + canopy_height_m) / 2.0
    above_m = 2.0 * canopy_height_m
    return GAP_SHARE * smallest_spacing_m(above_m, occluder_height_m, occluder_size_m) / above_m


@dataclass(frozen=True, slots=True)
class ViewDirections:
    """Squares of directions.

    Args:
        step: edge of a square; clipped to what is counted.
    """

    step: float

    @property
    def side(self) -> int:
        """Number of squares on each axis."""
        return 2 * math.ceil(MAX_TANGENT / max(self.step, FINEST_STEP))

    @property
    def byte_count(self) -> int:
        """Number of bytes that hold one bit per square."""
        return (self.side**2 + 7) // 8

    def squares(
        self, camera_enu_m: NDArray[np.float64], cells_enu_m: NDArray[np.float64]
    ) -> tuple[NDArray[np.int32], NDArray[np.bool_]]:
        """Return the squares in which a camera lies as seen from cells.

        Args:
            camera_enu_m: position of the camera, shape (3,).
            cells_enu_m: cells of the ground, shape (..., 3); NaN where the ground is not known.

        Returns:
            Index of the square, shape (...), and where the view counts: not too flat, and from above.
        """
        offset_m = camera_enu_m - cells_enu_m
        with np.errstate(divide="ignore", invalid="ignore"):
            tangents = offset_m[..., :2] / offset_m[..., 2:]
            counts = (offset_m[..., 2] > 0.0) & (np.abs(tangents) < MAX_TANGENT).all(axis=-1)
        step = max(self.step, FINEST_STEP)
        half = self.side // 2
        indices = np.floor(np.where(counts[..., np.newaxis], tangents, 0.0) / step).astype(np.int32) + half
        return indices[..., 1] * self.side + indices[..., 0], counts
