"""Errors of an uncooled thermal camera: noise, patterns of its pixels, and an offset that drifts and jumps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_sim.errors.sizes import check_sizes

_SHADING_KNOTS = 5
"""Shading is interpolated between so many random values per axis: smooth over a quarter of the image."""


@dataclass(frozen=True, slots=True)
class ThermalErrors:
    """Sizes of the errors, standard deviations in kelvin.

    Raises:
        ConfigurationError: a value is negative.
    """

    netd_k: float = 0.0
    """Noise of a pixel from frame to frame."""
    offset_k: float = 0.0
    """Offset of the whole image that stays with a camera: its calibration."""
    shading_k: float = 0.0
    """Smooth over the image, per camera: lens and housing glow."""
    column_k: float = 0.0
    """Fixed pattern of the read-out, one value per column and camera."""
    pixel_k: float = 0.0
    """Fixed pattern, one value per pixel and camera."""
    nuc_period_s: float = 180.0
    """Time between two shutter calibrations (non-uniformity corrections, NUC)."""
    nuc_step_k: float = 0.0
    """Offset that is left after a NUC; another one after each."""
    drift_k_per_min: float = 0.0
    """Speed at which the offset drifts from one NUC to the next; another one after each."""

    def __post_init__(self) -> None:
        check_sizes(self, "thermal", positive=("nuc_period_s",))


def draw_thermal_pattern(
    rng: np.random.Generator, errors: ThermalErrors, shape: tuple[int, int]
) -> NDArray[np.float32]:
    """Draw what stays with one camera, in kelvin, shape (H, W): offset, shading, columns and pixels."""
    height, width = shape
    knots = rng.standard_normal((_SHADING_KNOTS, _SHADING_KNOTS)).astype(np.float32) * np.float32(errors.shading_k)
    shading = cv2.resize(knots, (width, height), interpolation=cv2.INTER_CUBIC)
    columns = rng.standard_normal(width, dtype=np.float32) * np.float32(errors.column_k)
    offset = np.float32(rng.standard_normal() * errors.offset_k)
    pixels = rng.standard_normal(shape, dtype=np.float32) * np.float32(errors.pixel_k)
    return np.asarray(shading + columns + offset + pixels, dtype=np.float32)


def thermal_drift_k(errors: ThermalErrors, seed: tuple[int, ...], at_s: float) -> float:
    """Return one camera's offset at a moment beside the one that stays: it drifts, and jumps at each NUC.

    Args:
        errors: sizes.
        seed: of the camera.
        at_s: seconds since the camera has started.
    """
    phase_s = float(np.random.default_rng([*seed, 0xF0]).uniform(0.0, errors.nuc_period_s))
    calibrations, since_s = divmod(at_s + phase_s, errors.nuc_period_s)
    step, speed = np.random.default_rng([*seed, 0xF1, math.floor(calibrations)]).standard_normal(2)
    return float(step * errors.nuc_step_k + speed * errors.drift_k_per_min * since_s / 60.0)
