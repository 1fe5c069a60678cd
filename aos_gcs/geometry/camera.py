"""The pinhole camera model."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class CameraModel:
    """Ideal pinhole camera; pixel centres lie at integer coordinates (u to the right, v down)."""

    width_px: int
    height_px: int
    fx_px: float
    fy_px: float
    cx_px: float
    cy_px: float

    @classmethod
    def from_fov(cls, width_px: int, height_px: int, horizontal_fov_rad: float) -> CameraModel:
        """Camera with square pixels, its principal point in the image centre.

        Raises:
            ValueError: if the size is not positive or the field of view is not within (0, pi).
        """
        if width_px < 1 or height_px < 1:
            raise ValueError(f"image size must be positive, got {width_px} x {height_px}")
        if not 0.0 < horizontal_fov_rad < math.pi:
            raise ValueError(f"field of view must lie within (0, pi) rad, got {horizontal_fov_rad}")
        focal_px = width_px / 2 / math.tan(horizontal_fov_rad / 2)
        return cls(width_px, height_px, focal_px, focal_px, (width_px - 1) / 2, (height_px - 1) / 2)

    @property
    def K(self) -> NDArray[np.float64]:
        """Intrinsic matrix, shape (3, 3): camera coordinates (right, down, forward) to homogeneous pixels."""
        return np.array([[self.fx_px, 0.0, self.cx_px], [0.0, self.fy_px, self.cy_px], [0.0, 0.0, 1.0]])

    @property
    def horizontal_fov_rad(self) -> float:
        """Full horizontal field of view."""
        return 2 * math.atan(self.width_px / 2 / self.fx_px)
