"""Poses of a recording, corrected by what neighbouring images show.

Errors that differ from one image to the next blur what lies on the ground, as positions of receivers and attitudes of
gimbals have them. Neighbours that share features tell these errors; what all images have in common stays as recorded.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.surveys.calibration.adjustment import Adjusted, Sigmas, adjust
from aos_gcs.surveys.calibration.observations import COMMON, OWN
from aos_gcs.surveys.calibration.tracks import Features, find_features, make_tracks, match, triangulate
from aos_gcs.surveys.images import read_frame
from aos_gcs.surveys.model import Survey
from aos_gcs.surveys.motion import ImageMotion

BLOCK, STRIDE = 40, 20
"""Images that are adjusted together, and how far the next block is: memory does not grow with the flight."""

NEIGHBOURS = 3
"""Images after each that it is compared with."""

MIN_IMAGES, MIN_POINTS = 6, 60

PLACE_SIGMA_PX = 3.0
"""Standard deviation of the places of features beyond chance, as in crowns, which move and hide each other.

With a smaller one, hundreds of features that err alike bend a whole line of poses.
"""


@dataclass(frozen=True, slots=True, eq=False)
class Refined:
    """Corrected poses of a recording."""

    poses: tuple[Pose, ...]
    """One per image of the survey, in its order."""
    corrected: int
    """Images that share enough with their neighbours; others keep their poses."""
    before_px: float
    """Median distance of measured and predicted places, the median of all blocks."""
    after_px: float
    position_error_sigmas: float
    """Root mean square of the corrections, in standard deviations of the recorded positions."""
    attitude_error_sigmas: float


def refine_poses(
    survey: Survey, position_sigma_m: float, attitude_sigma_rad: float, advance: Callable[[int], None] = lambda _: None
) -> Refined:
    """Correct the poses of a recording by features that neighbours share.

    Args:
        survey: recording in the order of the flight; all of its images must have one camera.
        position_sigma_m: standard deviation of the recorded positions from one to the next, where they do not tell.
        attitude_sigma_rad: the same of the attitudes.
        advance: called with the number of images that have been searched for features.

    Raises:
        InputDataError: if the images have too little in common, or not one camera.
    """
    images = survey.images
    if len(images) < MIN_IMAGES:
        raise InputDataError(f"Correcting poses needs {MIN_IMAGES} images, got {len(images)}.")
    camera = images[0].camera
    if any(image.camera != camera for image in images):
        raise InputDataError("Correcting poses needs images of one camera; these differ in size or focal length.")
    poses = [image.pose for image in images]
    position_sigmas_m = np.array([image.position_sigma_m or (position_sigma_m,) * 3 for image in images])
    features: dict[int, Features] = {}
    pairs: dict[tuple[int, int], NDArray[np.intp]] = {}
    sums, weights, results = np.zeros((len(images), OWN)), np.zeros(len(images)), []
    for start in range(0, max(len(images) - BLOCK, 0) + STRIDE, STRIDE):
        block = range(start, min(start + BLOCK, len(images)))
        features = {index: found for index, found in features.items() if index >= start}
        pairs = {pair: found for pair, found in pairs.items() if pair[0] >= start}
        for index in block:
            if index not in features:
                features[index] = find_features(read_frame(images[index], survey.bands).image)
                advance(1)
        for first in block:
            for second in range(first + 1, min(first + NEIGHBOURS, block[-1]) + 1):
                if (first, second) not in pairs:
                    pairs[first, second] = match(features[first], features[second], camera)
        no_drift = np.zeros(len(block))
        sigmas = Sigmas(position_sigmas_m[start : block[-1] + 1], attitude_sigma_rad, no_drift, no_drift)
        matches = [(first - start, second - start, found) for (first, second), found in pairs.items()]
        result = _adjusted([features[index] for index in block], matches, camera, poses[start : block[-1] + 1], sigmas)
        if result is not None:
            # Blocks fade into each other, as each has small errors of its own.
            share = np.minimum(np.arange(1, len(block) + 1), np.arange(len(block), 0, -1)).astype(np.float64)
            sums[start : block[-1] + 1] += share[:, np.newaxis] * result.own
            weights[start : block[-1] + 1] += share
            results.append(result)
    if not results:
        raise InputDataError(
            f"No {BLOCK} images in a row have {MIN_POINTS} points in common that lie in front of their cameras. Take a "
            "flight above textured ground with an overlap of 60 %, and check poses and field of view."
        )
    own = sums / np.maximum(weights, 1.0)[:, np.newaxis]
    known = weights > 0.0
    return Refined(
        tuple(_corrected(pose, errors) for pose, errors in zip(poses, own, strict=True)),
        int(known.sum()),
        float(np.median([result.before_px for result in results])),
        float(np.median([result.after_px for result in results])),
        float(np.sqrt(np.mean((own[known, :3] / position_sigmas_m[known]) ** 2))),
        float(np.sqrt(np.mean((own[known, 3:] / attitude_sigma_rad) ** 2))),
    )


def _adjusted(
    features: Sequence[Features],
    matches: Sequence[tuple[int, int, NDArray[np.intp]]],
    camera: CameraModel,
    poses: Sequence[Pose],
    sigmas: Sigmas,
) -> Adjusted | None:
    """Return the adjustment of a block of images; None where they share too little."""
    tracks = make_tracks(features, matches)
    points_m, usable = triangulate(tracks, camera, poses)
    if usable.sum() < MIN_POINTS:
        return None
    return adjust(
        tracks.chosen(usable),
        points_m[usable],
        camera,
        poses=poses,
        motion=ImageMotion.none(len(poses)),
        sigmas=sigmas,
        fixed=np.ones(COMMON, dtype=np.bool_),
        min_sigma_px=PLACE_SIGMA_PX,
    )


def _corrected(pose: Pose, errors: NDArray[np.float64]) -> Pose:
    turn = Rotation.from_rotvec(errors[3:]).as_matrix()
    return Pose(pose.position_enu_m + errors[:3], pose.R_cam2enu @ turn)
