"""Bands of a camera that stay the same while single frames look otherwise."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.equal_bands import COLOURS, GREY

GREY_FRAMES = 10
"""Grey frames in a row from which a camera of colours is taken for a grey one."""


class SteadyBands:
    """Bands of one camera, frame by frame.

    A frame of a colour camera that is black, saturated or very dark has three equal channels and is read as grey. The
    frames of a step must have the same bands, so that such a frame gets its three bands back.
    """

    def __init__(self) -> None:
        self._has_colours = False
        self._grey_in_a_row = 0

    def settle(self, image: NDArray[Any], bands: tuple[str, ...]) -> tuple[NDArray[Any], tuple[str, ...]]:
        """Return the camera's next image, shape (H, W, C), in the bands of the camera."""
        if bands != GREY:
            self._has_colours, self._grey_in_a_row = bands == COLOURS, 0
            return image, bands
        self._grey_in_a_row += 1
        if self._grey_in_a_row >= GREY_FRAMES:
            self._has_colours = False
        return (np.repeat(image, len(COLOURS), axis=2), COLOURS) if self._has_colours else (image, bands)
