"""Motion of the camera about the recorded poses: where it was a little before or after the times of its images.

A flight is cut into stretches without gaps; positions are cubic splines within each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from aos_gcs.surveys.model import SurveyImage

MAX_GAP = 2.5
"""Gap between two images, in medians of all gaps, that ends a stretch."""
_SPLINE_POINTS = 4
"""Least number of positions that a cubic spline is determined by."""


@dataclass(frozen=True, slots=True, eq=False)
class ImageMotion:
    """Velocities at the images; arrays with one row per image, in the axes of the recording's world."""

    velocity_mps: NDArray[np.float64]
    """Shape (n, 3)."""
    acceleration_mps2: NDArray[np.float64]
    """Shape (n, 3)."""
    rate_cam_radps: NDArray[np.float64]
    """Angular velocity in the axes of the camera, shape (n, 3)."""
    is_known: NDArray[np.bool_]
    """Whether the image has a neighbour in time, shape (n,); the motion of others is taken for none."""

    def of(self, chosen: NDArray[np.intp]) -> ImageMotion:
        """Return the motion at some images."""
        return ImageMotion(*(getattr(self, name)[chosen] for name in self.__slots__))

    @classmethod
    def none(cls, count: int) -> ImageMotion:
        """Motion of images without times."""
        return cls(np.zeros((count, 3)), np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count, dtype=np.bool_))


def motion_of(images: Sequence[SurveyImage]) -> ImageMotion | None:
    """Return the motion at the images; None where one has no time, or all have the same."""
    times = [image.taken_at_s for image in images]
    known = [time for time in times if time is not None]
    if len(known) < len(times) or len(set(known)) < 2:
        return None
    order = np.argsort(known, kind="stable")
    at_s = np.array(known)[order]
    gaps_s = np.diff(at_s)
    longest_s = MAX_GAP * float(np.median(gaps_s[gaps_s > 0.0]))
    # An image taken at the time of another tells nothing of the motion.
    cuts = np.flatnonzero((gaps_s > longest_s) | (gaps_s <= 0.0)) + 1
    motion = ImageMotion.none(len(images))
    for stretch in np.split(np.arange(len(order)), cuts):
        if len(stretch) > 1:
            _fill(motion, images, order[stretch], at_s[stretch])
    return motion


def moved(images: Sequence[SurveyImage], offset_s: float) -> list[SurveyImage] | None:
    """Return the images with the poses at their times plus an offset; None where their motion is not known."""
    motion = motion_of(images)
    if motion is None:
        return None
    turns = Rotation.from_rotvec(motion.rate_cam_radps * offset_s).as_matrix()
    shifts_m = motion.velocity_mps * offset_s + 0.5 * motion.acceleration_mps2 * offset_s**2
    return [
        replace(
            image,
            pose=replace(
                image.pose, position_enu_m=image.pose.position_enu_m + shift_m, R_cam2enu=image.pose.R_cam2enu @ turn
            ),
        )
        for image, shift_m, turn in zip(images, shifts_m, turns, strict=True)
    ]


def _fill(
    motion: ImageMotion, images: Sequence[SurveyImage], indices: NDArray[np.intp], at_s: NDArray[np.float64]
) -> None:
    """Write the motion of one stretch of images."""
    positions_m = np.array([images[index].pose.position_enu_m for index in indices])
    if len(indices) >= _SPLINE_POINTS:
        spline = CubicSpline(at_s, positions_m)
        motion.velocity_mps[indices] = spline(at_s, 1)
        motion.acceleration_mps2[indices] = spline(at_s, 2)
    else:
        motion.velocity_mps[indices] = np.gradient(positions_m, at_s, axis=0)
    attitudes = Rotation.from_matrix(np.array([images[index].pose.R_cam2enu for index in indices]))
    before, after = (
        np.maximum(np.arange(len(indices)) - 1, 0),
        np.minimum(np.arange(len(indices)) + 1, len(indices) - 1),
    )
    turns_rad = (attitudes[before].inv() * attitudes[after]).as_rotvec()
    motion.rate_cam_radps[indices] = turns_rad / (at_s[after] - at_s[before])[:, np.newaxis]
    motion.is_known[indices] = True
