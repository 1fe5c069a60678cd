"""Conventions of poses, there and back."""

from __future__ import annotations

import numpy as np
import pytest

from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.rotations import R_from_rotation_vector
from aos_gcs.surveys.conventions import parse_convention


@pytest.mark.parametrize(
    "names", ["opencv", "opengl", "camera-to-world,enu", "world-to-camera,opengl,z-down", "camera-to-world,ned"]
)
def test_a_pose_is_written_as_it_is_read(names: str) -> None:
    convention = parse_convention(names)
    turn = R_from_rotation_vector(np.array([0.1, -0.2, 0.3]))
    pose = Pose(np.array([3.0, -4.0, 35.0]), turn @ nadir_pose([0.0, 0.0, 0.0]).R_cam2enu)
    M = convention.matrix(pose)
    read = convention.pose(M[:, :3], M[:, 3])
    assert np.allclose(read.position_enu_m, pose.position_enu_m)
    assert np.allclose(read.R_cam2enu, pose.R_cam2enu)
