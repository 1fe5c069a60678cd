import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_sim.render.rays import image_rays, pixel_rays, pixels_around, ray_directions

CAMERA = CameraModel.from_fov(64, 48, math.radians(50))
ANGLE = st.floats(-math.pi, math.pi)


def tilted_pose(position_enu_m: list[float], heading_rad: float, tilt_rad: float) -> Pose:
    nadir = nadir_pose(position_enu_m, heading_rad)
    sin, cos = math.sin(tilt_rad), math.cos(tilt_rad)
    return Pose(nadir.position_enu_m, nadir.R_cam2enu @ np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]]))


def test_ray_of_the_principal_point_is_the_optical_axis() -> None:
    camera = CameraModel(5, 3, 4.0, 4.0, 2.0, 1.0)
    directions = ray_directions(nadir_pose([0, 0, 10], heading_rad=0.7), camera).reshape(3, 5, 3)
    np.testing.assert_allclose(directions[1, 2], [0, 0, -1], atol=1e-6)


def test_upper_edge_of_a_nadir_image_lies_ahead_and_the_right_edge_to_the_right() -> None:
    camera = CameraModel(3, 3, 1.0, 1.0, 1.0, 1.0)
    directions = ray_directions(nadir_pose([0, 0, 10], heading_rad=math.pi / 2), camera).reshape(3, 3, 3)
    np.testing.assert_allclose(directions[0, 1], [1, 0, -1], atol=1e-6)  # heading east
    np.testing.assert_allclose(directions[1, 2], [0, -1, -1], atol=1e-6)  # right of east is south


@given(heading=ANGLE, tilt=st.floats(-1.5, 1.5), stride=st.integers(1, 3))
def test_some_pixels_have_the_rays_of_the_whole_image(heading: float, tilt: float, stride: int) -> None:
    pose = tilted_pose([3, -2, 20], heading, tilt)
    rays = ray_directions(pose, CAMERA).reshape(48, 64, 3)
    np.testing.assert_allclose(image_rays(pose, CAMERA, stride), rays[::stride, ::stride], atol=1e-6)
    pixels = np.array([0, 63, 64, 48 * 64 - 1])
    np.testing.assert_allclose(pixel_rays(pixels, pose, CAMERA), rays.reshape(-1, 3)[pixels], atol=1e-6)
    assert pixel_rays(np.empty(0, np.intp), pose, CAMERA).shape == (0, 3)


@given(heading=ANGLE, tilt=st.floats(-1.5, 1.5), seed=st.integers(0, 2**32 - 1))
def test_pixels_around_contain_every_pixel_that_points_project_to(heading: float, tilt: float, seed: int) -> None:
    points = np.random.default_rng(seed).uniform(-8, 8, (8, 3))
    pose = tilted_pose([0, 0, 20], heading, tilt)
    x, y, depth = ((points - pose.position_enu_m) @ pose.R_cam2enu).T
    ahead = depth > 0.1
    u = np.rint(CAMERA.fx_px * x[ahead] / depth[ahead] + CAMERA.cx_px)
    v = np.rint(CAMERA.fy_px * y[ahead] / depth[ahead] + CAMERA.cy_px)
    inside = (u >= 0) & (u < CAMERA.width_px) & (v >= 0) & (v < CAMERA.height_px)
    expected = v[inside] * CAMERA.width_px + u[inside]
    assert set(expected.astype(int)) <= set(pixels_around(points, pose, CAMERA).tolist())


def test_nothing_behind_the_camera_has_pixels() -> None:
    points = np.array([[0.0, 0.0, 30.0], [1.0, 1.0, 31.0]])
    assert len(pixels_around(points, nadir_pose([0, 0, 20]), CAMERA)) == 0


def test_points_beside_the_camera_ask_for_all_pixels() -> None:
    points = np.array([[5.0, 0.0, 25.0], [5.0, 0.0, 1.0]])
    assert len(pixels_around(points, nadir_pose([0, 0, 20]), CAMERA)) == 64 * 48
