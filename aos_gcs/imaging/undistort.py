"""Frames of distorted lenses as frames of ideal cameras, with one remap per frame.

Homographies, footprints and masks then hold for every lens, at the price of one more interpolation; the maps depend on
the camera alone and are kept. Exact integrals (:func:`~aos_gcs.imaging.integral.integrate_view`) map through the lens
instead and interpolate once.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.imaging.model import Frame

MAX_CAMERAS = 32
"""Whose maps are kept: 9 bytes per pixel each."""


RIM_PX = 1
"""Of the copied rim around images that are remapped."""


def undistorted(frame: Frame) -> Frame:
    """Return the frame as its ideal camera would have taken it: float32, NaN where the lens saw nothing.

    A frame without distortion is returned as it is, in its own type.
    """
    if frame.camera.distortion is None:
        return frame
    lens_map, outside = _maps(frame.camera)
    image = remap(frame.image.astype(np.float32, copy=False), lens_map)
    image[outside] = np.nan
    return replace(frame, image=image, camera=frame.camera.ideal())


def remap(image: NDArray[np.float32], pixels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return an image, shape (H, W, C), at pixels (u, v) + :data:`RIM_PX`, shape (rows, columns, 2).

    Bilinear; clamped within half a pixel of the border, of no meaning further out.
    """
    # A rim in place of OpenCV's replicated border: that one is computed for every cell outside the image, too.
    padded = cv2.copyMakeBorder(image, RIM_PX, RIM_PX, RIM_PX, RIM_PX, cv2.BORDER_REPLICATE)
    # OpenCV's stubs do not know that the second map may be None; an empty array in its place gives wrong values.
    values = cv2.remap(padded, pixels, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)  # type: ignore[call-overload]
    return np.asarray(values, dtype=np.float32).reshape(*pixels.shape[:2], image.shape[2])


def seen_pixels(pixels: NDArray[np.float64], camera: CameraModel) -> NDArray[np.bool]:
    """Tell which pixels (u, v), shape (..., 2), lie in the image, its outer edges included; NaN does not."""
    u, v = pixels[..., 0], pixels[..., 1]
    return np.asarray(
        (u >= -0.5) & (u <= camera.width_px - 0.5) & (v >= -0.5) & (v <= camera.height_px - 0.5), dtype=np.bool
    )


@lru_cache(maxsize=MAX_CAMERAS)
def _maps(camera: CameraModel) -> tuple[NDArray[np.float32], NDArray[np.bool]]:
    """Return the real pixel (u, v) + ``RIM_PX`` of each ideal one, and where the lens sees none.

    Shapes (H, W, 2) and (H, W).
    """
    ideal = camera.ideal()
    u, v = np.meshgrid(np.arange(ideal.width_px), np.arange(ideal.height_px))
    real = camera.to_pixels(ideal.from_pixels(np.stack((u, v), axis=-1)))
    seen = seen_pixels(real, camera)
    return np.where(seen[..., np.newaxis], real + RIM_PX, 0.0).astype(np.float32), ~seen
