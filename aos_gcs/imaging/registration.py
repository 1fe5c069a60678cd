"""Errors of the vehicles' poses, estimated from what their frames have in common.

What is learnt is carried from step to step as the information matrix of a Gaussian: a step in which a vehicle moves
about the others tells more than one in which the formation keeps its shape. docs/registration.md says what can be told.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.focal_plane import footprint
from aos_gcs.imaging.integral import check_frame
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.registration_adjustment import CONSTANTS, ErrorBudget, Gaussian, adjust
from aos_gcs.imaging.registration_ties import PatchSize, measure_ties
from aos_gcs.imaging.undistort import undistorted

ROUNDS = ((32, 1 / 110, 0.3), (40, 1 / 160, 0.6))
"""Edge of the patches (pixels), their resolution (share of the cameras' height above them), greatest parallax of a pair
(baseline over height): in the first round, neither errors nor heights are known."""

PATCH_SPACING = 0.5
"""Between the centres of patches, in edges of one."""

MAX_NEIGHBOURS = 8
"""Pairs that each frame begins; more bring little news."""

MIN_TIES_PER_FRAME = 4
"""Two equations each: fewer could not tell the frame's five errors and the heights of its patches."""

MIN_INLIER_SHARE = 0.5
"""Of the ties of a step that must fit; else nothing is learnt from it. Simulated forests reach 0.5 to 0.95."""


@dataclass(frozen=True, slots=True)
class PoseCorrection:
    """What has to be added to the poses that a vehicle reports."""

    east_m: float
    north_m: float
    up_m: float
    yaw_rad: float
    """Clockwise seen from above, as headings are."""


@dataclass(frozen=True, slots=True, eq=False)
class Registration:
    """What is known of the vehicles' errors; a new one for every step."""

    budget: ErrorBudget = field(default_factory=ErrorBudget)
    vehicle_ids: tuple[int, ...] = ()
    errors: Gaussian = field(default_factory=lambda: Gaussian(np.zeros(0), np.zeros((0, 0))))
    """East, north, up (m) and yaw (rad) of one vehicle after the other, shape (4 n,)."""
    inlier_share: float = 0.0
    """Of the ties of the latest step that was learnt from."""
    steps: int = 0
    """That were learnt from."""

    @property
    def confidence(self) -> float:
        """0 to 1: share of the expected variance that is explained, times the share of ties that fit."""
        if self.steps == 0:
            return 0.0
        expected = _expected(self.budget)
        left = np.mean((self.sigmas() / expected) ** 2) / (1.0 - 1.0 / len(self.vehicle_ids))
        return self.inlier_share * max(0.0, 1.0 - float(left))

    def sigmas(self) -> NDArray[np.float64]:
        """Return the standard deviations of the corrections: east, north, up (m), yaw (rad), shape (n, 4)."""
        to_relative = _relative_to_mean(len(self.vehicle_ids))
        covariance = to_relative @ np.linalg.inv(self.errors.information) @ to_relative.T
        return np.asarray(np.sqrt(np.diag(covariance)).reshape(-1, CONSTANTS))

    def corrections(self) -> Mapping[int, PoseCorrection]:
        """Return the correction of each vehicle by its id, relative to the mean of the fleet, which frames cannot tell.

        A vehicle of which little is known has a small one.
        """
        relative = (_relative_to_mean(len(self.vehicle_ids)) @ self.errors.mean).reshape(-1, CONSTANTS)
        return {i: PoseCorrection(*map(float, values)) for i, values in zip(self.vehicle_ids, relative, strict=True)}


def corrected(pose: Pose, correction: PoseCorrection) -> Pose:
    """Return a pose with a vehicle's correction applied."""
    sin, cos = math.sin(correction.yaw_rad), math.cos(correction.yaw_rad)
    R_clockwise = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    offset_m = np.array([correction.east_m, correction.north_m, correction.up_m])
    return Pose(pose.position_enu_m + offset_m, R_clockwise @ pose.R_cam2enu)


def apply_sure(registration: Registration, frames: Sequence[Frame], min_confidence: float) -> list[Frame]:
    """Return frames with their poses corrected, or as they are while confidence is low or a vehicle is unknown."""
    if registration.confidence < min_confidence:
        return list(frames)
    corrections = registration.corrections()
    return [
        replace(frame, pose=corrected(frame.pose, corrections[frame.vehicle_id]))
        if frame.vehicle_id in corrections
        else frame
        for frame in frames
    ]


def register(frames: Sequence[Frame], known: Registration, plane_height_m: float) -> Registration:
    """Learn from one step's frames about the errors of the vehicles' poses.

    Blocks for about a second with ten frames: call it in a worker thread.

    Args:
        frames: with the poses that the vehicles report; one per vehicle, all with the same bands.
        known: from the steps before.
        plane_height_m: z of the focal plane, about which patches of the world are looked for.

    Returns:
        What is known now: no more than before where the frames have too little in common, or it does not fit.

    Raises:
        ImagingError: two frames are of the same vehicle, or bands differ.
    """
    vehicle_ids = tuple(frame.vehicle_id for frame in frames)
    if len(set(vehicle_ids)) < len(vehicle_ids):
        raise ImagingError("Registration takes one frame per vehicle: leave the older ones out.")
    for frame in frames:
        check_frame(frame, frames[0].bands)
    known = _with_vehicles(known, vehicle_ids)
    rows = _rows(known, vehicle_ids)
    prior = known.errors.marginal(rows)
    ideal = [undistorted(frame) for frame in frames]
    estimate, height_m, inlier_share = prior, plane_height_m, 0.0
    for edge_px, share, max_parallax in ROUNDS:
        poses = _corrected_poses(ideal, estimate.mean)
        gaps_m = np.abs([pose.position_enu_m[2] - height_m for pose in poses])
        size = PatchSize(edge_px, float(np.median(gaps_m)) * share)
        patches_m = _lattice(ideal, poses, height_m, size.edge_m * PATCH_SPACING)
        ties = measure_ties(ideal, poses, patches_m, _pairs(poses, gaps_m, max_parallax), size)
        if len(ties.patch) < MIN_TIES_PER_FRAME * len(frames):
            return known
        # Each round starts from the prior again: the first one only finds out where to look.
        solution = adjust(
            ties, poses, patches_m, patch_spacing=PATCH_SPACING, applied=estimate.mean, prior=prior, budget=known.budget
        )
        estimate, inlier_share = solution.errors, solution.inlier_share
        height_m += solution.height_m
    if inlier_share < MIN_INLIER_SHARE:
        return known
    learnt = known.errors.updated(rows, prior, estimate)
    return replace(known, errors=learnt, inlier_share=inlier_share, steps=known.steps + 1)


def _corrected_poses(frames: Sequence[Frame], errors: NDArray[np.float64]) -> list[Pose]:
    return [
        corrected(f.pose, PoseCorrection(*values))
        for f, values in zip(frames, errors.reshape(-1, CONSTANTS), strict=True)
    ]


def _lattice(frames: Sequence[Frame], poses: Sequence[Pose], height_m: float, spacing_m: float) -> NDArray[np.float64]:
    """Return the centres of patches all over what the frames see of a horizontal plane, shape (m, 3)."""
    outline_m = np.vstack([footprint(f.camera, pose, height_m) for f, pose in zip(frames, poses, strict=True)])
    if not len(outline_m):
        return np.empty((0, 3))
    first, last = np.ceil(outline_m.min(axis=0) / spacing_m), np.floor(outline_m.max(axis=0) / spacing_m)
    x, y = np.meshgrid(*(np.arange(low, high + 1) * spacing_m for low, high in zip(first, last, strict=True)))
    return np.column_stack((x.ravel(), y.ravel(), np.full(x.size, height_m)))


def _pairs(poses: Sequence[Pose], gaps_m: NDArray[np.float64], max_parallax: float) -> NDArray[np.bool_]:
    """Return which frames to compare, shape (n, n): the nearest ones of each, with not too much parallax."""
    places_m = np.array([pose.position_enu_m[:2] for pose in poses])
    baselines_m = np.linalg.norm(places_m[:, np.newaxis] - places_m, axis=2)
    np.fill_diagonal(baselines_m, np.inf)
    nearest = np.argsort(baselines_m, axis=1)[:, :MAX_NEIGHBOURS]
    chosen = np.zeros(baselines_m.shape, dtype=np.bool_)
    np.put_along_axis(chosen, nearest, values=True, axis=1)
    return np.asarray((chosen | chosen.T) & (baselines_m <= max_parallax * np.minimum.outer(gaps_m, gaps_m)))


def _with_vehicles(known: Registration, vehicle_ids: Sequence[int]) -> Registration:
    """Return what is known with the vehicles added that are new; of them, only the expected size of errors is known."""
    new = [vehicle_id for vehicle_id in vehicle_ids if vehicle_id not in known.vehicle_ids]
    if not new:
        return known
    budget, errors = known.budget, known.errors
    expected = np.tile(_expected(budget), len(new))
    mean = np.concatenate((errors.mean, np.zeros(len(expected))))
    # SciPy counts an empty array as one row.
    blocks = [block for block in (errors.information, np.diag(expected**-2.0)) if block.size]
    return replace(known, vehicle_ids=(*known.vehicle_ids, *new), errors=Gaussian(mean, block_diag(*blocks)))


def _rows(known: Registration, vehicle_ids: Sequence[int]) -> NDArray[np.intp]:
    first = CONSTANTS * np.array([known.vehicle_ids.index(vehicle_id) for vehicle_id in vehicle_ids], dtype=np.intp)
    return np.asarray((first[:, np.newaxis] + np.arange(CONSTANTS)).ravel())


def _expected(budget: ErrorBudget) -> NDArray[np.float64]:
    return np.array([budget.offset_m, budget.offset_m, budget.height_m, budget.yaw_rad])


def _relative_to_mean(n: int) -> NDArray[np.float64]:
    return np.asarray(np.kron(np.eye(n) - 1.0 / n, np.eye(CONSTANTS)), dtype=np.float64)
