"""Frames rendered analytically over planes and terrain, recovered on perspective and orthographic rasters."""

import dataclasses
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import Plane, intersect_plane, pixel_rays
from aos_gcs.imaging.integral import ViewIntegral, integrate
from aos_gcs.imaging.model import FocalGrid, Frame, MapRaster
from aos_gcs.imaging.step.analysis import analyse_step
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.undistort import undistorted
from aos_gcs.imaging.views import FocalSurface, grid_view, ortho_view, perspective_view

PINHOLE = CameraModel.from_fov(96, 80, np.radians(50.0))
BARREL = dataclasses.replace(
    PINHOLE, distortion=LensDistortion(LensModel.BROWN_CONRADY, (-0.25, 0.08, 0.001, -0.002, 0.0))
)
FISHEYE = dataclasses.replace(PINHOLE, distortion=LensDistortion(LensModel.FISHEYE, (-0.02, 0.01, 0.0, 0.0)))
CAMERAS = pytest.mark.parametrize("camera", [PINHOLE, BARREL, FISHEYE], ids=["pinhole", "barrel", "fisheye"])
EXACT = pytest.mark.parametrize("exact", [True, False], ids=["exact", "fast"])

LEVEL, TILTED = Plane(1.0), Plane(1.0, 0.25, -0.15)
_x, _y = np.meshgrid(np.linspace(-40, 40, 321), np.linspace(-40, 40, 321))
HILLS = Terrain(-40.0, -40.0, 0.25, 2 * np.sin(_x / 5) + 1.5 * np.cos(_y / 4))
CLOSE_UP = MapRaster(-2.0, 1.5, 0.05, 50, 60, rows_along_y=False)
SURFACES = pytest.mark.parametrize("surface", [LEVEL, TILTED, HILLS], ids=["level", "tilted", "terrain"])


def texture(x_m: NDArray[np.float64], y_m: NDArray[np.float64]) -> NDArray[np.float64]:
    return 100 + 40 * np.sin(0.4 * x_m) + 30 * np.cos(0.3 * y_m + 0.2 * x_m)


def render(camera: CameraModel, pose: Pose, surface: FocalSurface) -> NDArray[np.float32]:
    """What a camera sees of the textured surface, shape (H, W, 1)."""
    u, v = np.meshgrid(np.arange(camera.width_px), np.arange(camera.height_px))
    pixels = np.stack((u.ravel(), v.ravel()), axis=1)
    if isinstance(surface, Plane):
        points = intersect_plane(pixels, camera, pose, surface)
    else:
        points = surface.intersect(pose.position_enu_m, pixel_rays(pixels, camera, pose))
    return texture(points[:, 0], points[:, 1]).reshape(*u.shape, 1).astype(np.float32)


def a_pose(rng: np.random.Generator) -> Pose:
    nadir = nadir_pose([*rng.uniform(-5, 5, 2), rng.uniform(30, 36)], rng.uniform(-3, 3))
    return Pose(nadir.position_enu_m, nadir.R_cam2enu @ Rotation.from_rotvec(rng.uniform(-0.15, 0.15, 3)).as_matrix())


@cache
def flight(camera: CameraModel, surface: FocalSurface, seed: int = 0, count: int = 5) -> list[Frame]:
    rng = np.random.default_rng(seed)
    poses = [a_pose(rng) for _ in range(count)]
    return [Frame(i, render(camera, pose, surface), ("grey",), pose, camera) for i, pose in enumerate(poses)]


@EXACT
@SURFACES
@CAMERAS
def test_the_texture_is_recovered_in_any_view(camera: CameraModel, surface: FocalSurface, exact: bool) -> None:
    virtual = a_pose(np.random.default_rng(7))
    frames = flight(camera, surface)
    integral, count = integrate(frames, perspective_view(PINHOLE, virtual, surface), exact=exact)
    assert (count == 5).sum() > 1000
    np.testing.assert_array_equal(np.isnan(integral[:, :, 0]), count == 0)
    error = np.abs(integral - render(PINHOLE, virtual, surface))
    assert np.nanmean(error) < 0.2
    assert np.nanmax(error) < 4.0
    # Off the surface the frames do not agree with each other.
    wrong = surface.moved(8.0) if isinstance(surface, Terrain) else dataclasses.replace(surface, height_m=9.0)
    blurred = integrate(frames, perspective_view(PINHOLE, virtual, wrong), exact=exact)[0]
    assert np.nanmean(np.abs(blurred - render(PINHOLE, virtual, surface))) > 3.0


