"""The least squares of registration: from ties between frames to the errors of their poses.

Model: a bundle adjustment whose points are patches of the world. Every frame has errors of its position, heading, roll
and pitch, of which more or less is known beforehand; every patch has a height of its own, of which nothing is, so that
it does not matter whether it shows leaves or ground, nor how high the trees are. All of it is solved together.

Sources: Triggs, McLauchlan, Hartley and Fitzgibbon, *Bundle Adjustment: A Modern Synthesis*, Vision Algorithms, 2000
(elimination of the points, robust weights); the weights are Cauchy's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.registration.ties import Ties

if TYPE_CHECKING:
    from scipy.sparse import csr_array

POSE_ERRORS = 6
"""Number of errors of a pose: east, north, up (m), yaw (rad, clockwise), turns about east and north (rad)."""

TIE_M = 0.06
"""Standard deviation of a displacement between two frames along each axis."""
PATCH_HEIGHT_M = 300.0
"""Standard deviation of a patch's height about where it is looked for: so wide that it says nothing. From a width like
that of real crowns the scale of the formation would be inferred: the smaller it is taken to be, the less heights
differ."""
MAX_HEIGHT_SHARE = 0.7
"""Share of the cameras' height above the patches by which these may be higher or lower."""

ITERATIONS = 8
CAUCHY_SIGMAS = 2.0
"""Residuals of this size count half."""
INLIER_SIGMAS = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Gaussian:
    """A normal distribution."""

    mean: NDArray[np.float64]
    """Shape (k,)."""
    covariance: NDArray[np.float64]
    """Shape (k, k)."""


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """Result of the adjustment of one step's ties."""

    errors: Gaussian
    """Errors of the frames' poses, one after the other, shape (``POSE_ERRORS`` n,); the prior included."""
    height_m: float
    """Median of the patches' heights above where they were looked for."""
    inlier_share: float
    """Share of the ties that fit."""


