"""Model of what a calibration observes: where images show points, by camera, mount, clock and errors of the poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.surveys.calibration.tracks import FeatureTracks
from aos_gcs.surveys.motion import ImageMotion

COMMON = 7
"""Unknowns of all images: turns about the camera's right, down and forward (rad), relative focal length, k1, k2, offset
of the clock (s)."""
CLOCK = 6
"""Place of the clock's offset among them."""
_LENS = slice(3, 6)
"""Places of the focal length and the lens among them."""
OWN = 6
"""Unknowns of one image: errors of its position (m) and turns of its attitude (rad)."""
MIN_DEPTH_M = 0.01
"""Nearest points: those found where a camera is, as two images of one place have them, tell nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Unknowns:
    """Camera, errors of the poses, and points of the ground."""

    common: NDArray[np.float64]
    own: NDArray[np.float64]
    """Shape (n, ``OWN``)."""
    points_m: NDArray[np.float64]
    """Shape (m, 3)."""

    def plus(self, step: NDArray[np.float64], points_step_m: NDArray[np.float64]) -> Unknowns:
        """Return the unknowns after a step of the cameras' and of the points."""
        return Unknowns(
            self.common + step[:COMMON], self.own + step[COMMON:].reshape(-1, OWN), self.points_m + points_step_m
        )


def corrected_camera(camera: CameraModel, common: NDArray[np.float64]) -> CameraModel:
    """Return the camera with the common unknowns applied."""
    lens = camera.distortion or LensDistortion(LensModel.BROWN_CONRADY, (0.0,) * 5)
    k1, k2, *rest = lens.coefficients
    return replace(
        camera,
        fx_px=camera.fx_px * (1.0 + float(common[3])),
        fy_px=camera.fy_px * (1.0 + float(common[3])),
        distortion=LensDistortion(lens.model, (k1 + float(common[4]), k2 + float(common[5]), *rest)),
    )