@EXACT
@SURFACES
@pytest.mark.parametrize("rows_along_y", [False, True])
def test_the_texture_is_recovered_on_maps(surface: FocalSurface, exact: bool, rows_along_y: bool) -> None:
    raster = MapRaster(-12.0, -9.0 if rows_along_y else 9.0, 0.25, 72, 96, rows_along_y)
    integral, count = integrate(flight(BARREL, surface), ortho_view(raster, surface), exact=exact)
    x_m = -12.0 + 0.125 + 0.25 * np.arange(96)
    y_m = (-9.0 + 0.125 + 0.25 * np.arange(72)) * (1 if rows_along_y else -1)
    assert (count > 0).mean() > 0.9
    error = np.abs(integral[:, :, 0] - texture(*np.meshgrid(x_m, y_m)))
    assert np.nanmean(error) < 0.2
    assert np.nanmax(error) < 4.0


@EXACT
@CAMERAS
def test_a_plane_as_terrain_gives_what_the_plane_gives(camera: CameraModel, exact: bool) -> None:
    terrain = Terrain(-60.0, -60.0, 1.0, np.add.outer(np.arange(121.0) * -0.15, np.arange(121.0) * 0.25) - 5.0)
    frames, virtual = flight(camera, TILTED), a_pose(np.random.default_rng(3))
    plane = Plane(float(terrain.z_m(0.0, 0.0)), 0.25, -0.15)
    on_plane, count = integrate(frames, perspective_view(PINHOLE, virtual, plane), exact=exact)
    on_terrain, terrain_count = integrate(frames, perspective_view(PINHOLE, virtual, terrain), exact=exact)
    same = count == terrain_count
    assert (~same).sum() <= 10
    np.testing.assert_allclose(on_terrain[same], on_plane[same], atol=1e-4 if exact else 0.1)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), exact=st.booleans(), on_terrain=st.booleans())
def test_what_was_added_can_be_removed(seed: int, exact: bool, on_terrain: bool) -> None:
    rng = np.random.default_rng(seed)
    frames = [
        Frame(i, rng.integers(0, 255, (80, 96, 3), dtype=np.uint8), ("red", "green", "blue"), a_pose(rng), PINHOLE)
        for i in range(4)
    ]
    view = perspective_view(PINHOLE, a_pose(rng), HILLS if on_terrain else TILTED)
    integral = ViewIntegral(view, frames[0].bands, exact=exact)
    for frame in frames:
        integral.add(frame)
    integral.remove(frames[2])
    expected, count = integrate([frames[0], frames[1], frames[3]], view, exact=exact)
    np.testing.assert_array_equal(integral.coverage, count)
    np.testing.assert_allclose(integral.mean(), expected, atol=1e-3)
    for index in (0, 1, 3):
        integral.remove(frames[index])
    assert np.isnan(integral.mean()).all()
    with pytest.raises(ImagingError, match="vehicle 1 is not part of the integral"):
        integral.remove(frames[1])


@EXACT
@pytest.mark.parametrize("surface", [LEVEL, HILLS], ids=["plane", "terrain"])
def test_cameras_that_have_the_surface_behind_them_do_not_contribute(surface: FocalSurface, exact: bool) -> None:
    seeing = Frame(0, np.full((80, 96, 1), 5, dtype=np.uint8), ("grey",), nadir_pose([0, 0, 30]), PINHOLE)
    up = Pose(np.array([0.0, 0.0, 30.0]), np.diag([1.0, -1.0, -1.0]) @ np.diag([1.0, -1.0, -1.0]))
    level = Pose(np.array([0.0, 0.0, 1.0]), np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]))
    blind = [dataclasses.replace(seeing, image=seeing.image * 10, pose=pose) for pose in (up, nadir_pose([0, 0, -30]))]
    integral, count = integrate([seeing, *blind], perspective_view(PINHOLE, seeing.pose, surface), exact=exact)
    assert count.max() == 1
    assert np.nanmax(integral) == 5.0
    # A camera amid the surface sees only what lies before it.
    amid = dataclasses.replace(seeing, pose=level)
    raster = MapRaster(-20.0, 20.0, 0.5, 80, 80, rows_along_y=False)
    _, count = integrate([amid], ortho_view(raster, surface.moved(-1.0) if isinstance(surface, Terrain) else Plane(0)))
    assert count[:40].any()
    assert not count[40:].any()