def adjust(
    ties: Ties,
    poses: Sequence[Pose],
    patches_m: NDArray[np.float64],
    *,
    patch_spacing: float,
    applied: NDArray[np.float64],
    prior: Gaussian,
) -> Solution:
    """Solve for the errors of the frames' poses and for the heights of the patches.

    Args:
        ties: measured with ``poses``; at least one.
        poses: poses of the n frames, with the errors ``applied`` corrected.
        patches_m: centres of the patches, shape (m, 3).
        patch_spacing: distance of their centres, in edges of a patch; what neighbours share counts once.
        applied: shape (``POSE_ERRORS`` n,).
        prior: expected errors of the frames' poses.
    """
    seen_patches, patch = np.unique(ties.patch, return_inverse=True)
    geometry = _Geometry.of(ties, poses, patches_m)
    information = np.linalg.inv(prior.covariance)
    errors = applied.copy()
    heights_m = np.zeros(len(seen_patches))
    reach_m = MAX_HEIGHT_SHARE * float(np.abs(geometry.first.depth_m).min())
    share = patch_spacing**2 / _repetitions(ties, patch)
    # Which ties are of which patch, shape (ties, patches).
    to_patch = _sparse(np.ones(len(patch)), np.arange(len(patch)), patch, (len(patch), len(heights_m)))
    for _ in range(ITERATIONS):
        predicted_m, J, J_height = geometry.predict(errors - applied, heights_m[patch])
        residual_m = ties.displacement_m - predicted_m
        sigmas = np.linalg.norm(residual_m, axis=1) / TIE_M
        weights = share / (1.0 + (sigmas / CAUCHY_SIGMAS) ** 2) / TIE_M**2
        W = np.repeat(weights, 2)
        N = (J.T.multiply(W) @ J).toarray() + information
        right = J.T @ (W * residual_m.ravel()) - information @ (errors - prior.mean)
        # Each patch has one height, in ties of its own only: heights are eliminated by division.
        own = np.asarray(to_patch.T @ (weights * np.sum(J_height**2, axis=1))) + PATCH_HEIGHT_M**-2.0
        cross = J.T @ _spread(to_patch, weights[:, np.newaxis] * J_height)
        right_own = np.asarray(to_patch.T @ (weights * np.sum(J_height * residual_m, axis=1)))
        right_own -= heights_m / PATCH_HEIGHT_M**2
        reduced = N - (cross.multiply(1.0 / own) @ cross.T).toarray()
        step = np.linalg.solve(reduced, right - cross @ (right_own / own))
        errors = errors + step
        heights_m = np.clip(heights_m + (right_own - cross.T @ step) / own, -reach_m, reach_m)
    covariance = np.linalg.inv(reduced)
    return Solution(
        errors=Gaussian(errors, (covariance + covariance.T) / 2.0),
        height_m=float(np.median(heights_m)),
        inlier_share=float(np.mean(sigmas < INLIER_SIGMAS)),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Side:
    """Positions at which the first, or the second, frames of the ties show their patches; arrays of k rows."""

    frame: NDArray[np.intp]
    centre_m: NDArray[np.float64]
    """Centre of projection, shape (k, 2)."""
    offset_m: NDArray[np.float64]
    """Offset of the patch from there, shape (k, 2)."""
    depth_m: NDArray[np.float64]
    """Depth of the patch below the camera, shape (k, 1); negative in worlds whose z points down."""
    by_error: NDArray[np.float64]
    """Derivative by errors of east, north, up and yaw, and by turns about x and y, shape (k, 2, 6)."""

    def shown_m(
        self, errors: NDArray[np.float64], height_m: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return the place on the patch's plane, and its derivatives by the errors and by the patch's height."""
        below_m = self.depth_m - height_m[:, np.newaxis]
        offset_m = self.offset_m + np.einsum("kij,kj->ki", self.by_error, errors[self.frame])
        # What is higher than the patch's plane is seen on it further out.
        enlargement = self.depth_m / below_m
        by_height = offset_m * self.depth_m / below_m**2
        return self.centre_m + offset_m * enlargement, self.by_error * enlargement[:, :, np.newaxis], by_height


@dataclass(frozen=True, slots=True, eq=False)
class _Geometry:
    first: _Side
    second: _Side

    @classmethod
    def of(cls, ties: Ties, poses: Sequence[Pose], patches_m: NDArray[np.float64]) -> _Geometry:
        positions_m = np.array([pose.position_enu_m for pose in poses])
        sides = [_side(frame, positions_m[frame], patches_m[ties.patch]) for frame in (ties.first, ties.second)]
        return cls(sides[0], sides[1])

    def predict(
        self, errors: NDArray[np.float64], height_m: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], csr_array, NDArray[np.float64]]:
        """Return the displacements, shape (k, 2), and their derivatives.

        By the errors, shape (2 k, 6 n), and by the height of the own patch, shape (k, 2).
        """
        by_frame = errors.reshape(-1, POSE_ERRORS)
        first_m, first_by_error, first_by_height = self.first.shown_m(by_frame, height_m)
        second_m, second_by_error, second_by_height = self.second.shown_m(by_frame, height_m)
        values = np.concatenate((-first_by_error, second_by_error), axis=2)
        columns = np.concatenate((_columns(self.first.frame), _columns(self.second.frame)), axis=1)
        column = np.repeat(columns, 2, axis=0)
        row = np.repeat(np.arange(2 * len(height_m)), values.shape[2])
        J = _sparse(values.ravel(), row, column.ravel(), (2 * len(height_m), len(errors)))
        return second_m - first_m, J, second_by_height - first_by_height


def _side(frame: NDArray[np.intp], position_m: NDArray[np.float64], patch_m: NDArray[np.float64]) -> _Side:
    x, y, z = (patch_m - position_m).T
    depth_m = -z
    zero, one = np.zeros(len(x)), np.ones(len(x))
    by_x = np.stack((-one, zero, -x / depth_m, -y, -x * y / depth_m, depth_m + x**2 / depth_m), axis=1)
    by_y = np.stack((zero, -one, -y / depth_m, x, -depth_m - y**2 / depth_m, x * y / depth_m), axis=1)
    return _Side(
        frame, position_m[:, :2], np.column_stack((x, y)), depth_m[:, np.newaxis], np.stack((by_x, by_y), axis=1)
    )


def _columns(frame: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return where a frame's errors stand among the unknowns, shape (k, 6)."""
    return np.asarray(POSE_ERRORS * frame[:, np.newaxis] + np.arange(POSE_ERRORS))


def _sparse(
    values: NDArray[np.float64], rows: NDArray[np.intp], columns: NDArray[np.intp], shape: tuple[int, int]
) -> csr_array:
    # Half a second to import, in every process that knows of registrations; few of them compute one.
    from scipy.sparse import csr_array  # noqa: PLC0415

    return csr_array((values, (rows, columns)), shape=shape)


def _spread(to_patch: csr_array, rows: NDArray[np.float64]) -> csr_array:
    """Return a sparse matrix, shape (2 k, m), with both entries of tie k, a row of (k, 2), in its patch's column."""
    tie, patch = to_patch.nonzero()
    row = np.column_stack((2 * tie, 2 * tie + 1)).ravel()
    return _sparse(rows[tie].ravel(), row, np.repeat(patch, 2), (2 * len(rows), to_patch.shape[1]))


def _repetitions(ties: Ties, patch: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return of each tie by how many its patch has more than it has news: n frames have n - 1 displacements."""
    frames = np.unique(
        np.concatenate([np.stack((patch, frame)) for frame in (ties.first, ties.second)], axis=1), axis=1
    )
    news = np.bincount(frames[0]) - 1
    return np.asarray((np.bincount(patch) / news)[patch], dtype=np.float64)
