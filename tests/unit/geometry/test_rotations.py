import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from aos_gcs.geometry.rotations import (
    R_from_quaternion,
    R_from_rotation_vector,
    R_from_yaw_pitch_roll,
    quaternion_from_R,
    slerp,
    yaw_pitch_roll_from_R,
)

angles = st.floats(-math.pi, math.pi)
vectors = st.tuples(angles, angles, angles)
quaternions = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: np.linalg.norm(q) > 1e-3)


@given(quaternions)
def test_quaternions_are_rotations_as_scipy_has_them(q_wxyz: tuple[float, float, float, float]) -> None:
    rotation = Rotation.from_quat(q_wxyz, scalar_first=True)
    np.testing.assert_allclose(R_from_quaternion(q_wxyz), rotation.as_matrix(), atol=1e-14)


@pytest.mark.parametrize("size", [1e-200, 1e200])
def test_quaternions_of_any_size_are_rotations(size: float) -> None:
    np.testing.assert_allclose(R_from_quaternion([0.0, size, 0.0, 0.0]), np.diag([1.0, -1.0, -1.0]), atol=1e-15)


@given(vectors)
@example((math.pi, 0.0, 0.0))
@example((0.0, math.pi, 0.0))
@example((0.0, 0.0, math.pi))
@example((0.0, 0.0, 0.0))
@example((1e-9, 0.0, 0.0))
def test_quaternions_of_turns_by_any_angle_keep_all_digits(vector_rad: tuple[float, float, float]) -> None:
    R = Rotation.from_rotvec(vector_rad).as_matrix()
    q_wxyz = quaternion_from_R(R)
    assert q_wxyz[0] >= 0.0
    assert np.linalg.norm(q_wxyz) == pytest.approx(1.0, abs=1e-14)
    np.testing.assert_allclose(R_from_quaternion(q_wxyz), R, atol=1e-14)


@given(vectors)
def test_yaw_pitch_and_roll_turn_in_this_order(yaw_pitch_roll_rad: tuple[float, float, float]) -> None:
    expected = Rotation.from_euler("ZYX", yaw_pitch_roll_rad).as_matrix()
    np.testing.assert_allclose(R_from_yaw_pitch_roll(yaw_pitch_roll_rad), expected, atol=1e-14)


@given(vectors)
@example((0.0, 0.0, 0.0))
@example((1e-300, 0.0, 0.0))
def test_rotation_vectors_turn_by_their_length(vector_rad: tuple[float, float, float]) -> None:
    expected = Rotation.from_rotvec(vector_rad).as_matrix()
    np.testing.assert_allclose(R_from_rotation_vector(vector_rad), expected, atol=1e-14)


@given(st.floats(0.0, 1.0), vectors, st.tuples(*[st.floats(-1.7, 1.7)] * 3))
@example(0.3, (0.1, 0.2, 0.3), (0.0, 0.0, 0.0))
def test_slerp_takes_the_shortest_arc(
    share: float, start_rad: tuple[float, float, float], turn_rad: tuple[float, float, float]
) -> None:
    start = Rotation.from_rotvec(start_rad)
    both = Rotation.concatenate([start, start * Rotation.from_rotvec(turn_rad)])
    expected = Slerp([0.0, 1.0], both)(share).as_matrix()
    np.testing.assert_allclose(slerp(share, *both.as_matrix()), expected, atol=1e-13)


@given(st.floats(-math.pi, math.pi), st.floats(-math.pi / 2, math.pi / 2), st.floats(-math.pi, math.pi))
@example(0.7, -math.pi / 2, 0.0)
@example(0.7, -math.pi / 2, 0.2)
@example(-3.0, math.pi / 2 - 1e-9, 3.0)
def test_angles_are_read_back_from_a_matrix(yaw: float, pitch: float, roll: float) -> None:
    R = R_from_yaw_pitch_roll((yaw, pitch, roll))
    np.testing.assert_allclose(R_from_yaw_pitch_roll(yaw_pitch_roll_from_R(R)), R, atol=1e-6)