@EXACT
def test_uncovered_and_infinite_pixels_stay_out(exact: bool) -> None:
    image = np.ones((80, 96, 2), dtype=np.float32)
    image[40, 48, 1] = np.inf
    frame = Frame(0, image, ("a", "b"), nadir_pose([0, 0, 30]), BARREL)
    for surface in (LEVEL, HILLS):
        integral, count = integrate([frame], perspective_view(PINHOLE, frame.pose, surface), exact=exact)
        assert 0 < (count[30:50, 38:58] == 0).sum() <= 16
        np.testing.assert_allclose(integral[count > 0], 1.0, rtol=1e-6)


def test_gaps_of_one_frame_cost_nothing_but_its_cells() -> None:
    rng = np.random.default_rng(11)
    whole = flight(PINHOLE, LEVEL, seed=2, count=3)
    image = whole[1].image.copy()
    image[rng.random(image.shape[:2]) < 0.01] = np.nan
    gappy = dataclasses.replace(whole[1], image=image)
    view = perspective_view(PINHOLE, whole[0].pose, LEVEL)
    # The cells that the gaps have a share in, by a frame that is not finite there alone.
    alone, seen = integrate([gappy], view, exact=False)
    assert 0.7 < (seen == 1).mean() < 0.8
    others, count = integrate([whole[0], whole[2]], view, exact=False)
    running = ViewIntegral(view, ("grey",), exact=False)
    running.add(whole[0])
    running.add_all([gappy, whole[2]])
    np.testing.assert_array_equal(running.coverage, count + seen)
    total = np.nan_to_num(others) * count[:, :, None] + np.nan_to_num(alone)
    covered = running.coverage > 0
    np.testing.assert_allclose(running.mean()[covered], (total[covered].T / running.coverage[covered]).T, rtol=1e-5)
    running.remove(gappy)
    np.testing.assert_array_equal(running.coverage, count)
    np.testing.assert_allclose(running.mean(), others, rtol=1e-5)


@SURFACES
@CAMERAS
@pytest.mark.parametrize("dtype", [np.uint8, np.float64])
def test_other_types_give_what_their_values_give_as_floats(
    camera: CameraModel, surface: FocalSurface, dtype: type[np.generic]
) -> None:
    frames = flight(camera, surface, seed=4, count=3)
    typed = [dataclasses.replace(frame, image=frame.image.astype(dtype)) for frame in frames]
    floats = [dataclasses.replace(frame, image=frame.image.astype(np.float32)) for frame in typed]
    # The second raster sees a small part of the frames, whose borders lie outside of it.
    for view in (perspective_view(PINHOLE, frames[0].pose, surface), ortho_view(CLOSE_UP, surface)):
        expected, count = integrate(floats, view, exact=False)
        integral, own_count = integrate(typed, view, exact=False)
        assert count.max() == 3
        np.testing.assert_array_equal(own_count, count)
        # OpenCV before 5 rounds coordinates to 1/32 pixel.
        np.testing.assert_allclose(integral, expected, atol=0.02)


def test_bytes_are_sampled_up_to_the_horizon() -> None:
    level = Pose(np.array([0.0, 0.0, 30.0]), np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]))
    frame = flight(PINHOLE, LEVEL, count=1)[0]
    frame = dataclasses.replace(frame, image=frame.image.astype(np.uint8), pose=level)
    floats = dataclasses.replace(frame, image=frame.image.astype(np.float32))
    raster = MapRaster(-40.0, 100.0, 0.5, 260, 160, rows_along_y=False)
    integral, count = integrate([frame], ortho_view(raster, Plane(0.0)), exact=False)
    assert count.any()
    np.testing.assert_allclose(integral, integrate([floats], ortho_view(raster, Plane(0.0)), exact=False)[0], atol=0.02)


