"""Sharper thermal images: what the optics of a microbolometer mix of neighbouring pixels is separated again.

Leaves leave spots of a pixel or two of a body. Their contrast falls to less than a half in a blurred image, so that a
person shows what an animal would. The blur is known, but for some tenths of a pixel, and noise is small beside the
contrast of bodies: the inverse of the blur, limited where noise would win, gives back nearly their own temperatures.
Around what a camera with less blur shows, it would leave a rim colder than anything: then the image stays as it is.
Optics out of focus leave no fine texture anywhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

BLUR_PX = 0.55
"""Standard deviation of the point spread function that is assumed; docs/simulator.md names its source."""
WIDE_BLUR_PX = 1.1
"""Standard deviation of that of optics out of focus, which an image has to show."""
_NOISE = 0.01
"""Power of the noise over that of the image, which limits the gain at high frequencies."""
_WIDE_NOISE = 0.02
"""The same where less of the image is left at high frequencies."""
_HALF = 8
"""Coefficients of the filter on each side; those farther out are below 0.02, and below 0.001 without a wide blur."""
_FREQUENCIES = 256
_WARM_K = 4.0
"""Contrast above the image's median of pixels whose rims are looked at."""
_RIM_K = -4.0
"""Contrast of the coldest parts of rims below which the image has had no such blur: -2 K at most where it has had it,
-6 K and less in simulated images without."""
_WIDE_RIM = -0.22
"""The same for the wide blur, as a share of the contrast of what is warm: -0.20 to -0.06 where it has had it, -0.60 to
-0.30 in images with the usual one (nine of ten simulated ones each)."""
_RIM_SHARE = 0.05
"""Share of the rims that is colder than that."""
_RIM_PIXELS = 12
"""Pixels of rims from which on they tell a wide blur."""
_CROP_PX = 32
"""Half of the side of the part about the warmest body that tells it."""
_TILE_PX = 128
"""Side of the parts of an image whose texture is looked at: four near the corners and the middle."""
_COARSE, _FINE, _FINEST = (0.09, 0.14), (0.22, 0.28), (0.47, 0.5)
"""Bands of spatial frequency, cycles per pixel, of which the wide blur passes two thirds, a quarter and nothing."""
_SOFT = 0.06
"""Power of fine over that of coarse texture below which optics are out of focus: 0.02 to 0.04 in simulated forests with
the wide blur, 0.09 to 0.21 with the usual one."""
_TEXTURE_K = 2.0
"""Contrast up to which something is texture and no body."""
_BACKGROUND_STRIDE = 4


@dataclass(frozen=True, slots=True, eq=False)
class Restored:
    """A thermal image without the blur of its optics."""

    image: NDArray[np.float32]
    """Shape (H, W)."""
    out_of_focus: bool = False
    """Whether its optics were: then small spots are still cooler than what they show."""


def restored(thermal: NDArray[np.number]) -> Restored:
    """Return a thermal image, shape (H, W), as before the blur of its optics; pixels without a value stay so.

    The blur is the usual one, or that of optics out of focus where texture and the warmest body show it. An image that
    shows neither is returned as it is.
    """
    image = np.asarray(thermal, dtype=np.float32)
    is_missing = np.isnan(image)
    if has_gaps := bool(is_missing.any()):
        image = np.where(is_missing, np.float32(0.0) if is_missing.all() else np.nanmedian(image), image)
    median = float(np.median(image[::_BACKGROUND_STRIDE, ::_BACKGROUND_STRIDE]))
    if out_of_focus := _is_out_of_focus(image, median):
        sharp = _sharpened(image, WIDE_BLUR_PX, _WIDE_NOISE)
    else:
        sharp = _sharpened(image, BLUR_PX, _NOISE)
        rims_k = _rims_k(image, sharp, median)
        if len(rims_k) and np.quantile(rims_k, _RIM_SHARE) < _RIM_K:
            sharp = image
    return Restored(np.where(is_missing, np.float32(np.nan), sharp) if has_gaps else sharp, out_of_focus)


