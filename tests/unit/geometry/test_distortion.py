import dataclasses

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geometry.projection import Plane, intersect_plane, plane_to_image, project_points
from aos_gcs.store.codec import decode, encode

PINHOLE = CameraModel.from_fov(640, 512, np.radians(60.0))
BROWN = LensDistortion(LensModel.BROWN_CONRADY, (-0.28, 0.11, 0.0012, -0.0007, -0.02))
PINCUSHION = LensDistortion(LensModel.BROWN_CONRADY, (0.15, 0.02, -0.001, 0.002, 0.0))
FISHEYE = LensDistortion(LensModel.FISHEYE, (-0.03, 0.012, -0.004, 0.0005))
NONE = LensDistortion(LensModel.BROWN_CONRADY, (0.0,) * 5)
LENSES = pytest.mark.parametrize("lens", [BROWN, PINCUSHION, FISHEYE, NONE], ids=["barrel", "pincushion", "fish", "0"])


def camera_with(lens: LensDistortion) -> CameraModel:
    return dataclasses.replace(PINHOLE, distortion=lens)


brown_lenses = st.builds(
    lambda *k: LensDistortion(LensModel.BROWN_CONRADY, k),
    st.floats(-0.35, 0.3),
    st.floats(-0.1, 0.15),
    st.floats(-0.003, 0.003),
    st.floats(-0.003, 0.003),
    st.floats(-0.03, 0.03),
)
fisheye_lenses = st.builds(
    lambda *k: LensDistortion(LensModel.FISHEYE, k), *(st.floats(-scale, scale) for scale in (0.1, 0.03, 0.01, 0.003))
)


@given(lens=st.one_of(brown_lenses, fisheye_lenses), radius=st.floats(0.0, 0.9), angle=st.floats(-4.0, 4.0))
def test_undistortion_inverts_distortion(lens: LensDistortion, radius: float, angle: float) -> None:
    # Close to where the image turns back the inverse is badly conditioned.
    r = radius * min(1.0, lens.max_radius)
    point = np.array([[r * np.cos(angle), r * np.sin(angle)]])
    np.testing.assert_allclose(lens.undistort(lens.distort(point)), point, atol=1e-7)


@given(lens=st.one_of(brown_lenses, fisheye_lenses), x=st.floats(-0.4, 0.4), y=st.floats(-0.4, 0.4))
def test_coefficients_have_opencvs_meaning(lens: LensDistortion, x: float, y: float) -> None:
    point, zero = np.array([[[x, y, 1.0]]]), np.zeros(3)
    k = np.array(lens.coefficients)
    project = cv2.fisheye.projectPoints if lens.model is LensModel.FISHEYE else cv2.projectPoints
    expected = project(point, zero, zero, PINHOLE.K, k)[0].reshape(1, 2)
    np.testing.assert_allclose(camera_with(lens).to_pixels([[x, y]]), expected, atol=1e-6)


@LENSES
def test_every_pixel_has_a_ray_that_leads_back_to_it(lens: LensDistortion) -> None:
    camera = camera_with(lens)
    u, v = np.meshgrid(np.linspace(-0.5, 639.5, 41), np.linspace(-0.5, 511.5, 33))
    pixels = np.stack((u.ravel(), v.ravel()), axis=1)
    pose = nadir_pose([3.0, -2.0, 40.0], 0.7)
    ground = intersect_plane(pixels, camera, pose, Plane(1.0, 0.1, -0.05))
    assert np.isfinite(ground).all()
    np.testing.assert_allclose(ground[:, 2], 1.0 + 0.1 * ground[:, 0] - 0.05 * ground[:, 1], atol=1e-9)
    np.testing.assert_allclose(project_points(ground, camera, pose), pixels, atol=1e-4)


