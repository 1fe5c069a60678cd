"""The least squares of calibration: one camera and mount, small errors of all poses, and the points of the ground.

A bundle adjustment in which positions and attitudes are observations with standard deviations, positions with a drift
that neighbours share, too, and what all images have in common is unknown: the turn of the camera against its recorded
attitude, the focal length, two coefficients of the lens, and the offset of the clock.

Source: Triggs, McLauchlan, Hartley and Fitzgibbon, *Bundle Adjustment: A Modern Synthesis*, Vision Algorithms, 2000
(elimination of the points, robust weights); the weights are Cauchy's, the steps Levenberg's and Marquardt's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.surveys.calibration.observations import COMMON, OWN, ObservationModel, Unknowns
from aos_gcs.surveys.calibration.tracks import FeatureTracks
from aos_gcs.surveys.motion import ImageMotion

PRIOR_SIGMAS = np.array([np.radians(3.0)] * 3 + [0.05, 0.1, 0.1, 0.3])
"""Standard deviations of the common unknowns before anything is measured."""

ITERATIONS = 30
CAUCHY_SIGMAS = 2.0
MIN_SIGMA_PX = 0.2
_LEAST_SHARE = 1e-9
"""Smallest information on a point in one direction, as a share of that in the best."""
_CONVERGED = 1e-3
"""Largest step, in standard deviations of the result, after which no further is made."""


@dataclass(frozen=True, slots=True, eq=False)
class Sigmas:
    """Standard deviations of the recorded poses; arrays with one row per image."""

    position_m: NDArray[np.float64]
    """Standard deviations along each axis of what differs from one image to the next, shape (n, 3)."""
    attitude_rad: float
    """Standard deviation of what differs from one image to the next."""
    drift_m: NDArray[np.float64]
    """Standard deviation along each axis of what images have in common with their neighbours, shape (n,)."""
    drift_at: NDArray[np.float64]
    """Time of each image in units of that in which a drift changes, shape (n,)."""

    def of(self, chosen: NDArray[np.intp]) -> Sigmas:
        """Return the standard deviations of some images."""
        return Sigmas(self.position_m[chosen], self.attitude_rad, self.drift_m[chosen], self.drift_at[chosen])

    def position_information(self, axis: int) -> NDArray[np.float64]:
        """Return the inverse covariance of the errors of all positions along an axis, shape (n, n), in 1/m²."""
        apart = np.abs(self.drift_at[:, np.newaxis] - self.drift_at)
        common = np.outer(self.drift_m, self.drift_m) * np.exp(-apart)
        return np.asarray(np.linalg.inv(common + np.diag(self.position_m[:, axis] ** 2)))


@dataclass(frozen=True, slots=True, eq=False)
class Adjusted:
    """Result of an adjustment."""

    common: NDArray[np.float64]
    """Shape (``COMMON``,)."""
    own: NDArray[np.float64]
    """Errors of the recorded poses, shape (n, ``OWN``)."""
    covariance: NDArray[np.float64]
    """Shape (``COMMON``, ``COMMON``)."""
    before_px: float
    """Median distance of measured and predicted places with the recorded poses and camera."""
    after_px: float
    position_error_sigmas: float
    """Root mean square of the errors of the recorded positions, by their covariance: about 1, or less."""
    attitude_error_sigmas: float


def adjust(
    tracks: FeatureTracks,
    points_m: NDArray[np.float64],
    camera: CameraModel,
    *,
    poses: Sequence[Pose],
    motion: ImageMotion,
    sigmas: Sigmas,
    fixed: NDArray[np.bool_],
    min_sigma_px: float = MIN_SIGMA_PX,
) -> Adjusted:
    """Solve for the camera, its mount and its clock.

    Args:
        tracks: observations of the points.
        points_m: first estimates of the points, shape (m, 3).
        camera: camera as it is known.
        poses: recorded poses of the n images.
        motion: motion at the images.
        sigmas: standard deviations of the recorded poses.
        fixed: common unknowns that stay as they are, shape (``COMMON``,).
        min_sigma_px: smallest standard deviation that a measured place is taken to have along each axis.
    """
    model = ObservationModel(tracks, camera, poses, motion)
    information = _information(sigmas)
    now = Unknowns(np.zeros(COMMON), np.zeros((len(poses), OWN)), points_m)
    residual = model.residuals(now)
    before_px = float(np.nanmedian(np.linalg.norm(residual, axis=1)))
    damping = 1e-3
    covariance = np.diag(PRIOR_SIGMAS**2)
    for _ in range(ITERATIONS):
        sigma_px = _sigma_px(residual, min_sigma_px)
        system = _System.of(
            model, now, residual, sigma_px=sigma_px, tracks=tracks, information=information, fixed=fixed
        )
        cost = _cost(residual, now, sigma_px, information)
        while damping < 1e6:
            step, points_step_m = system.step(damping)
            tried = now.plus(step, points_step_m)
            tried_residual = model.residuals(tried)
            if _cost(tried_residual, tried, sigma_px, information) <= cost:
                break
            damping *= 10.0
        else:
            break
        now, residual, damping = tried, tried_residual, max(damping / 10.0, 1e-9)
        covariance = np.where(fixed | fixed[:, np.newaxis], 0.0, system.covariance())
        if (np.abs(step[:COMMON]) < _CONVERGED * np.sqrt(np.diag(covariance)) + 1e-12).all():
            break
    after_px = float(np.nanmedian(np.linalg.norm(residual, axis=1)))
    positions_m = now.own[:, :3]
    squares = [positions_m[:, axis] @ sigmas.position_information(axis) @ positions_m[:, axis] for axis in range(3)]
    return Adjusted(
        now.common,
        now.own,
        covariance,
        before_px,
        after_px,
        float(np.sqrt(np.sum(squares) / positions_m.size)),
        float(np.sqrt(np.mean((now.own[:, 3:] / sigmas.attitude_rad) ** 2))),
    )


def _information(sigmas: Sigmas) -> NDArray[np.float64]:
    """Return the inverse covariance of the common and all own unknowns before anything is measured."""
    count = len(sigmas.position_m)
    diagonal = np.full(COMMON + OWN * count, sigmas.attitude_rad)
    diagonal[:COMMON] = PRIOR_SIGMAS
    information = np.diag(diagonal**-2.0)
    for axis in range(3):
        rows = COMMON + OWN * np.arange(count) + axis
        information[np.ix_(rows, rows)] = sigmas.position_information(axis)
    return information


def _sigma_px(residual: NDArray[np.float64], min_sigma_px: float) -> float:
    return max(min_sigma_px, 1.4826 * float(np.nanmedian(np.abs(residual))))


def _cost(
    residual: NDArray[np.float64], unknowns: Unknowns, sigma_px: float, information: NDArray[np.float64]
) -> float:
    squares = np.sum(residual**2, axis=1) / (CAUCHY_SIGMAS * sigma_px) ** 2
    # What has left the image costs as much as an outlier of ten standard deviations.
    robust = CAUCHY_SIGMAS**2 * np.log1p(np.where(np.isfinite(squares), squares, 25.0)).sum()
    errors = np.concatenate((unknowns.common, unknowns.own.ravel()))
    return float(robust + errors @ information @ errors)


@dataclass(frozen=True, slots=True, eq=False)
class _System:
    """Normal equations, in blocks: cameras, points (3 x 3 each), and between them."""

    N: NDArray[np.float64]
    right: NDArray[np.float64]
    N_points: NDArray[np.float64]
    """Shape (m, 3, 3)."""
    right_points: NDArray[np.float64]
    cross: NDArray[np.float64]
    """Shape (cameras, m, 3)."""

    @classmethod
    def of(
        cls,
        model: ObservationModel,
        unknowns: Unknowns,
        residual: NDArray[np.float64],
        *,
        sigma_px: float,
        tracks: FeatureTracks,
        information: NDArray[np.float64],
        fixed: NDArray[np.bool_],
    ) -> _System:
        """Linearise about the unknowns."""
        J, J_point = model.derivatives(unknowns)
        seen = (
            np.isfinite(residual).all(axis=1) & np.isfinite(J).all(axis=(1, 2)) & np.isfinite(J_point).all(axis=(1, 2))
        )
        # No place depends on what is held, so that no step changes it.
        J[:, :, :COMMON][:, :, fixed] = 0.0
        J, J_point, residual = J[seen], J_point[seen], residual[seen]
        image, point = tracks.image[seen], tracks.point[seen]
        squares = np.sum(residual**2, axis=1) / sigma_px**2
        weights = 1.0 / (1.0 + squares / CAUCHY_SIGMAS**2) / sigma_px**2
        size, count = len(information), len(unknowns.points_m)
        own = COMMON + OWN * image[:, np.newaxis] + np.arange(OWN)
        columns = np.concatenate((np.broadcast_to(np.arange(COMMON), (len(image), COMMON)), own), axis=1)
        A, B = _sparse(J, columns, size), _sparse(J_point, 3 * point[:, np.newaxis] + np.arange(3), 3 * count)
        W = np.repeat(weights, 2)
        AW = A.T.multiply(W).tocsr()
        N_points, right_points = np.zeros((count, 3, 3)), np.zeros((count, 3))
        np.add.at(N_points, point, np.einsum("k,kij,kil->kjl", weights, J_point, J_point))
        np.add.at(right_points, point, np.einsum("k,kij,ki->kj", weights, J_point, residual))
        errors = np.concatenate((unknowns.common, unknowns.own.ravel()))
        N = (AW @ A).toarray() + information
        cross = (AW @ B).toarray().reshape(size, count, 3)
        return cls(N, AW @ residual.ravel() - information @ errors, N_points, right_points, cross)

    def _reduced(self, damping: float) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return the normal equations without the points, the inverse blocks of these, and ``cross`` times them."""
        diagonal = np.einsum("mii->mi", self.N_points)
        # Points that hardly any parallax places would have no inverse.
        least = _LEAST_SHARE * diagonal.max(axis=1, keepdims=True) + 1e-9
        inverse = np.linalg.inv(self.N_points + np.eye(3) * (damping * diagonal + least)[:, np.newaxis, :])
        # One product per point: einsum takes fifteen times as long.
        weighted = (self.cross.transpose(1, 0, 2) @ inverse).transpose(1, 0, 2)
        size = len(self.N)
        N = self.N + damping * np.diag(np.diag(self.N))
        return N - weighted.reshape(size, -1) @ self.cross.reshape(size, -1).T, inverse, weighted

    def step(self, damping: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the step of the cameras' unknowns and of the points."""
        reduced, inverse, weighted = self._reduced(damping)
        size = len(self.N)
        step = np.linalg.solve(reduced, self.right - weighted.reshape(size, -1) @ self.right_points.ravel())
        left = self.right_points - (self.cross.reshape(size, -1).T @ step).reshape(-1, 3)
        return np.asarray(step, dtype=np.float64), np.einsum("mij,mj->mi", inverse, left)

    def covariance(self) -> NDArray[np.float64]:
        """Return the covariance of the common unknowns."""
        reduced = self._reduced(0.0)[0]
        # Unknowns in units of their own: the information on some is 1e6 times that on others.
        units = 1.0 / np.sqrt(np.diag(reduced))
        covariance = (np.linalg.inv(reduced * np.outer(units, units)) * np.outer(units, units))[:COMMON, :COMMON]
        return np.asarray((covariance + covariance.T) / 2.0)


def _sparse(blocks: NDArray[np.float64], columns: NDArray[np.intp], width: int) -> csr_array:
    """Return the rows of blocks, shape (k, r, c), in columns of shape (k, c), as one sparse matrix."""
    count, rows, length = blocks.shape
    wide = np.repeat(columns[:, np.newaxis, :], rows, axis=1)
    starts = np.arange(0, count * rows * length + 1, length)
    return csr_array((blocks.ravel(), wide.ravel(), starts), shape=(count * rows, width))
