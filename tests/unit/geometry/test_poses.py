import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.poses import (
    R_cam2enu_from_mavlink,
    R_from_quaternion,
    mavlink_quaternion_from_R_cam2enu,
    nadir_pose,
    quaternion_from_R,
)

angles = st.floats(-3.1, 3.1)


@given(angles, angles, angles)
def test_rotations_survive_quaternions(roll: float, pitch: float, yaw: float) -> None:
    R = Rotation.from_euler("xyz", [roll, pitch, yaw]).as_matrix()
    np.testing.assert_allclose(R_from_quaternion(quaternion_from_R(R)), R, atol=1e-12)
    np.testing.assert_allclose(R_cam2enu_from_mavlink(mavlink_quaternion_from_R_cam2enu(R)), R, atol=1e-12)


def test_level_mavlink_camera_looks_north_with_east_to_the_right() -> None:
    R_cam2enu = R_cam2enu_from_mavlink([1.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(R_cam2enu @ [0, 0, 1], [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(R_cam2enu @ [1, 0, 0], [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(R_cam2enu @ [0, 1, 0], [0, 0, -1], atol=1e-12)


def test_mavlink_camera_pitched_down_is_the_nadir_pose() -> None:
    half = -math.pi / 4
    R_cam2enu = R_cam2enu_from_mavlink([math.cos(half), 0.0, math.sin(half), 0.0])
    np.testing.assert_allclose(R_cam2enu, nadir_pose([0, 0, 0]).R_cam2enu, atol=1e-12)


@given(heading=st.floats(-7.0, 7.0))
def test_nadir_pose_has_its_upper_edge_at_the_heading(heading: float) -> None:
    R_cam2enu = nadir_pose([0, 0, 0], heading).R_cam2enu
    np.testing.assert_allclose(R_cam2enu @ [0, -1, 0], [math.sin(heading), math.cos(heading), 0], atol=1e-12)
    np.testing.assert_allclose(R_cam2enu @ R_cam2enu.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(R_cam2enu) == pytest.approx(1.0)


@pytest.mark.parametrize("quaternion", [[0.0, 0.0, 0.0, 0.0], [math.nan, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
def test_unusable_quaternions_are_refused(quaternion: list[float]) -> None:
    with pytest.raises(ValueError, match="quaternion"):
        R_from_quaternion(quaternion)


@given(
    latitude_deg=st.floats(-80.0, 80.0),
    longitude_deg=st.floats(-179.0, 179.0),
    enu_m=st.tuples(st.floats(-3000.0, 3000.0), st.floats(-3000.0, 3000.0), st.floats(-100.0, 500.0)),
)
def test_enu_survives_geodetic_coordinates(
    latitude_deg: float, longitude_deg: float, enu_m: tuple[float, float, float]
) -> None:
    frame = LocalFrame(GeodeticPosition(latitude_deg, longitude_deg, 300.0))
    np.testing.assert_allclose(frame.to_enu(frame.to_geodetic(enu_m)), enu_m, atol=1e-4)


def test_enu_axes_point_east_north_and_up() -> None:
    frame = LocalFrame(GeodeticPosition(48.3, 14.3, 300.0))
    east = frame.to_enu(GeodeticPosition(48.3, 14.301, 300.0))
    north = frame.to_enu(GeodeticPosition(48.301, 14.3, 300.0))
    up = frame.to_enu(GeodeticPosition(48.3, 14.3, 310.0))
    assert east[0] == pytest.approx(74.2, abs=0.1)
    assert north[1] == pytest.approx(111.2, abs=0.1)
    np.testing.assert_allclose(up, [0.0, 0.0, 10.0], atol=1e-6)


@given(width=st.integers(1, 4000), height=st.integers(1, 4000), fov_rad=st.floats(0.1, 3.0))
def test_camera_reports_the_field_of_view_it_was_made_with(width: int, height: int, fov_rad: float) -> None:
    camera = CameraModel.from_fov(width, height, fov_rad)
    assert camera.horizontal_fov_rad == pytest.approx(fov_rad)
    np.testing.assert_allclose(camera.K @ [0, 0, 1], [(width - 1) / 2, (height - 1) / 2, 1])


@pytest.mark.parametrize(("width", "height", "fov_rad"), [(0, 1, 1.0), (1, -1, 1.0), (1, 1, 0.0), (1, 1, math.pi)])
def test_impossible_cameras_are_refused(width: int, height: int, fov_rad: float) -> None:
    with pytest.raises(ValueError, match=r"size|field of view"):
        CameraModel.from_fov(width, height, fov_rad)