@LENSES
def test_the_ideal_camera_sees_all_that_the_lens_sees(lens: LensDistortion) -> None:
    camera = camera_with(lens)
    ideal = camera.ideal()
    assert ideal.distortion is None
    assert (ideal.cx_px - camera.cx_px) % 1.0 == 0.0
    u, v = np.meshgrid(np.linspace(0, 639, 60), np.linspace(0, 511, 60))
    there = ideal.to_pixels(camera.from_pixels(np.stack((u, v), axis=-1)))
    assert (there >= -0.5).all()
    assert (there <= [ideal.width_px - 0.5, ideal.height_px - 0.5]).all()
    assert ideal.width_px <= there[..., 0].max() - there[..., 0].min() + 4


def test_a_camera_without_distortion_is_its_own_ideal() -> None:
    assert PINHOLE.ideal() is PINHOLE
    assert camera_with(NONE).ideal() == PINHOLE


def test_nothing_is_imaged_from_beyond_the_turn_of_a_polynomial() -> None:
    lens = LensDistortion(LensModel.BROWN_CONRADY, (-0.3, 0.0, 0.0, 0.0, 0.0))
    assert lens.max_radius == pytest.approx((1 / 0.9) ** 0.5)
    assert np.isfinite(lens.distort([1.05, 0.0])).all()
    assert np.isnan(lens.distort([1.06, 0.0])).all()
    # The largest real radius is 2/3 of that; no point is imaged further out.
    assert np.isnan(lens.undistort([0.71, 0.0])).all()
    assert np.isnan(project_points([[50.0, 0.0, 0.0]], camera_with(lens), nadir_pose([0, 0, 30]))).all()


def test_a_wide_fisheye_keeps_to_its_limit() -> None:
    wide = CameraModel(600, 600, 190.0, 190.0, 299.5, 299.5, LensDistortion(LensModel.FISHEYE, (0.0,) * 4))
    assert np.isnan(wide.from_pixels([599.0, 299.5])).all()
    np.testing.assert_allclose(wide.from_pixels([299.5 + 190.0 * np.pi / 4, 299.5]), [1.0, 0.0], atol=1e-9)
    assert wide.ideal().width_px < 2 * 190 * np.tan(np.radians(75.0)) + 3


@pytest.mark.parametrize(
    ("model", "coefficients", "message"),
    [
        (LensModel.FISHEYE, (0.0,) * 5, "fisheye model has 4 coefficients, got 5"),
        (LensModel.BROWN_CONRADY, (0.0,) * 4, "brown-conrady model has 5 coefficients, got 4"),
        (LensModel.FISHEYE, (0.0, float("nan"), 0.0, 0.0), "must be finite"),
    ],
)
def test_bad_coefficients_are_refused(model: LensModel, coefficients: tuple[float, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        LensDistortion(model, coefficients)


@pytest.mark.parametrize("camera", [PINHOLE, camera_with(BROWN), camera_with(FISHEYE)])
def test_cameras_survive_the_record(camera: CameraModel) -> None:
    assert decode(CameraModel, encode(camera)) == camera


def test_records_from_before_distortion_are_read() -> None:
    record = encode(PINHOLE)
    assert isinstance(record, dict)
    del record["distortion"]
    assert decode(CameraModel, record) == PINHOLE


@given(x=st.floats(-50.0, 50.0), y=st.floats(-50.0, 50.0), a=st.floats(-0.5, 0.5), b=st.floats(-0.5, 0.5))
def test_homography_of_a_tilted_plane(x: float, y: float, a: float, b: float) -> None:
    pose, plane = nadir_pose([2.0, 1.0, 80.0], 0.4), Plane.through([1.0, 2.0, 3.0], a, b)
    u, v, depth_m = plane_to_image(PINHOLE, pose, plane) @ [x, y, 1.0]
    point = np.array([x, y, float(plane.z_m(x, y))])
    assert depth_m == pytest.approx(80.0 - point[2])
    np.testing.assert_allclose([u / depth_m, v / depth_m], project_points([point], PINHOLE, pose)[0], atol=1e-6)
    assert plane.gap_m(point) == pytest.approx(0.0, abs=1e-9)
