"""Frames of large photographs, reduced to what a search of persons needs."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.imaging.model import Frame

Image = NDArray[np.uint8] | NDArray[np.uint16] | NDArray[np.float32]
MAX_PIXELS = 2_100_000
"""Largest size of a frame: pictures of 20 megapixels from 60 m keep pixels of 7 cm, of which a person has dozens."""


def reduced(frame: Frame, max_pixels: int = MAX_PIXELS) -> Frame:
    """Return a frame of at most so many pixels, each the mean of a square of its own."""
    rows, columns, bands = frame.image.shape
    factor = math.ceil(math.sqrt(rows * columns / max_pixels))
    if factor <= 1:
        return frame
    size = columns // factor, rows // factor
    whole = frame.image[: size[1] * factor, : size[0] * factor]
    mean = cv2.resize(whole, size, interpolation=cv2.INTER_AREA).reshape(*size[::-1], bands)
    image = np.asarray(mean, dtype=frame.image.dtype)
    return replace(frame, image=cast("Image", image), camera=reduced_camera(frame.camera, factor))


def reduced_camera(camera: CameraModel, factor: int) -> CameraModel:
    """Return the camera of images whose pixels are squares of ``factor`` pixels each."""
    return CameraModel(
        width_px=camera.width_px // factor,
        height_px=camera.height_px // factor,
        fx_px=camera.fx_px / factor,
        fy_px=camera.fy_px / factor,
        cx_px=(camera.cx_px + 0.5) / factor - 0.5,
        cy_px=(camera.cy_px + 0.5) / factor - 0.5,
        distortion=camera.distortion,
    )