class ObservationModel:
    """Places at which images show points, with the derivatives by all unknowns."""

    def __init__(self, tracks: FeatureTracks, camera: CameraModel, poses: Sequence[Pose], motion: ImageMotion) -> None:
        self._tracks, self._camera = tracks, camera
        image = tracks.image
        self._R = np.array([pose.R_cam2enu for pose in poses])[image]
        self._centre_m = np.array([pose.position_enu_m for pose in poses])[image]
        self._velocity = motion.velocity_mps[image]
        self._acceleration = motion.acceleration_mps2[image]
        self._rate = motion.rate_cam_radps[image]

    def residuals(self, unknowns: Unknowns) -> NDArray[np.float64]:
        """Return measured minus predicted places, shape (k, 2); NaN where a point is not in front of its camera."""
        normalised = _normalised(self._chain(unknowns).in_camera)
        return np.asarray(self._tracks.pixels - corrected_camera(self._camera, unknowns.common).to_pixels(normalised))

    def derivatives(self, unknowns: Unknowns) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the derivatives of the places.

        By the common and the image's own unknowns, shape (k, 2, ``COMMON`` + ``OWN``), and by the point, (k, 2, 3).
        """
        chain, offset_s = self._chain(unknowns), float(unknowns.common[CLOCK])
        own_turns = unknowns.own[self._tracks.image, 3:]
        by_point = chain.own_turn @ chain.mount_turn @ chain.to_camera
        shift = self._velocity + self._acceleration * offset_s
        turn = np.cross(self._rate, chain.recorded)
        by_clock = -by_point @ shift[..., np.newaxis] - (chain.own_turn @ chain.mount_turn) @ turn[..., np.newaxis]
        by_mount = chain.own_turn @ chain.mount_turn @ _turned(chain.recorded, unknowns.common[:3])
        by_own_turn = chain.own_turn @ _turned(chain.mounted, own_turns)
        projected = self._projection(chain.in_camera, unknowns.common)
        lens = self._lens_derivatives(chain.in_camera, unknowns.common)
        J_point = projected @ by_point
        J = (projected @ by_mount, lens, projected @ by_clock, -J_point, projected @ by_own_turn)
        return np.concatenate(J, axis=2), J_point

    def _chain(self, unknowns: Unknowns) -> _Chain:
        """Return the points in the cameras, and the turns that bring them there, of all observations."""
        tracks, offset_s = self._tracks, float(unknowns.common[CLOCK])
        own = unknowns.own[tracks.image]
        centre_m = self._centre_m + self._velocity * offset_s + 0.5 * self._acceleration * offset_s**2 + own[:, :3]
        to_camera = _turns(-self._rate * offset_s) @ self._R.transpose(0, 2, 1)
        mount_turn, own_turn = _turns(-unknowns.common[:3]), _turns(-own[:, 3:])
        recorded = _apply(to_camera, unknowns.points_m[tracks.point] - centre_m)
        mounted = recorded @ mount_turn.T
        return _Chain(to_camera, mount_turn, own_turn, recorded, mounted, _apply(own_turn, mounted))

    def _projection(self, in_camera: NDArray[np.float64], common: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the derivatives of pixels by the point in the camera, shape (k, 2, 3)."""
        camera, normalised = corrected_camera(self._camera, common), _normalised(in_camera)
        h = 1e-6
        sides = [
            camera.to_pixels(normalised + h * axis) - camera.to_pixels(normalised - h * axis) for axis in np.eye(2)
        ]
        by_normalised = np.stack(sides, axis=2) / (2.0 * h)
        flat = np.zeros((len(in_camera), 2, 3))
        flat[:, 0, 0] = flat[:, 1, 1] = 1.0
        flat[:, :, 2] = -normalised
        return np.asarray(by_normalised @ flat / in_camera[:, 2, np.newaxis, np.newaxis])

    def _lens_derivatives(self, in_camera: NDArray[np.float64], common: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the derivatives of pixels by the relative focal length, k1 and k2, shape (k, 2, 3)."""
        normalised, h = _normalised(in_camera), 1e-6
        columns = []
        for step in h * np.eye(COMMON)[_LENS]:
            sides = (corrected_camera(self._camera, common + sign * step).to_pixels(normalised) for sign in (1.0, -1.0))
            columns.append(np.subtract(*sides) / (2.0 * h))
        return np.stack(columns, axis=2)


@dataclass(frozen=True, slots=True, eq=False)
class _Chain:
    """Way of each observed point into its camera."""

    to_camera: NDArray[np.float64]
    """Rotation into the camera as it is recorded, at the time of the exposure, shape (k, 3, 3)."""
    mount_turn: NDArray[np.float64]
    """Rotation by the mount, shape (3, 3)."""
    own_turn: NDArray[np.float64]
    """Rotation by the error of the image's attitude, shape (k, 3, 3)."""
    recorded: NDArray[np.float64]
    """Point in the camera as it is recorded, shape (k, 3), in m."""
    mounted: NDArray[np.float64]
    """Point in the camera as it is mounted."""
    in_camera: NDArray[np.float64]


def _turns(rotation_vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(Rotation.from_rotvec(rotation_vectors).as_matrix())


def _apply(turns: NDArray[np.float64], vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray((turns @ vectors[..., np.newaxis])[..., 0])


def _normalised(in_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (x / z, y / z), shape (k, 2); NaN where a point is not in front of the camera, or as near as none is."""
    depth_m = in_camera[:, 2:]
    in_front = depth_m > MIN_DEPTH_M
    return np.where(in_front, in_camera[:, :2] / np.where(in_front, depth_m, 1.0), np.nan)


def _turned(vectors: NDArray[np.float64], turns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return R(t) d(R(-t) v) / dt of rotation vectors t, shape (k, 3, 3).

    Source: Sola, Deray and Atchuthan, *A micro Lie theory for state estimation in robotics*, 2018, eq. 143 (the right
    Jacobian), as a series to the fourth order in t: turns of mounts and errors of attitudes are small.
    """
    power, right = np.eye(3), np.eye(3)
    for divisor in (2.0, 3.0, 4.0, 5.0):
        power = power @ _cross_matrices(turns) / divisor
        right = right + power
    return np.asarray(_cross_matrices(vectors) @ right)


def _cross_matrices(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the matrices that multiply as the cross product does, shape (..., 3, 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    return np.stack((zero, -z, y, z, zero, -x, -y, x, zero), axis=-1).reshape(*vectors.shape, 3)
