"""Errors of lenses, exposures and files: blur, motion, vignetting, noise of the colour sensor, JPEG."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_sim.errors.sizes import check_sizes

FloatArray = NDArray[np.float32]

_LEAST_SMEAR_PX = 0.3
"""Motion during an exposure below this changes nothing that a pixel could show."""
_MAX_SMEAR_PX = 40.0
_BEST_QUALITY = 100


@dataclass(frozen=True, slots=True)
class OpticsErrors:
    """Sizes of the errors.

    Raises:
        ConfigurationError: a value is out of its range.
    """

    thermal_blur_px: float = 0.0
    """Standard deviation of the thermal camera's point spread function."""
    colour_blur_px: float = 0.0
    colour_noise: float = 0.0
    """Standard deviation of a pixel's noise, in grey levels of 255."""
    vignetting: float = 0.0
    """Share of the colour image's light that is missing in the corners."""
    exposure_s: float = 0.0
    """Exposure time of the colour camera, over which motion smears."""
    thermal_lag_s: float = 0.0
    """Time constant of a microbolometer, over which motion smears."""
    jpeg_quality: int = 0
    """Quality of the colour images' compression, 1 to 100; 0: none."""

    def __post_init__(self) -> None:
        check_sizes(self, "optics")
        if self.vignetting > 1.0:
            raise ConfigurationError(f"optics.vignetting must be at most 1, got {self.vignetting}.")
        if self.jpeg_quality > _BEST_QUALITY:
            raise ConfigurationError(f"optics.jpeg_quality must be at most {_BEST_QUALITY}, got {self.jpeg_quality}.")


def blurred(image: FloatArray, deviation_px: float) -> FloatArray:
    """Return an image as through a lens with a Gaussian point spread function."""
    if deviation_px == 0.0:
        return image
    size = 2 * max(1, math.ceil(3.0 * deviation_px)) + 1
    return np.asarray(cv2.GaussianBlur(image, (size, size), deviation_px, borderType=cv2.BORDER_REFLECT))


def smeared(image: FloatArray, motion_px: tuple[float, float]) -> FloatArray:
    """Return an image that moves evenly by ``motion_px`` (right, down) during its exposure."""
    return image if _length(motion_px) < _LEAST_SMEAR_PX else _filtered(image, _line_kernel(motion_px, None))


def lagged(image: FloatArray, motion_px: tuple[float, float]) -> FloatArray:
    """Return an image that moves by ``motion_px`` (right, down) in the time constant of its sensor."""
    if _length(motion_px) < _LEAST_SMEAR_PX:
        return image
    right, down = motion_px
    return _filtered(image, _line_kernel((3.0 * right, 3.0 * down), _length(motion_px)))


@lru_cache(maxsize=8)
def vignette(shape: tuple[int, int], missing_share: float) -> FloatArray:
    """Return the share of light that each colour of a pixel gets, shape (H, W, 3): falls with the distance squared."""
    height, width = shape
    rows = np.linspace(-1.0, 1.0, height, dtype=np.float32)[:, None]
    columns = np.linspace(-1.0, 1.0, width, dtype=np.float32)[None, :]
    return np.repeat((1.0 - np.float32(missing_share) * (rows**2 + columns**2) / 2.0)[..., None], 3, axis=2)


def compressed(rgb: NDArray[np.uint8], quality: int) -> NDArray[np.uint8]:
    """Return a colour image, shape (H, W, 3), as it comes out of a JPEG file."""
    # The order of the channels matters: JPEG keeps brightness better than colour.
    _, data = cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), (cv2.IMWRITE_JPEG_QUALITY, quality))
    decoded = np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR), dtype=np.uint8)
    return np.asarray(cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB), dtype=np.uint8)


def _length(motion_px: tuple[float, float]) -> float:
    return math.hypot(*motion_px)


def _filtered(image: FloatArray, kernel: FloatArray) -> FloatArray:
    return np.asarray(cv2.filter2D(image, -1, kernel, borderType=cv2.BORDER_REFLECT))


def _line_kernel(motion_px: tuple[float, float], decay_px: float | None) -> FloatArray:
    """Kernel of a correlation along a motion: even about the middle, or from there on decaying over ``decay_px``."""
    length = min(_length(motion_px), _MAX_SMEAR_PX)
    direction = np.array(motion_px) / _length(motion_px)
    along = np.linspace(0.0, length, max(2, math.ceil(8 * length)))
    weights = np.ones_like(along) if decay_px is None else np.exp(-along / decay_px)
    start = along - length / 2.0 if decay_px is None else along
    half = math.ceil(length) + 1
    kernel = np.zeros((2 * half + 1, 2 * half + 1), np.float64)
    x, y = half + start * direction[0], half + start * direction[1]
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    right_share, lower_share = x - left, y - top
    for row, column, share in (
        (top, left, (1 - lower_share) * (1 - right_share)),
        (top, left + 1, (1 - lower_share) * right_share),
        (top + 1, left, lower_share * (1 - right_share)),
        (top + 1, left + 1, lower_share * right_share),
    ):
        np.add.at(kernel, (row, column), weights * share)
    return np.asarray(kernel / kernel.sum(), dtype=np.float32)
