"""Pictures in three bands that are the same picture, as thermal cameras write them."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

GREY, COLOURS = ("grey",), ("red", "green", "blue")
"""Bands of a picture of one channel, and of three."""

_SAMPLE_STEP_PX = 16


def without_equal_bands(pixels: NDArray[Any]) -> NDArray[Any]:
    """Return the first channel, shape (H, W, 1), of an image whose three channels are all the same, else the image.

    As three bands it would be the same evidence three times.
    """
    if pixels.shape[2] != 3:
        return pixels
    # Most pictures of colours differ in the first few pixels that are looked at.
    sample = pixels[::_SAMPLE_STEP_PX, ::_SAMPLE_STEP_PX]
    if not np.array_equal(sample[..., 1:], sample[..., :-1]):
        return pixels
    # Plane by plane: numpy compares along a very short axis many times as slowly.
    first, *others = cv2.split(pixels)
    return first[:, :, np.newaxis] if all(np.array_equal(first, other) for other in others) else pixels