def _is_out_of_focus(image: NDArray[np.float32], median: float) -> bool:
    """Tell whether fine texture is lost, and the wide blur, taken back, leaves no cold rim about the warmest body."""
    row, column = np.unravel_index(int(np.argmax(cv2.blur(image, (5, 5)))), image.shape)
    rows, columns = (slice(max(0, int(middle) - _CROP_PX), int(middle) + _CROP_PX) for middle in (row, column))
    crop = image[rows, columns]
    sharp = _sharpened(crop, WIDE_BLUR_PX, _NOISE)
    rims_k = _rims_k(crop, sharp, median)
    if len(rims_k) < _RIM_PIXELS:
        return False
    warm_k = float(np.quantile((sharp - median)[crop - median >= _WARM_K], 0.9))
    # The texture of a whole image costs more than one rim, which hardly any sharper image passes.
    return bool(np.quantile(rims_k, _RIM_SHARE) >= _WIDE_RIM * warm_k) and _is_soft(image, median)


def _is_soft(image: NDArray[np.float32], median: float) -> bool:
    """Tell whether an image of usual size has next to no fine texture where it has coarse one."""
    rows, columns = (size - _TILE_PX for size in image.shape)
    if min(rows, columns) < 0:
        return False
    starts = ((0.25, 0.25), (0.25, 0.75), (0.75, 0.25), (0.75, 0.75), (0.5, 0.5))
    window, power = _window(), np.zeros((_TILE_PX, _TILE_PX // 2 + 1))
    for down, right in starts:
        row, column = round(down * rows), round(right * columns)
        tile = np.clip(image[row : row + _TILE_PX, column : column + _TILE_PX] - median, -_TEXTURE_K, _TEXTURE_K)
        power += np.abs(np.fft.rfft2((tile - tile.mean()) * window)) ** 2
    coarse, fine, noise = (float(power[band].mean()) for band in _bands())
    return fine - noise < _SOFT * (coarse - noise)


@lru_cache(maxsize=1)
def _window() -> NDArray[np.float32]:
    side = np.hanning(_TILE_PX)
    return np.asarray(np.outer(side, side), dtype=np.float32)


@lru_cache(maxsize=1)
def _bands() -> tuple[NDArray[np.bool], ...]:
    """Return the coefficients of a tile's spectrum in each band."""
    frequency = np.hypot(np.fft.fftfreq(_TILE_PX)[:, None], np.fft.rfftfreq(_TILE_PX)[None, :])
    return tuple((frequency >= low) & (frequency < high) for low, high in (_COARSE, _FINE, _FINEST))


def _rims_k(image: NDArray[np.float32], sharp: NDArray[np.float32], median: float) -> NDArray[np.float32]:
    """Return the contrast of a sharpened image around what is warm."""
    warm = (image - median >= _WARM_K).astype(np.uint8)
    rim = cv2.dilate(warm, np.ones((3, 3), np.uint8)) > warm
    return np.asarray(sharp[rim] - median, dtype=np.float32)


def _sharpened(image: NDArray[np.float32], blur_px: float, noise: float) -> NDArray[np.float32]:
    kernel = _inverse(blur_px, noise)
    return np.asarray(cv2.sepFilter2D(image, -1, kernel, kernel, borderType=cv2.BORDER_REFLECT), dtype=np.float32)


@lru_cache(maxsize=4)
def _inverse(blur_px: float, noise: float) -> NDArray[np.float32]:
    """Return the Wiener filter of a Gaussian blur along one axis; its sum is 1."""
    offset_px = np.arange(-_HALF, _HALF + 1)
    blur = np.exp(-0.5 * (offset_px / blur_px) ** 2)
    blur /= blur.sum()
    phase = 2.0 * np.pi * np.fft.fftfreq(_FREQUENCIES)[:, None] * offset_px
    passed = np.cos(phase) @ blur
    kernel = np.fft.ifft(passed / (passed**2 + noise)).real[offset_px]
    return np.asarray(kernel / kernel.sum(), dtype=np.float32)
