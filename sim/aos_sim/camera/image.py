"""Images of a pose as the bytes of a file."""

from __future__ import annotations

from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.radiometry import centikelvin_from_celsius

_TIFF_UNCOMPRESSED = (cv2.IMWRITE_TIFF_COMPRESSION, 1)


class RenderedImage(Protocol):
    """Colour and thermal image of one exposure."""

    @property
    def rgb(self) -> NDArray[np.uint8]:
        """Shape (H, W, 3)."""
        ...

    @property
    def thermal_celsius(self) -> NDArray[np.float32]:
        """Shape (H, W)."""
        ...


class ImageSource(Protocol):
    """Anything that can take a picture. Called from worker threads, several at a time."""

    def render(self, pose: Pose, camera: CameraModel, rng: np.random.Generator) -> RenderedImage:
        """Return what ``camera`` sees from ``pose``; ``rng`` is for the sensor's noise alone."""
        ...


def encode_tiff(image: RenderedImage) -> bytes:
    """Return a TIFF of two pages: RGB as uint8, and temperature as uint16 in units of 0.01 K.

    Raises:
        ValueError: the image cannot be encoded.
    """
    # OpenCV takes colour channels in the order blue, green, red and writes them as RGB.
    bgr, thermal_ck = np.ascontiguousarray(image.rgb[:, :, ::-1]), centikelvin_from_celsius(image.thermal_celsius)
    encoded, data = cv2.imencodemulti(".tiff", [bgr, thermal_ck], _TIFF_UNCOMPRESSED)
    if not encoded:
        raise ValueError("OpenCV could not encode the image as TIFF.")
    return data.tobytes()


def develop(source: ImageSource, pose: Pose, camera: CameraModel, seed: tuple[int, ...]) -> bytes:
    """Render an exposure and return its file; equal seeds give equal noise, in whatever order images are made."""
    return encode_tiff(source.render(pose, camera, np.random.default_rng(seed)))
