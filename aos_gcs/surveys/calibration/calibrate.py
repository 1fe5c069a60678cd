"""Calibration of a recorded flight, from its images to camera, mount and clock."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import R_CAM2SENSOR_FRD, Pose
from aos_gcs.geometry.projection import project_points
from aos_gcs.surveys.calibration.adjustment import PRIOR_SIGMAS, Adjusted, Sigmas, adjust
from aos_gcs.surveys.calibration.held_out import HeldOut, held_out_residuals
from aos_gcs.surveys.calibration.observations import CLOCK, COMMON, corrected_camera
from aos_gcs.surveys.calibration.tracks import Features, FeatureTracks, find_features, make_tracks, match, triangulate
from aos_gcs.surveys.images import read_frame
from aos_gcs.surveys.model import Survey
from aos_gcs.surveys.motion import ImageMotion, motion_of

MIN_IMAGES, MIN_POINTS = 6, 60
MAX_IMAGES = 120
"""Images that are compared; of more, as many are taken evenly."""
PAIRS_PER_IMAGE = 14
MIN_OVERLAP = 0.25
UNDETERMINED_SHARE = 0.5
"""Share of its first standard deviation that an unknown must be left with to count as not determined."""

SURPRISING_SIGMAS = 3.0

DRIFT_S, DRIFT_IMAGES = 60.0, 30
"""Time in which the drift of a receiver changes, and images that stand for it where there are no times."""

_ANGLES = slice(0, 3)


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """Calibrated camera, mount and clock of a flight."""

    camera: CameraModel
    boresight_rad: tuple[float, float, float]
    """Yaw, pitch, roll about down, right, forward of the recorded camera."""
    clock_offset_s: float
    covariance: NDArray[np.float64]
    """Covariance of yaw, pitch, roll (rad), focal length (px), k1, k2 and clock offset (s), shape (7, 7)."""
    is_determined: NDArray[np.bool_]
    """Whether the flight tells an unknown; others stay as they were. Shape (7,)."""
    is_surprising: NDArray[np.bool_]
    """Whether an unknown differs from what was told by more than three of its first standard deviations. Shape (7,)."""
    images: int
    points: int
    before_px: float
    """Median distance of measured and predicted places in the images, before and after."""
    after_px: float
    position_error_sigmas: float
    """Root mean square of the errors of the recorded positions that the images tell, in their standard deviations."""
    attitude_error_sigmas: float
    held_out: HeldOut


def calibrate(
    survey: Survey,
    position_sigma_m: float,
    attitude_sigma_rad: float,
    position_drift_m: float = 0.0,
    advance: Callable[[int], None] = lambda _: None,
) -> Result:
    """Calibrate the camera of a recording.

    Args:
        survey: recording; all of its images must have one camera.
        position_sigma_m: standard deviation of the recorded positions from one to the next, where they do not tell.
        attitude_sigma_rad: the same of the attitudes.
        position_drift_m: standard deviation of what neighbouring positions have in common, where their accuracy is not
            recorded.
        advance: called with the number of images that have been searched for features.

    Raises:
        InputDataError: if the images have too little in common.
    """
    motion = motion_of(survey.images) or ImageMotion.none(len(survey.images))
    has_clock = bool(motion.is_known.any())
    usable = np.flatnonzero(motion.is_known) if has_clock else np.arange(len(survey.images))
    chosen = usable[np.unique(np.linspace(0, len(usable) - 1, min(MAX_IMAGES, len(usable))).round().astype(int))]
    images = [survey.images[index] for index in chosen]
    if len(images) < MIN_IMAGES:
        raise InputDataError(f"A calibration needs {MIN_IMAGES} images with poses, got {len(images)}.")
    camera = images[0].camera
    if any(image.camera != camera for image in images):
        raise InputDataError("A calibration needs images of one camera; these differ in size or focal length.")
    features = []
    for image in images:
        features.append(find_features(read_frame(image, survey.bands).image))
        advance(1)
    poses = [image.pose for image in images]
    tracks, points_m = _tracks(features, camera, poses)
    motion = motion.of(chosen)
    sigmas = Sigmas(
        np.array([image.position_sigma_m or (position_sigma_m,) * 3 for image in images]),
        attitude_sigma_rad,
        np.array([position_drift_m if image.position_sigma_m is None else 0.0 for image in images]),
        _drift_at(survey, chosen),
    )
    fixed = np.zeros(COMMON, dtype=np.bool_)
    fixed[CLOCK] = not has_clock
    adjusted = adjust(tracks, points_m, camera, poses=poses, motion=motion, sigmas=sigmas, fixed=fixed)
    unknown = np.sqrt(np.diag(adjusted.covariance)) > UNDETERMINED_SHARE * PRIOR_SIGMAS
    if (unknown & ~fixed).any():
        # What the flight does not tell stays as it was, instead of being drawn along by the rest.
        fixed |= unknown
        adjusted = adjust(tracks, points_m, camera, poses=poses, motion=motion, sigmas=sigmas, fixed=fixed)
    prior = np.diag(np.where(fixed, PRIOR_SIGMAS, 0.0) ** 2)
    adjusted = replace(adjusted, covariance=np.where(np.logical_or.outer(fixed, fixed), prior, adjusted.covariance))
    held_out = held_out_residuals(tracks, camera, poses, motion=motion, sigmas=sigmas, fixed=fixed)
    return _result(adjusted, camera, fixed, held_out=held_out, counts=(len(images), tracks.count))


def _drift_at(survey: Survey, chosen: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the times of some images in units of that in which a drift changes."""
    times_s = [survey.images[index].taken_at_s for index in chosen]
    known_s = [time_s for time_s in times_s if time_s is not None]
    return np.array(known_s) / DRIFT_S if len(known_s) == len(times_s) else chosen / DRIFT_IMAGES


