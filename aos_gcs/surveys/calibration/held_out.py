"""Test of a calibration on images that took no part in it.

A fit always describes its own images better than the given camera does, as small errors of their poses explain what is
left. What it is worth is told by others: they are placed as surveys and missions place them, by recorded poses and what
all images have in common.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.surveys.calibration.adjustment import Sigmas, adjust
from aos_gcs.surveys.calibration.observations import CLOCK, corrected_camera
from aos_gcs.surveys.calibration.tracks import FeatureTracks, triangulate
from aos_gcs.surveys.motion import ImageMotion

FOLDS = 3
"""Stretches of the recording that are left out one after the other."""

MAX_POINTS = 600
"""Points of a fit, those of the most images first: seven unknowns need no more."""

MIN_POINTS = 20


@dataclass(frozen=True, slots=True)
class HeldOut:
    """Median distances of measured and predicted places in images that were left out of the fit."""

    before_px: float
    """Distance by the given camera, mount and clock; NaN where no stretch has enough points."""
    after_px: float
    """Distance by those fitted to the other images."""


def held_out_residuals(
    tracks: FeatureTracks,
    camera: CameraModel,
    poses: Sequence[Pose],
    *,
    motion: ImageMotion,
    sigmas: Sigmas,
    fixed: NDArray[np.bool_],
) -> HeldOut:
    """Fit the camera to the recording without a stretch of it, for each of three, and try it on that stretch.

    The arguments are those of :func:`adjust`.
    """
    whole = _Stretch(tracks, tuple(poses), motion, sigmas)
    before: list[NDArray[np.float64]] = []
    after: list[NDArray[np.float64]] = []
    numbers = np.arange(len(poses))
    for left_out in np.array_split(numbers, FOLDS):
        common = _fit(whole.of(np.setdiff1d(numbers, left_out)), camera, fixed)
        tested = whole.of(left_out)
        if common is None or tested.tracks.count < MIN_POINTS:
            continue
        given_px, fitted_px = (_distances_px(tested, camera, unknowns) for unknowns in (np.zeros_like(common), common))
        both = np.isfinite(given_px) & np.isfinite(fitted_px)
        before.append(given_px[both])
        after.append(fitted_px[both])
    if not sum(map(len, before)):
        return HeldOut(np.nan, np.nan)
    return HeldOut(float(np.median(np.concatenate(before))), float(np.median(np.concatenate(after))))


@dataclass(frozen=True, slots=True, eq=False)
class _Stretch:
    """Some images of a recording, and what they show."""

    tracks: FeatureTracks
    poses: tuple[Pose, ...]
    motion: ImageMotion
    sigmas: Sigmas

    def of(self, images: NDArray[np.intp]) -> _Stretch:
        return _Stretch(
            self.tracks.in_images(images),
            tuple(self.poses[index] for index in images),
            self.motion.of(images),
            self.sigmas.of(images),
        )


def _fit(images: _Stretch, camera: CameraModel, fixed: NDArray[np.bool_]) -> NDArray[np.float64] | None:
    """Return the common unknowns of some images; None where they have too little in common."""
    points_m, usable = triangulate(images.tracks, camera, images.poses)
    usable &= np.cumsum(usable) <= MAX_POINTS
    if usable.sum() < MIN_POINTS:
        return None
    adjusted = adjust(
        images.tracks.chosen(usable),
        points_m[usable],
        camera,
        poses=images.poses,
        motion=images.motion,
        sigmas=images.sigmas,
        fixed=fixed,
    )
    return np.where(fixed, 0.0, adjusted.common)


def _distances_px(images: _Stretch, camera: CameraModel, common: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distances of measured and predicted places, shape (k,); NaN where a point cannot be placed."""
    tracks, poses, motion = images.tracks, images.poses, images.motion
    offset_s, boresight = float(common[CLOCK]), Rotation.from_rotvec(common[:3])
    R_cam2enu = Rotation.from_matrix([pose.R_cam2enu for pose in poses])
    R_cam2enu = R_cam2enu * Rotation.from_rotvec(motion.rate_cam_radps * offset_s) * boresight
    centres_m = np.array([pose.position_enu_m for pose in poses])
    centres_m = centres_m + motion.velocity_mps * offset_s + 0.5 * motion.acceleration_mps2 * offset_s**2
    placed = [Pose(centre_m, R) for centre_m, R in zip(centres_m, R_cam2enu.as_matrix(), strict=True)]
    calibrated = corrected_camera(camera, common)
    points_m, usable = triangulate(tracks, calibrated, placed)
    in_camera = R_cam2enu[tracks.image].inv().apply(points_m[tracks.point] - centres_m[tracks.image])
    usable = usable[tracks.point] & (in_camera[:, 2] > 0.0)
    normalised = in_camera[:, :2] / np.where(usable, in_camera[:, 2], np.nan)[:, np.newaxis]
    distances_px = np.linalg.norm(calibrated.to_pixels(normalised) - tracks.pixels, axis=1)
    return np.where(usable, distances_px, np.nan)
