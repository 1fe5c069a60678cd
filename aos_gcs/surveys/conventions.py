"""Conventions of the poses of recordings: the direction of their matrices, and the axes of camera and world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.geometry.poses import R_NED2ENU, Pose

_DIRECTIONS = ("world-to-camera", "camera-to-world")
_R_CAM2OPENCV = {"opencv": np.eye(3), "opengl": np.diag([1.0, -1.0, -1.0])}
"""Axes of the camera: right, down, forward; or right, up, backward."""
_R_FILE2ENU = {"enu": np.eye(3), "z-down": np.diag([1.0, -1.0, -1.0]), "ned": R_NED2ENU}
"""Axes of the world: east, north, up; east, south, down; north, east, down."""

NAMES = (*_DIRECTIONS, *_R_CAM2OPENCV, *_R_FILE2ENU)
"""All names of conventions."""


@dataclass(frozen=True, slots=True)
class PoseConvention:
    """Meaning of the matrices of poses."""

    is_camera_to_world: bool = False
    camera_axes: str = "opencv"
    world_axes: str | None = None
    """None: the world is used as it is, whatever its axes are; otherwise it is turned to east, north, up."""

    @property
    def R_file2world(self) -> NDArray[np.float64]:
        """Rotation from the axes of the file to those of the recording's world, shape (3, 3)."""
        return np.eye(3) if self.world_axes is None else _R_FILE2ENU[self.world_axes]

    def pose(self, R: NDArray[np.float64], t: NDArray[np.float64]) -> Pose:
        """Return the pose of a matrix's rotation, shape (3, 3), and translation, shape (3,)."""
        R_cam2file, centre = (R, t) if self.is_camera_to_world else (R.T, -R.T @ t)
        R_opencv2cam = _R_CAM2OPENCV[self.camera_axes].T
        return Pose(self.R_file2world @ centre, self.R_file2world @ R_cam2file @ R_opencv2cam)

    def matrix(self, pose: Pose) -> NDArray[np.float64]:
        """Return the matrix of a pose, shape (3, 4): the inverse of :meth:`pose`."""
        R_cam2file = self.R_file2world.T @ pose.R_cam2enu @ _R_CAM2OPENCV[self.camera_axes]
        centre = self.R_file2world.T @ pose.position_enu_m
        if self.is_camera_to_world:
            return np.column_stack((R_cam2file, centre))
        return np.column_stack((R_cam2file.T, -R_cam2file.T @ centre))

    def check(self, poses: Sequence[Pose]) -> None:
        """Refuse poses that cannot have been meant: cameras above a ground do not look up.

        Raises:
            InputDataError: if the axes of the world are named, and most cameras look up.
        """
        if self.world_axes is not None and poses and np.median([pose.R_cam2enu[2, 2] for pose in poses]) > 0.0:
            raise InputDataError(
                f"With the convention {self} most cameras look up: name other axes or another direction."
            )

    def __str__(self) -> str:
        words = [_DIRECTIONS[self.is_camera_to_world], self.camera_axes]
        return ",".join(words if self.world_axes is None else [*words, self.world_axes])


def parse_convention(text: str) -> PoseConvention:
    """Return the convention that names separated by commas stand for.

    Raises:
        ConfigurationError: if one is not known, or two of them exclude each other.
    """
    words = [word.strip() for word in text.split(",")]
    for word in words:
        if word not in NAMES:
            raise ConfigurationError(
                f"--convention does not know {word!r}: use {', '.join(NAMES)}, separated by commas."
            )
    chosen: list[str | None] = []
    for group in (_DIRECTIONS, _R_CAM2OPENCV, _R_FILE2ENU):
        given = [word for word in words if word in group]
        if len(given) > 1:
            raise ConfigurationError(f"--convention: {given[0]} and {given[1]} exclude each other.")
        chosen.append(given[0] if given else None)
    direction, camera_axes, world_axes = chosen
    return PoseConvention(direction == _DIRECTIONS[1], camera_axes or "opencv", world_axes)
