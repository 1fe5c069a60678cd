"""Sharper thermal images: what the optics of a microbolometer mix of neighbouring pixels is separated again.

Leaves leave spots of a pixel or two of a body. Their contrast falls to less than a half in a blurred image, so that a
person shows what an animal would. The blur is known, but for some tenths of a pixel, and noise is small beside the
contrast of bodies: the inverse of the blur, limited where noise would win, gives back nearly their own temperatures.
Around what a camera without blur shows, it would leave a rim colder than anything: then the image stays as it is.
"""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

BLUR_PX = 0.55
"""Standard deviation of the point spread function that is assumed; docs/simulator.md names its source."""
_NOISE = 0.01
"""Power of the noise over that of the image, which limits the gain at high frequencies."""
_HALF = 4
"""Coefficients of the filter on each side; those farther out are below 0.001."""
_FREQUENCIES = 256
_WARM_K = 4.0
"""Contrast above the image's median of pixels whose rims are looked at."""
_RIM_K = -4.0
"""Contrast of the coldest parts of rims below which the image has had no such blur: -2 K at most where it has had it,
-6 K and less in simulated images without."""
_RIM_SHARE = 0.05
"""Share of the rims that is colder than that."""
_BACKGROUND_STRIDE = 4


def restored(thermal: NDArray[np.number]) -> NDArray[np.float32]:
    """Return a thermal image, shape (H, W), as before the blur of its optics; pixels without a value stay so.

    An image that shows no such blur is returned as it is.
    """
    image = np.asarray(thermal, dtype=np.float32)
    is_missing = np.isnan(image)
    if has_gaps := bool(is_missing.any()):
        image = np.where(is_missing, np.float32(0.0) if is_missing.all() else np.nanmedian(image), image)
    kernel = _inverse(BLUR_PX)
    sharp = np.asarray(cv2.sepFilter2D(image, -1, kernel, kernel, borderType=cv2.BORDER_REFLECT), dtype=np.float32)
    sharp = image if _has_cold_rims(image, sharp) else sharp
    return np.where(is_missing, np.float32(np.nan), sharp) if has_gaps else sharp


def _has_cold_rims(image: NDArray[np.float32], sharp: NDArray[np.float32]) -> bool:
    """Return whether the sharpened image is colder than forest around what is warm."""
    median = np.median(image[::_BACKGROUND_STRIDE, ::_BACKGROUND_STRIDE])
    warm = (image - median >= _WARM_K).astype(np.uint8)
    rim = cv2.dilate(warm, np.ones((3, 3), np.uint8)) > warm
    return bool(rim.any() and np.quantile(sharp[rim] - median, _RIM_SHARE) < _RIM_K)


@lru_cache(maxsize=4)
def _inverse(blur_px: float) -> NDArray[np.float32]:
    """Return the Wiener filter of a Gaussian blur along one axis; its sum is 1."""
    offset_px = np.arange(-_HALF, _HALF + 1)
    blur = np.exp(-0.5 * (offset_px / blur_px) ** 2)
    blur /= blur.sum()
    phase = 2.0 * np.pi * np.fft.fftfreq(_FREQUENCIES)[:, None] * offset_px
    passed = np.cos(phase) @ blur
    kernel = np.fft.ifft(passed / (passed**2 + _NOISE)).real[offset_px]
    return np.asarray(kernel / kernel.sum(), dtype=np.float32)
