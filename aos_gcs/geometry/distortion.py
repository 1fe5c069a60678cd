"""Lens distortion between ideal (pinhole) and real image coordinates.

Both are *normalised*: (x / z, y / z) of a point in camera coordinates, before focal lengths and principal point.

Sources: Brown, *Close-range camera calibration*, Photogrammetric Engineering 37(8), 1971; Kannala and Brandt, *A
generic camera model and calibration method for conventional, wide-angle, and fish-eye lenses*, IEEE TPAMI 28(8), 2006;
both with OpenCV's order of coefficients.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

MAX_ANGLE_RAD = math.radians(75.0)
"""Off the optical axis, beyond which distorted lenses are not used: a pixel there covers 15 times the ground of one at
nadir, and the ideal image would grow without bound."""

_TABLE_SIZE = 512
_NEWTON_STEPS = 12
_TOLERANCE = 1e-9
"""Error of a solution, normalised; a millionth of a pixel at a focal length of 1000 pixels."""


class LensModel(StrEnum):
    """Model of a lens's deviation from a pinhole."""

    BROWN_CONRADY = "brown-conrady"
    """Coefficients k1, k2, p1, p2, k3."""
    FISHEYE = "fisheye"
    """Equidistant; coefficients k1, k2, k3, k4."""


COEFFICIENTS = {LensModel.BROWN_CONRADY: 5, LensModel.FISHEYE: 4}


@dataclass(frozen=True, slots=True)
class LensDistortion:
    """The distortion of one lens.

    Raises:
        ValueError: if the number of coefficients does not fit the model, or one is not finite.
    """

    model: LensModel
    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.coefficients) != COEFFICIENTS[self.model]:
            raise ValueError(
                f"the {self.model} model has {COEFFICIENTS[self.model]} coefficients, got {len(self.coefficients)}"
            )
        if not all(math.isfinite(value) for value in self.coefficients):
            raise ValueError(f"distortion coefficients must be finite, got {self.coefficients}")

    @property
    def max_radius(self) -> float:
        """Normalised radius of ideal points beyond which nothing is imaged.

        Where the radial polynomial turns back, points from outside would be imaged a second time.
        """
        return _max_radius(self)

    def distort(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the real image of ideal points; both of shape (..., 2). NaN beyond :attr:`max_radius`."""
        ideal = np.asarray(points, dtype=np.float64)
        with np.errstate(invalid="ignore"):
            inside = np.hypot(ideal[..., 0], ideal[..., 1]) <= self.max_radius
        return np.where(inside[..., np.newaxis], self._distort(np.where(inside[..., np.newaxis], ideal, 0.0)), np.nan)

    def undistort(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the ideal points that are imaged at real ones; both of shape (..., 2). NaN where there is none."""
        real = np.asarray(points, dtype=np.float64)
        radii, real_radii = _radial_table(self)
        real_radius = np.hypot(real[..., 0], real[..., 1])
        # Without the tangential part the table has the solution already; Newton's method adds digits and that part.
        scale = np.interp(real_radius, real_radii, radii) / np.where(real_radius > 0.0, real_radius, 1.0)
        ideal = real * scale[..., np.newaxis]
        # Points that no ideal one is imaged at may run away to infinity; the test below finds them.
        with np.errstate(over="ignore", invalid="ignore"):
            for _ in range(_NEWTON_STEPS):
                ideal = ideal - self._newton_step(ideal, self._distort(ideal) - real)
        solved = np.abs(self.distort(ideal) - real).max(axis=-1) < _TOLERANCE
        return np.where(solved[..., np.newaxis], ideal, np.nan)

    def _distort(self, ideal: NDArray[np.float64]) -> NDArray[np.float64]:
        x, y = ideal[..., 0], ideal[..., 1]
        r2 = x * x + y * y
        if self.model is LensModel.FISHEYE:
            r = np.sqrt(r2)
            scale = np.where(r > 0.0, _fisheye_radius(self.coefficients, np.arctan(r)) / np.where(r > 0.0, r, 1.0), 1.0)
            return np.asarray(ideal * scale[..., np.newaxis])
        k1, k2, p1, p2, k3 = self.coefficients
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        return np.stack(
            (
                x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
            ),
            axis=-1,
        )

    def _newton_step(self, ideal: NDArray[np.float64], residual: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return J⁻¹ residual, with the Jacobian from central differences."""
        h = 1e-6
        step_x, step_y = np.array([h, 0.0]), np.array([0.0, h])
        along_x = (self._distort(ideal + step_x) - self._distort(ideal - step_x)) / (2.0 * h)
        along_y = (self._distort(ideal + step_y) - self._distort(ideal - step_y)) / (2.0 * h)
        (a, c), (b, d) = np.moveaxis(along_x, -1, 0), np.moveaxis(along_y, -1, 0)
        determinant = a * d - b * c
        determinant = np.where(np.abs(determinant) > 1e-12, determinant, np.nan)
        e, f = residual[..., 0], residual[..., 1]
        return np.stack(((d * e - b * f) / determinant, (a * f - c * e) / determinant), axis=-1)


def _fisheye_radius(coefficients: tuple[float, ...], theta: NDArray[np.float64]) -> NDArray[np.float64]:
    k1, k2, k3, k4 = coefficients
    t2 = theta * theta
    return np.asarray(theta * (1.0 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4)))))


@lru_cache(maxsize=64)
def _max_radius(lens: LensDistortion) -> float:
    if lens.model is LensModel.FISHEYE:
        return math.tan(_growing_until(lens.coefficients, MAX_ANGLE_RAD))
    k1, k2, _, _, k3 = lens.coefficients
    return _growing_until((k1, k2, k3), math.tan(MAX_ANGLE_RAD))


def _growing_until(radial: tuple[float, ...], limit: float) -> float:
    """Return the first s in (0, limit] where s + k1 s³ + k2 s⁵ + ... stops growing, or the limit."""
    powers = np.zeros(2 * len(radial) + 1)
    powers[0] = 1.0
    powers[2::2] = [(2 * i + 3) * k for i, k in enumerate(radial)]
    slope = np.polynomial.Polynomial(powers)
    samples = np.linspace(0.0, limit, _TABLE_SIZE)
    falling = np.flatnonzero(slope(samples) <= 0.0)
    if not falling.size:
        return limit
    rising_at, falling_at = samples[falling[0] - 1 : falling[0] + 1].tolist()
    while rising_at < (middle := 0.5 * (rising_at + falling_at)) < falling_at:
        rising_at, falling_at = (middle, falling_at) if slope(middle) > 0.0 else (rising_at, middle)
    return float(rising_at)


@lru_cache(maxsize=64)
def _radial_table(lens: LensDistortion) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return ideal radii and the real radii they are imaged at without tangential distortion, both growing."""
    radii = np.tan(np.linspace(0.0, math.atan(lens.max_radius), _TABLE_SIZE))
    if lens.model is LensModel.FISHEYE:
        return radii, _fisheye_radius(lens.coefficients, np.arctan(radii))
    k1, k2, _, _, k3 = lens.coefficients
    return radii, radii * (1.0 + radii**2 * (k1 + radii**2 * (k2 + radii**2 * k3)))