def _tracks(
    features: Sequence[Features], camera: CameraModel, poses: Sequence[Pose]
) -> tuple[FeatureTracks, NDArray[np.float64]]:
    """Return points of the ground, first from neighbours in the recording, then from all images that overlap."""
    count = len(features)
    near = [(first, second) for first in range(count) for second in (first + 1, first + 2) if second < count]
    matches = {pair: match(features[pair[0]], features[pair[1]], camera) for pair in near}
    tracks = make_tracks(features, [(*pair, found) for pair, found in matches.items()])
    points_m, usable = triangulate(tracks, camera, poses)
    if usable.sum() < MIN_POINTS:
        raise _too_little(int(usable.sum()))
    centres_m = np.array([pose.position_enu_m for pose in poses])
    distance_m = float(np.median(np.linalg.norm(points_m - centres_m[tracks.image[_first_of(tracks)]], axis=1)[usable]))
    for pair in _overlapping(camera, poses, distance_m):
        if pair not in matches:
            matches[pair] = match(features[pair[0]], features[pair[1]], camera)
    tracks = make_tracks(features, [(*pair, found) for pair, found in matches.items()])
    points_m, usable = triangulate(tracks, camera, poses)
    if usable.sum() < MIN_POINTS:
        raise _too_little(int(usable.sum()))
    return tracks.chosen(usable), points_m[usable]


def _first_of(tracks: FeatureTracks) -> NDArray[np.intp]:
    """Return the first observation of each point."""
    return np.unique(tracks.point, return_index=True)[1]


def _too_little(count: int) -> InputDataError:
    return InputDataError(
        f"The images have only {count} points in common that lie in front of their cameras; {MIN_POINTS} are needed. "
        "Take a flight above textured ground with an overlap of 60 %, and check poses and field of view."
    )


def _overlapping(camera: CameraModel, poses: Sequence[Pose], distance_m: float) -> list[tuple[int, int]]:
    """Return pairs of images that share much of their view, for each image of all degrees of overlap."""
    u, v = np.meshgrid(np.linspace(0, camera.width_px - 1, 5), np.linspace(0, camera.height_px - 1, 5))
    rays = np.column_stack((camera.from_pixels(np.stack((u.ravel(), v.ravel()), axis=1)), np.ones(u.size)))
    rays = rays[np.isfinite(rays).all(axis=1)]
    pairs = []
    for first, pose in enumerate(poses):
        ground_m = pose.position_enu_m + distance_m * rays @ pose.R_cam2enu.T
        shares = np.array([_share_seen(ground_m, camera, other) for other in poses[first + 1 :]])
        by_share = np.argsort(-shares, kind="stable")[: int(np.sum(shares >= MIN_OVERLAP))]
        picked = np.unique(np.linspace(0, len(by_share) - 1, min(PAIRS_PER_IMAGE, len(by_share))).round().astype(int))
        pairs += [(first, first + 1 + int(second)) for second in by_share[picked]]
    return pairs


def _share_seen(points_m: NDArray[np.float64], camera: CameraModel, pose: Pose) -> float:
    pixels = project_points(points_m, camera, pose)
    with np.errstate(invalid="ignore"):
        inside = (pixels >= -0.5) & (pixels < (camera.width_px - 0.5, camera.height_px - 0.5))
    return float(inside.all(axis=1).mean())


def _result(
    adjusted: Adjusted, camera: CameraModel, fixed: NDArray[np.bool_], *, held_out: HeldOut, counts: tuple[int, int]
) -> Result:
    """Return the result in the units and the order of a calibration; the counts are those of images and points."""
    common = np.where(fixed, 0.0, adjusted.common)
    R_frd = R_CAM2SENSOR_FRD @ Rotation.from_rotvec(common[_ANGLES]).as_matrix() @ R_CAM2SENSOR_FRD.T
    yaw_rad, pitch_rad, roll_rad = (float(angle) for angle in Rotation.from_matrix(R_frd).as_euler("ZYX"))
    # Turns about right, down and forward are pitch, yaw and roll, as long as they are small.
    order = np.array([1, 0, 2, 3, 4, 5, 6])
    scale = np.array([1.0, 1.0, 1.0, camera.fx_px, 1.0, 1.0, 1.0])
    covariance = adjusted.covariance[np.ix_(order, order)] * np.outer(scale, scale)
    calibrated = corrected_camera(camera, common)
    if camera.distortion is None and fixed[4] and fixed[5]:
        calibrated = replace(calibrated, distortion=None)
    return Result(
        calibrated,
        (yaw_rad, pitch_rad, roll_rad),
        float(common[CLOCK]),
        covariance,
        ~fixed[order],
        np.abs(common[order]) > SURPRISING_SIGMAS * PRIOR_SIGMAS[order],
        *counts,
        adjusted.before_px,
        adjusted.after_px,
        adjusted.position_error_sigmas,
        adjusted.attitude_error_sigmas,
        held_out,
    )
