"""Images of a pose as the bytes of a file."""

from __future__ import annotations

from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.radiometry import centikelvin_from_celsius
from aos_sim.errors.sensor import RenderedFrame

_TIFF_UNCOMPRESSED = (cv2.IMWRITE_TIFF_COMPRESSION, 1)


class ImageSource(Protocol):
    """Anything that can take a picture. Called from worker threads, several at a time."""

    def view(self, pose: Pose, camera: CameraModel, at_s: float) -> NDArray[np.float32]:
        """Return what ``camera`` sees from ``pose``, without the errors of lens and sensor.

        Args:
            pose: true pose of the camera.
            camera: its model.
            at_s: seconds since the world began; what moves in it moves by them.

        Returns:
            Red, green, blue (0 to 255) and degrees Celsius, shape (H, W, 4).
        """
        ...


def encode_tiff(image: RenderedFrame) -> bytes:
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
