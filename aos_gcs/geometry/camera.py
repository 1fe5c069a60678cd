"""The camera model: a pinhole, with or without the distortion of a lens."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aos_gcs.geometry.distortion import LensDistortion

_OUTLINE_SAMPLES = 129
"""Pixels per axis that the extent of an undistorted image is found from."""


@dataclass(frozen=True, slots=True)
class CameraModel:
    """Pinhole camera; pixel centres lie at integer coordinates (u to the right, v down)."""

    width_px: int
    height_px: int
    fx_px: float
    fy_px: float
    cx_px: float
    cy_px: float
    distortion: LensDistortion | None = None
    """None: an ideal pinhole."""

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
        """Intrinsic matrix, shape (3, 3): camera coordinates (right, down, forward) to homogeneous ideal pixels."""
        return np.array([[self.fx_px, 0.0, self.cx_px], [0.0, self.fy_px, self.cy_px], [0.0, 0.0, 1.0]])

    @property
    def horizontal_fov_rad(self) -> float:
        """Full horizontal field of view, distortion left out."""
        return 2 * math.atan(self.width_px / 2 / self.fx_px)

    def to_pixels(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return pixels (u, v) of normalised points (x / z, y / z), shapes (..., 2); NaN where the lens images none."""
        normalised = np.asarray(points, dtype=np.float64)
        if self.distortion is not None:
            normalised = self.distortion.distort(normalised)
        return np.asarray(normalised * [self.fx_px, self.fy_px] + [self.cx_px, self.cy_px])

    def from_pixels(self, pixels: ArrayLike) -> NDArray[np.float64]:
        """Inverse of :meth:`to_pixels`; NaN for pixels that no point is imaged at."""
        normalised = (np.asarray(pixels, dtype=np.float64) - [self.cx_px, self.cy_px]) / [self.fx_px, self.fy_px]
        return normalised if self.distortion is None else self.distortion.undistort(normalised)

    def ideal(self) -> CameraModel:
        """Return the smallest ideal camera of the same focal lengths that holds everything this one sees.

        Its pixels are whole pixels away from those of this camera's own ideal image; a camera without distortion
        returns itself.
        """
        return self if self.distortion is None else _ideal(self)


@lru_cache(maxsize=64)
def _ideal(camera: CameraModel) -> CameraModel:
    u, v = np.meshgrid(
        np.linspace(-0.5, camera.width_px - 0.5, _OUTLINE_SAMPLES),
        np.linspace(-0.5, camera.height_px - 0.5, _OUTLINE_SAMPLES),
    )
    pinhole = replace(camera, distortion=None)
    pixels = pinhole.to_pixels(camera.from_pixels(np.stack((u, v), axis=-1)))
    first_u, first_v = np.floor(np.nanmin(pixels, axis=(0, 1)) + 0.5)
    last_u, last_v = np.ceil(np.nanmax(pixels, axis=(0, 1)) - 0.5)
    return replace(
        pinhole,
        width_px=int(last_u - first_u) + 1,
        height_px=int(last_v - first_v) + 1,
        cx_px=camera.cx_px - float(first_u),
        cy_px=camera.cy_px - float(first_v),
    )
