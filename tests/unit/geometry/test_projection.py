import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import intersect_plane, plane_to_image, project_points

CAMERA = CameraModel.from_fov(640, 480, np.radians(50.0))

metres = st.floats(-500.0, 500.0)
pixels = st.tuples(st.floats(-0.5, 639.5), st.floats(-0.5, 479.5))


@st.composite
def downward_poses(draw: st.DrawFn) -> Pose:
    tilt = Rotation.from_euler("xyz", [draw(st.floats(-0.5, 0.5)) for _ in range(3)]).as_matrix()
    nadir = nadir_pose([draw(metres), draw(metres), draw(st.floats(5.0, 200.0))], draw(st.floats(-4.0, 4.0)))
    return Pose(nadir.position_enu_m, nadir.R_cam2enu @ tilt)


@given(pose=downward_poses(), pixel=pixels, height_m=st.floats(-20.0, 4.0))
def test_projection_inverts_the_intersection_with_a_plane(
    pose: Pose, pixel: tuple[float, float], height_m: float
) -> None:
    point = intersect_plane([pixel], CAMERA, pose, height_m)
    assert point[0, 2] == pytest.approx(height_m, abs=1e-9)
    np.testing.assert_allclose(project_points(point, CAMERA, pose), [pixel], atol=1e-6)


@given(pose=downward_poses(), x=metres, y=metres, height_m=st.floats(-20.0, 4.0))
def test_homography_of_a_plane_carries_the_depth_in_its_scale(pose: Pose, x: float, y: float, height_m: float) -> None:
    u, v, depth_m = plane_to_image(CAMERA, pose, height_m) @ [x, y, 1.0]
    assert depth_m == pytest.approx((np.array([x, y, height_m]) - pose.position_enu_m) @ pose.R_cam2enu[:, 2], abs=1e-9)
    if depth_m > 0.1:
        expected = project_points([[x, y, height_m]], CAMERA, pose)[0]
        np.testing.assert_allclose([u / depth_m, v / depth_m], expected, rtol=1e-9, atol=1e-6)


def test_nadir_camera_sees_north_above_and_east_to_the_right() -> None:
    pose = nadir_pose([10.0, 20.0, 30.0])
    centre, north, east = project_points([[10, 20, 0], [10, 21, 0], [11, 20, 0]], CAMERA, pose)
    np.testing.assert_allclose(centre, [319.5, 239.5])
    np.testing.assert_allclose(north - centre, [0.0, -CAMERA.fy_px / 30], atol=1e-9)
    np.testing.assert_allclose(east - centre, [CAMERA.fx_px / 30, 0.0], atol=1e-9)


def test_points_and_planes_behind_the_camera_have_no_image() -> None:
    pose = nadir_pose([0.0, 0.0, 30.0])
    assert np.isnan(project_points([[0.0, 0.0, 31.0]], CAMERA, pose)).all()
    assert np.isnan(intersect_plane([[319.5, 239.5]], CAMERA, pose, 31.0)).all()


def test_a_world_with_z_down_needs_nothing_special() -> None:
    looking_along_z = Pose(np.array([1.0, 2.0, -30.0]), np.eye(3))
    np.testing.assert_allclose(intersect_plane([[319.5, 239.5]], CAMERA, looking_along_z, 5.0), [[1.0, 2.0, 5.0]])
