"""Decoding of camera files into arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_drivers.frames.errors import TornFrameError
from aos_gcs.equal_bands import COLOURS, GREY, without_equal_bands
from aos_gcs.errors import CaptureError, InputDataError
from aos_gcs.image_headers import TIFF_STARTS, TornImageError, as_stored, is_cut_off, picture_sizes
from aos_gcs.radiometry import celsius_from_centikelvin

Image = NDArray[np.uint8] | NDArray[np.uint16] | NDArray[np.float32]

MAX_PIXELS = 100_000_000
"""Default limit for all pages of an image together."""
_EMPTY_BYTES = 64
"""Zeros by which a part of a file is known that is not written yet."""


def decode_image(data: bytes, max_pixels: int = MAX_PIXELS) -> tuple[Image, tuple[str, ...]]:
    """Decode a PNG, JPEG or TIFF file of 8 or 16 bits.

    Returns:
        The image, shape (H, W, C), and one band per channel. A TIFF of two pages, RGB of 8 bits and radiometric
        thermal of 16 bits in hundredths of a kelvin, becomes float32 with ``red, green, blue, thermal``, the last in
        degrees Celsius. Everything else keeps its type and is ``red, green, blue``, or ``grey`` where it has one
        channel or three equal ones.

    Raises:
        TornFrameError: the end of the file is missing.
        CaptureError: the file is damaged or of another kind, or has more than ``max_pixels``; then none is decoded.
    """
    pixels = sum(width * height for width, height in _sizes(data))
    if not 0 < pixels <= max_pixels:
        raise CaptureError(
            f"the image has {pixels / 1e6:.1f} megapixels; the limit is {max_pixels / 1e6:g} (max_image_megapixels)"
        )
    if is_cut_off(data):
        raise TornFrameError(f"the image file of {len(data)} bytes is incomplete")
    try:
        pages = _pages(np.frombuffer(as_stored(data), np.uint8))
    except cv2.error as error:
        raise CaptureError(f"the image file of {len(data)} bytes cannot be decoded: {error.err}") from error
    if not pages:
        raise CaptureError(f"the image file of {len(data)} bytes cannot be decoded")
    return _bands([np.asarray(page) for page in pages])


def _sizes(data: bytes) -> list[tuple[int, int]]:
    try:
        return picture_sizes(data)
    except TornImageError as error:
        raise TornFrameError(str(error)) from error
    except InputDataError as error:
        if _is_unwritten(data):
            raise TornFrameError(f"the image file of {len(data)} bytes is not written yet") from error
        raise CaptureError(str(error)) from error


def _is_unwritten(data: bytes) -> bool:
    """Return whether space was reserved for a file and is not filled yet; the pages of a TIFF are listed at its end."""
    is_tiff = data[:2] in TIFF_STARTS
    return not any(data[:_EMPTY_BYTES]) or (is_tiff and not any(data[-_EMPTY_BYTES:]))


def _pages(data: NDArray[np.uint8]) -> Sequence[NDArray[Any]]:
    """Return the pages of a TIFF, or the one image of another file: a PNG may hold an animation of any length."""
    if data[:2].tobytes() in TIFF_STARTS:
        return cv2.imdecodemulti(data, cv2.IMREAD_UNCHANGED)[1]
    image = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    return [] if image is None else [image]


def _bands(pages: list[NDArray[Any]]) -> tuple[Image, tuple[str, ...]]:
    shapes = [(page.shape, page.dtype) for page in pages]
    match [(page.ndim, page.dtype) for page in pages]:
        case [(3, np.uint8), (2, np.uint16)] if pages[0].shape == (*pages[1].shape, 3):
            return _rgb_and_thermal(pages[0], pages[1]), (*COLOURS, "thermal")
        case [(2, np.uint8 | np.uint16)]:
            return pages[0][..., np.newaxis], GREY
        case [(3, np.uint8 | np.uint16)] if pages[0].shape[2] in (3, 4):
            image = without_equal_bands(np.ascontiguousarray(pages[0][..., 2::-1]))
            return image, GREY if image.shape[2] == 1 else COLOURS
    raise CaptureError(f"an image with pages of {shapes} is not understood: send RGB, grey, or RGB with thermal")


def _rgb_and_thermal(bgr: NDArray[Any], thermal_centikelvin: NDArray[Any]) -> NDArray[np.float32]:
    image = np.empty((*thermal_centikelvin.shape, 4), np.float32)
    image[..., :3] = bgr[..., ::-1]
    image[..., 3] = celsius_from_centikelvin(thermal_centikelvin)
    return image