@CAMERAS
def test_undistorted_frames_are_those_of_an_ideal_camera(camera: CameraModel) -> None:
    frame = flight(camera, LEVEL, count=1)[0]
    ideal = undistorted(frame)
    assert ideal.camera.distortion is None
    if camera is PINHOLE:
        assert ideal is frame
        return
    expected = render(ideal.camera, frame.pose, LEVEL)
    assert np.isfinite(ideal.image).mean() > 0.85
    error = np.abs(ideal.image - expected)
    assert np.nanmean(error) < 0.1
    # Clamped on the outer half of the outermost pixels.
    assert np.nanmax(error) < 4.0
    assert undistorted(frame).camera is ideal.camera


@pytest.mark.parametrize("camera", [BARREL, FISHEYE], ids=["barrel", "fisheye"])
def test_steps_and_grids_work_with_distorted_frames(camera: CameraModel) -> None:
    rng = np.random.default_rng(5)
    frames = flight(camera, LEVEL, seed=1)
    # A warm spot of 0.8 m at (2, -1), and noise, without which every edge would be an anomaly.
    warm = []
    for frame in frames:
        u, v = np.meshgrid(np.arange(96), np.arange(80))
        points = intersect_plane(np.stack((u.ravel(), v.ravel()), axis=1), camera, frame.pose, LEVEL)
        spot = np.hypot(points[:, 0] - 2.0, points[:, 1] + 1.0).reshape(80, 96, 1) < 0.8
        image = rng.normal(size=frame.image.shape) + np.where(spot, 60.0, 0.0)
        warm.append(dataclasses.replace(frame, image=image.astype(np.float32)))
    analysis = analyse_step(warm, ImagingSettings(plane_height_m=1.0, rx_quantile=0.99))
    assert analysis.blob is not None
    np.testing.assert_allclose(analysis.blob.centroid_enu_m, [2.0, -1.0, 1.0], atol=0.15)
    assert [view.vehicle_id for view in analysis.sightings[0].views] == [0, 1, 2, 3, 4]
    grid = FocalGrid(-6.0, 6.0, 0.25, 48, 48, 1.0)
    mean, coverage = integrate(frames, grid_view(grid), exact=False)
    cells = -6.0 + 0.125 + 0.25 * np.arange(48)
    assert (coverage == 5).mean() > 0.7
    assert np.nanmax(np.abs(mean[:, :, 0] - texture(*np.meshgrid(cells, -cells)))) < 2.0


def test_virtual_cameras_that_see_nothing_are_refused() -> None:
    with pytest.raises(ImagingError, match="sees nothing of the terrain"):
        perspective_view(PINHOLE, nadir_pose([500, 0, 30]), HILLS)
    with pytest.raises(ImagingError, match="sees nothing of the terrain"):
        perspective_view(PINHOLE, nadir_pose([0, 0, -30]), HILLS)
    with pytest.raises(ImagingError, match="lies behind the virtual camera"):
        perspective_view(PINHOLE, nadir_pose([0, 0, -30]), TILTED)
    with pytest.raises(ImagingError, match="has no distortion"):
        perspective_view(BARREL, nadir_pose([0, 0, 30]), LEVEL)


@SURFACES
def test_bands_of_rows_make_up_the_whole(surface: FocalSurface, monkeypatch: pytest.MonkeyPatch) -> None:
    frames = flight(PINHOLE, surface)
    view = perspective_view(PINHOLE, frames[0].pose, surface)
    whole, count = integrate(frames, view)
    integral = ViewIntegral(view, frames[0].bands)
    monkeypatch.setattr("aos_gcs.imaging.integral.BAND_ROWS", 33)
    assert all(integral.add_all(frames))
    np.testing.assert_array_equal(integral.coverage, count)
    np.testing.assert_allclose(integral.mean(), whole, atol=1e-4)
