"""Errors of the vehicles' poses, estimated from what their frames have in common.

An error has a part that lasts and one that passes with its frame. What is learnt of the lasting parts is carried from
step to step as a Gaussian: a step in which a vehicle moves about the others tells more than one in which the formation
keeps its shape. docs/imaging.md says what can be learnt.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.rotations import R_from_rotation_vector
from aos_gcs.imaging.focal_plane import footprint
from aos_gcs.imaging.geolocation import Uncertainty
from aos_gcs.imaging.integral import check_frame
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.registration.adjustment import POSE_ERRORS, Gaussian, adjust
from aos_gcs.imaging.registration.ties import PatchSize, measure_ties
from aos_gcs.imaging.undistort import undistorted

ROUNDS = ((32, 1 / 110, 0.3), (40, 1 / 160, 0.6), (40, 1 / 160, 0.6))
"""Edge of the patches (pixels), their resolution (share of the cameras' height above them), greatest parallax of a pair
(baseline over height): in the first round, neither errors nor heights are known; the last one is linear about what the
others have found."""

PATCH_SPACING = 0.5
"""Distance between the centres of patches, in edges of one."""

MAX_NEIGHBOURS = 8
"""Pairs that each frame begins; more bring little news."""

MIN_TIES_PER_FRAME = 4
"""Two equations each: fewer could not tell the frame's six errors and the heights of its patches."""

_JUDGED = np.array([0, 1, 3])
"""East, north and yaw among the errors of a pose: what the confidence is about."""

_LEAST_SHARE = 0.05
_LEAST_M = 0.001
_LEAST_RAD = 1e-5
"""Nothing is taken to be exact: what is known to be cannot be learnt, and its covariance has no inverse."""

MIN_INLIER_SHARE = 0.5
"""Share of the ties of a step that must fit; else nothing is learnt from it. Simulated forests reach 0.5 to 0.95."""


@dataclass(frozen=True, slots=True)
class PoseSigmas:
    """Expected standard deviations of the errors of poses."""

    offset_m: float
    """Error of the position along each horizontal axis."""
    height_m: float
    yaw_rad: float
    tilt_rad: float
    """Error of roll and of pitch."""

    def of_one(self) -> NDArray[np.float64]:
        """Return the sigmas of one pose in the order of its errors, shape (``POSE_ERRORS``,)."""
        return np.array([self.offset_m, self.offset_m, self.height_m, self.yaw_rad, self.tilt_rad, self.tilt_rad])


@dataclass(frozen=True, slots=True)
class ErrorBudget:
    """A satellite receiver, a compass and a gimbal: 0.5 m (height 0.75 m), 3 degrees and 1 degree in all."""

    lasting: PoseSigmas = PoseSigmas(0.47, 0.71, math.radians(2.9), math.radians(0.7))
    """Part that stays with a vehicle."""
    passing: PoseSigmas = PoseSigmas(0.16, 0.24, math.radians(0.7), math.radians(0.7))
    """Part that differs from one exposure to the next."""

    @classmethod
    def of(cls, uncertainty: Uncertainty) -> ErrorBudget:
        """Return the budget of poses that are as uncertain as targets are located with."""
        share = min(max(uncertainty.persistent_share, _LEAST_SHARE), 1.0 - _LEAST_SHARE)
        lasting, passing = (
            PoseSigmas(
                max(factor * uncertainty.position_horizontal_m, _LEAST_M),
                max(factor * uncertainty.position_vertical_m, _LEAST_M),
                max(factor * uncertainty.yaw_rad, _LEAST_RAD),
                max(factor * uncertainty.attitude_rad, _LEAST_RAD),
            )
            for factor in (math.sqrt(share), math.sqrt(1.0 - share))
        )
        return cls(lasting, passing)


@dataclass(frozen=True, slots=True)
class PoseCorrection:
    """Correction to be added to the poses that a vehicle reports."""

    east_m: float
    north_m: float
    up_m: float
    yaw_rad: float
    """Clockwise seen from above, as headings are."""
    about_east_rad: float
    about_north_rad: float


@dataclass(frozen=True, slots=True, eq=False)
class Registration:
    """Estimate of the vehicles' pose errors; a new one for every step."""

    budget: ErrorBudget = field(default_factory=ErrorBudget)
    vehicle_ids: tuple[int, ...] = ()
    errors: Gaussian = field(default_factory=lambda: Gaussian(np.zeros(0), np.zeros((0, 0))))
    """Lasting errors of one vehicle after the other, shape (``POSE_ERRORS`` n,), its tilts about its camera's own axes,
    right and forward: a mount that hangs askew tilts a camera to the other side once its vehicle has turned."""
    inlier_share: float = 0.0
    """Share of the ties that fitted in the latest step that was learnt from."""
    steps: int = 0
    """Number of steps that were learnt from."""

    @property
    def confidence(self) -> float:
        """0 to 1: share of ties that fit, times the share of variance explained in the worst of all directions.

        A direction is any combination of the vehicles' horizontal offsets and headings, relative to the fleet: to turn
        or to scale the whole formation is one of them.
        """
        if self.steps == 0:
            return 0.0
        judged = _JUDGED + POSE_ERRORS * np.arange(len(self.vehicle_ids))[:, np.newaxis]
        sigmas = np.tile(self.budget.lasting.of_one()[_JUDGED], len(self.vehicle_ids))
        left = self._relative_covariance()[np.ix_(judged.ravel(), judged.ravel())] / np.outer(sigmas, sigmas)
        return self.inlier_share * max(0.0, 1.0 - float(np.linalg.eigvalsh(left)[-1]))

    def corrections(self) -> Mapping[int, PoseCorrection]:
        """Return the correction of each vehicle, as it heads north, by its id.

        One of which little is known has a small one.
        """
        values = self.errors.mean.reshape(-1, POSE_ERRORS)
        return {i: PoseCorrection(*map(float, row)) for i, row in zip(self.vehicle_ids, values, strict=True)}

    def corrected(self, vehicle_id: int, pose: Pose) -> Pose:
        """Return a pose that a vehicle reports with its lasting errors corrected; that of an unknown one as it is."""
        if vehicle_id not in self.vehicle_ids:
            return pose
        errors = _in_world(pose) @ self.errors.mean[_rows(self, [vehicle_id])]
        return corrected(pose, PoseCorrection(*map(float, errors)))

    def _relative_covariance(self) -> NDArray[np.float64]:
        n = len(self.vehicle_ids)
        to_relative = np.kron(np.eye(n) - 1.0 / n, np.eye(POSE_ERRORS))
        return np.asarray(to_relative @ self.errors.covariance @ to_relative.T)


def corrected(pose: Pose, correction: PoseCorrection) -> Pose:
    """Return a pose with a vehicle's correction applied."""
    R_turn = R_from_rotation_vector([correction.about_east_rad, correction.about_north_rad, -correction.yaw_rad])
    offset_m = np.array([correction.east_m, correction.north_m, correction.up_m])
    return Pose(pose.position_enu_m + offset_m, R_turn @ pose.R_cam2enu)


def apply_sure(registration: Registration, frames: Sequence[Frame], min_confidence: float) -> list[Frame]:
    """Return frames with their poses corrected, or as they are while confidence is low or a vehicle is unknown."""
    if registration.confidence < min_confidence:
        return list(frames)
    return [replace(frame, pose=registration.corrected(frame.vehicle_id, frame.pose)) for frame in frames]


def register(frames: Sequence[Frame], known: Registration, plane_height_m: float) -> Registration:
    """Learn from one step's frames about the errors of the vehicles' poses.

    Blocks for a second or two with ten frames: call it by a ``Worker``.

    Args:
        frames: frames with the poses that the vehicles report; one per vehicle, all with the same bands.
        known: estimate from the steps before.
        plane_height_m: z of the focal plane, about which patches of the world are looked for.

    Returns:
        The new estimate: the one before where the frames have too little in common, or it does not fit.

    Raises:
        ImagingError: two frames are of the same vehicle, or bands differ.
    """
    vehicle_ids = tuple(frame.vehicle_id for frame in frames)
    if len(set(vehicle_ids)) < len(vehicle_ids):
        raise ImagingError("Registration takes one frame per vehicle: leave the older ones out.")
    for frame in frames:
        check_frame(frame, frames[0].bands)
    known = _with_vehicles(known, vehicle_ids)
    ideal = [undistorted(frame) for frame in frames]
    lasting = _lasting_of_frames(known, ideal)
    prior = _of_frames(known, lasting)
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
        solution = adjust(ties, poses, patches_m, patch_spacing=PATCH_SPACING, applied=estimate.mean, prior=prior)
        estimate, inlier_share = solution.errors, solution.inlier_share
        height_m += solution.height_m
    if inlier_share < MIN_INLIER_SHARE:
        return known
    learnt = _learnt(known.errors, lasting, prior, _without_formation(prior, estimate, poses))
    return replace(known, errors=learnt, inlier_share=inlier_share, steps=known.steps + 1)


def _corrected_poses(frames: Sequence[Frame], errors: NDArray[np.float64]) -> list[Pose]:
    return [
        corrected(f.pose, PoseCorrection(*values))
        for f, values in zip(frames, errors.reshape(-1, POSE_ERRORS), strict=True)
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
    expected = np.tile(known.budget.lasting.of_one(), len(new))
    mean = np.concatenate((known.errors.mean, np.zeros(len(expected))))
    covariance = np.diag(np.concatenate((np.zeros(len(known.errors.mean)), expected**2)))
    covariance[: len(known.errors.mean), : len(known.errors.mean)] = known.errors.covariance
    return replace(known, vehicle_ids=(*known.vehicle_ids, *new), errors=Gaussian(mean, covariance))


def _rows(known: Registration, vehicle_ids: Sequence[int]) -> NDArray[np.intp]:
    first = POSE_ERRORS * np.array([known.vehicle_ids.index(vehicle_id) for vehicle_id in vehicle_ids], dtype=np.intp)
    return np.asarray((first[:, np.newaxis] + np.arange(POSE_ERRORS)).ravel())


def _in_world(pose: Pose) -> NDArray[np.float64]:
    """Return what takes errors with tilts about the camera's axes to those of its pose, shape (6, 6)."""
    to_world = np.eye(POSE_ERRORS)
    right, forward = pose.R_cam2enu[:, 0], -pose.R_cam2enu[:, 1]
    east, north, up = np.column_stack((right, forward))
    to_world[3:, 4:] = -up, east, north
    return to_world


def _lasting_of_frames(known: Registration, frames: Sequence[Frame]) -> NDArray[np.float64]:
    """Return what takes the lasting errors of all vehicles to those of the frames' poses, shape (6 frames, 6 n)."""
    parts = np.zeros((len(frames), POSE_ERRORS, len(known.errors.mean)))
    for part, frame in zip(parts, frames, strict=True):
        part[:, _rows(known, [frame.vehicle_id])] = _in_world(frame.pose)
    return parts.reshape(-1, len(known.errors.mean))


def _of_frames(known: Registration, lasting: NDArray[np.float64]) -> Gaussian:
    """Return what is known beforehand of the errors of frames: what lasts, and what passes with them."""
    passing = np.tile(known.budget.passing.of_one(), len(lasting) // POSE_ERRORS)
    return Gaussian(lasting @ known.errors.mean, lasting @ known.errors.covariance @ lasting.T + np.diag(passing**2))


def _without_formation(before: Gaussian, after: Gaussian, poses: Sequence[Pose]) -> Gaussian:
    """Return the estimate without the information that frames seem to hold on the whole formation's turn and scale.

    One step cannot tell these two. Small errors of the measurement and of its linear model look as if it could, mostly
    in the same direction, and would add up from step to step (the inconsistency of filters that Huang, Mourikis and
    Roumeliotis describe in *Observability-based Rules for Designing Consistent EKF SLAM Estimators*, IJRR 2010).
    """
    place_m = np.array([pose.position_enu_m for pose in poses])
    x, y, z = (place_m - place_m.mean(axis=0)).T
    zero = np.zeros(len(x))
    turn = np.column_stack((y, -x, zero, zero + 1.0, zero, zero)).ravel()
    scale = np.column_stack((x, y, z, zero, zero, zero)).ravel()
    whole = np.column_stack((turn, scale))
    information = np.linalg.inv(after.covariance) - np.linalg.inv(before.covariance)
    # As if each step had a turn and a scale of its own, of standard deviations of 1 rad and 100 %.
    doubt = information @ whole @ np.linalg.inv(whole.T @ information @ whole + np.eye(2)) @ whole.T
    covariance = np.linalg.inv(np.linalg.inv(before.covariance) + information - doubt @ information)
    pull = np.linalg.solve(after.covariance, after.mean - before.mean)
    return Gaussian(before.mean + covariance @ (pull - doubt @ pull), (covariance + covariance.T) / 2.0)


def _learnt(known: Gaussian, lasting: NDArray[np.float64], before: Gaussian, after: Gaussian) -> Gaussian:
    """Return what is known of the lasting errors once those of frames, of which they are parts, are better known."""
    gain = np.linalg.solve(before.covariance, lasting @ known.covariance).T
    mean = known.mean + gain @ (after.mean - before.mean)
    covariance = known.covariance + gain @ (after.covariance - before.covariance) @ gain.T
    return Gaussian(mean, (covariance + covariance.T) / 2.0)
