"""Mapping through a distorted lens: from the pixels of its ideal camera to its own.

What projects a frame composes this map with the projection and interpolates the image once. :func:`undistorted` makes
an ideal frame of it, for methods that compare images.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.imaging.model import Frame, Pixels

MAX_CAMERAS = 32
"""Cameras whose maps are kept: 8 bytes per pixel each."""

RIM_PX = 1
"""Rim of the map around its ideal image: coordinates half a pixel outside of it can be interpolated, too."""


def undistorted(frame: Frame) -> Frame:
    """Return the frame as its ideal camera would have taken it: float32, NaN where the lens saw nothing.

    A frame without distortion is returned as it is, in its own type.
    """
    if frame.camera.distortion is None:
        return frame
    u, v = (np.ascontiguousarray(plane[RIM_PX:-RIM_PX, RIM_PX:-RIM_PX]) for plane in lens_map(frame.camera))
    values, seen = sample_pixels(frame.image, u, v)
    values[seen == 0] = np.nan
    return replace(frame, image=values, camera=frame.camera.ideal())


@lru_cache(maxsize=MAX_CAMERAS)
def lens_map(camera: CameraModel) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the real pixel u and v of each pixel of the ideal camera, NaN where the lens images none.

    Shapes (H + 2, W + 2) for an ideal image of H x W, as the map has a rim of :data:`RIM_PX`. Real pixels may lie
    outside of the real image. Shared and read-only.
    """
    ideal = camera.ideal()
    u, v = np.meshgrid(np.arange(-RIM_PX, ideal.width_px + RIM_PX), np.arange(-RIM_PX, ideal.height_px + RIM_PX))
    pixels = camera.to_pixels(ideal.from_pixels(np.stack((u, v), axis=-1)))
    # Two planes: OpenCV warps an image of two channels four times as slowly as two images.
    real_u, real_v = (np.ascontiguousarray(pixels[:, :, axis], dtype=np.float32) for axis in (0, 1))
    real_u.setflags(write=False)
    real_v.setflags(write=False)
    return real_u, real_v


def sample_pixels(
    image: Pixels, u: NDArray[np.float32], v: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Return an image, shape (H, W, C), at pixels (u, v), shapes (rows, columns), and 1 where they lie in it.

    Bilinear; clamped within half a pixel of the border, of no meaning further out or where a pixel is NaN.
    """
    height, width = image.shape[:2]
    in_width = np.asarray(cv2.inRange(u, -0.5, width - 0.5), dtype=np.uint8)
    in_height = np.asarray(cv2.inRange(v, -0.5, height - 0.5), dtype=np.uint8)
    seen = in_width & in_height
    if is_floats(image):
        part = image.view(np.float32)
    else:
        (low_u, high_u), (low_v, high_v) = (cv2.minMaxLoc(plane, seen)[:2] for plane in (u, v))
        part, left, top = floats_within(image, (low_u, high_u), (low_v, high_v))
        u, v = u - np.float32(left), v - np.float32(top)
    values = cv2.remap(part, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(values, dtype=np.float32).reshape(*u.shape, image.shape[2]), seen & np.uint8(1)


def is_floats(image: Pixels) -> bool:
    """Tell whether OpenCV can interpolate an image as it is: it rounds samples of integers to integers."""
    return image.dtype == np.float32 and image.flags.c_contiguous


def floats_within(
    image: Pixels, u_range: tuple[float, float], v_range: tuple[float, float]
) -> tuple[NDArray[np.float32], int, int]:
    """Return what sampling an image at pixels in the given ranges needs, as floats, and its left and top pixel.

    Only this part is converted: while it is in the cache, it is sampled much faster than a whole image of floats.
    """
    (left, right), (top, bottom) = (
        (int(min(max(low - 1.0, 0.0), size - 1.0)), int(min(max(high, 0.0) + 3.0, size)))
        for (low, high), size in ((u_range, image.shape[1]), (v_range, image.shape[0]))
    )
    return np.ascontiguousarray(image[top:bottom, left:right], dtype=np.float32), left, top


def seen_pixels(pixels: NDArray[np.float64], camera: CameraModel) -> NDArray[np.bool]:
    """Tell which pixels (u, v), shape (..., 2), lie in the image, its outer edges included; NaN does not."""
    u, v = pixels[..., 0], pixels[..., 1]
    return np.asarray(
        (u >= -0.5) & (u <= camera.width_px - 0.5) & (v >= -0.5) & (v <= camera.height_px - 0.5), dtype=np.bool
    )
