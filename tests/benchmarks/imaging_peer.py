"""What a straightforward program would do with the frames of a step, to be measured beside ours.

RX with the ``spectral`` package where it is installed, else with its formula in plain numpy; then every frame and every
mask is warped into the virtual view of every drone, and the masks' largest contour is taken in each of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.util import find_spec

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.projection import plane_to_image
from aos_gcs.imaging.model import Frame, Pixels

WARP = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP


def plain_rx(image: Pixels) -> NDArray[np.float64]:
    """Return the RX scores of an image, shape (H, W), by their definition."""
    pixels = image.reshape(-1, image.shape[2]).astype(np.float64)
    pixels -= pixels.mean(axis=0)
    inverse = np.linalg.pinv(np.cov(pixels, rowvar=False))
    return np.asarray(np.einsum("ij,jk,ik->i", pixels, inverse, pixels).reshape(image.shape[:2]))


def peer_rx() -> tuple[str, Callable[[Pixels], NDArray[np.float64]]]:
    """Return the name and the function of the RX to compare with."""
    if find_spec("spectral") is None:
        return "plain numpy, float64 (spectral is not installed)", plain_rx
    return "spectral", import_module("spectral").rx


def homographies(frames: Sequence[Frame], virtual: Frame) -> list[NDArray[np.float64]]:
    """Return the homographies from the view of one frame to the pixels of all, by way of the plane z = 0."""
    from_view = np.linalg.inv(plane_to_image(virtual.camera, virtual.pose, 0.0))
    return [plane_to_image(frame.camera, frame.pose, 0.0) @ from_view for frame in frames]


def bare_warps(frames: Sequence[Frame]) -> int:
    """Warp every frame to the view of the first one, as OpenCV does it, and nothing else."""
    size = frames[0].camera.width_px, frames[0].camera.height_px
    maps = homographies(frames, frames[0])
    return sum(
        cv2.warpPerspective(frame.image, H, size, flags=WARP).size for frame, H in zip(frames, maps, strict=True)
    )


def peer_step(frames: Sequence[Frame], rx: Callable[[Pixels], NDArray[np.float64]]) -> list[float]:
    """Return the area of the largest anomaly in the view of each drone, pixels."""
    masks = []
    for frame in frames:
        scores = rx(frame.image)
        masks.append((scores > np.quantile(scores, 0.9998)).astype(np.uint8))
    areas = []
    for virtual in frames:
        shape = virtual.image.shape[:2]
        total, seen = np.zeros(virtual.image.shape, dtype=np.float32), np.zeros(shape, dtype=np.uint8)
        count = np.zeros(shape, dtype=np.float32)
        for frame, mask, H in zip(frames, masks, homographies(frames, virtual), strict=True):
            total += cv2.warpPerspective(frame.image, H, shape[::-1], flags=WARP)
            count += cv2.warpPerspective(np.ones(shape, dtype=np.float32), H, shape[::-1], flags=WARP)
            seen |= cv2.warpPerspective(mask, H, shape[::-1], flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP)
        total /= np.maximum(count, 1.0)[:, :, np.newaxis]
        contours = cv2.findContours(seen, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)[0]
        areas.append(max((cv2.contourArea(contour) for contour in contours), default=0.0))
    return areas
