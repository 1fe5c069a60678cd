"""Pictures in three bands that are the same picture, as thermal cameras write them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

GREY, COLOURS = ("grey",), ("red", "green", "blue")
"""Bands of a picture of one channel, and of three."""

_SAMPLE_STEP_PX = 16


def without_equal_bands(pixels: NDArray[Any], tolerance: float = 0.0) -> NDArray[Any]:
    """Return the first channel, shape (H, W, 1), of an image whose three channels are all the same, else the image.

    As three bands it would be the same evidence three times.

    Args:
        pixels: the image, shape (H, W, C).
        tolerance: difference of two channels that is none.
    """
    if pixels.shape[2] != 3:
        return pixels
    # Most pictures of colours differ in the first few pixels that are looked at.
    if not _are_equal(cv2.split(pixels[::_SAMPLE_STEP_PX, ::_SAMPLE_STEP_PX]), tolerance):
        return pixels
    # Plane by plane: numpy compares along a very short axis many times as slowly.
    planes = cv2.split(pixels)
    return planes[0][:, :, np.newaxis] if _are_equal(planes, tolerance) else pixels


def _are_equal(planes: Sequence[NDArray[Any]], tolerance: float) -> bool:
    first, *others = planes
    return all(cv2.absdiff(first, other).max() <= tolerance for other in others)
