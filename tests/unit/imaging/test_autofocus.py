"""Known textures on planes at known heights, under occluders that are at other places in every frame."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import Plane, intersect_plane
from aos_gcs.imaging.focus import region as focus_region
from aos_gcs.imaging.focus.autofocus import find_focus, focus_curve
from aos_gcs.imaging.focus.measure import FocusSignal
from aos_gcs.imaging.focus.region import GroundRegion, ViewRegion
from aos_gcs.imaging.model import Frame

CAMERA = CameraModel.from_fov(320, 240, np.radians(55.0))
ALTITUDE_M = 30.0
REGION = GroundRegion(-6.0, -5.0, 6.0, 5.0)
POSES = [
    nadir_pose([5.0 * (i % 3 - 1), 4.0 * (i // 3 - 1), ALTITUDE_M + 0.5 * i], heading_rad=0.7 * i) for i in range(9)
]


@pytest.fixture(autouse=True)
def _few_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """Regions of a few metres need fewer points than whole views."""
    monkeypatch.setattr(focus_region, "MAX_POINTS", 2_500)


def texture(x_m: NDArray[np.float64], y_m: NDArray[np.float64], seed: int) -> NDArray[np.float64]:
    """Waves of all directions, 1.5 to 6 m long: nothing repeats within the region."""
    rng = np.random.default_rng(seed)
    lengths_m, turns, phases = rng.uniform(1.5, 6.0, 24), rng.uniform(0, 2 * np.pi, 24), rng.uniform(0, 2 * np.pi, 24)
    waves = 2 * np.pi / lengths_m * np.array([np.cos(turns), np.sin(turns)])
    # Single precision is ten times as fast, and far finer than leaves.
    angles = (np.stack((x_m, y_m), axis=1) @ waves + phases).astype(np.float32)
    return np.asarray(100.0 + 8.0 * np.sin(angles).sum(axis=1), dtype=np.float64)


@cache
def render(pose: Pose, plane: Plane, seed: int = 0, camera: CameraModel = CAMERA) -> NDArray[np.float32]:
    u, v = np.meshgrid(np.arange(camera.width_px), np.arange(camera.height_px))
    points = intersect_plane(np.stack((u.ravel(), v.ravel()), axis=1), camera, pose, plane)
    return texture(points[:, 0], points[:, 1], seed).reshape(u.shape).astype(np.float32)


def occluded(image: NDArray[np.float32], rng: np.random.Generator, share: float, cell_px: int = 10) -> None:
    """Cover a share of the image with bright and dark leaves."""
    cells = (image.shape[0] // cell_px + 1, image.shape[1] // cell_px + 1)
    leaves = np.kron(rng.random(cells) < share, np.ones((cell_px, cell_px)))[: image.shape[0], : image.shape[1]] > 0
    shades = np.kron(rng.uniform(40, 200, cells), np.ones((cell_px, cell_px)))[: image.shape[0], : image.shape[1]]
    image[leaves] = shades[leaves]


def flight(plane: Plane, share: float = 0.5, seed: int = 1, poses: list[Pose] = POSES) -> list[Frame]:
    rng = np.random.default_rng(seed)
    frames = []
    for index, pose in enumerate(poses):
        image = render(pose, plane).copy()
        occluded(image, rng, share)
        frames.append(Frame(index, image[:, :, np.newaxis], ("grey",), pose, CAMERA))
    return frames


@pytest.mark.parametrize("height_m", [-4.0, 3.3])
def test_the_height_of_an_occluded_plane_is_found(height_m: float) -> None:
    result = find_focus(flight(Plane(height_m)), REGION, -10.0, 12.0)
    assert result.found
    assert result.height_m == pytest.approx(height_m, abs=0.4)
    assert abs(result.height_m - height_m) < 2.0 * result.sigma_m
    assert result.confidence > 0.8
    assert result.plane == Plane(result.height_m)


def test_the_sharpest_peak_is_no_surer_than_poses_are() -> None:
    result = find_focus(flight(Plane(2.0), share=0.0), REGION, -10.0, 12.0)
    assert result.confidence > 0.9
    assert result.sigma_m > 0.4


def test_it_is_found_in_a_tilted_view_too() -> None:
    frames = flight(Plane(2.0))
    turn = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(0.3), -np.sin(0.3)], [0.0, np.sin(0.3), np.cos(0.3)]])
    centre = nadir_pose([0.0, 0.0, ALTITUDE_M])
    view = ViewRegion(CAMERA, Pose(centre.position_enu_m, centre.R_cam2enu @ turn), (100.0, 40.0, 220.0, 140.0))
    assert find_focus(frames, view, -10.0, 12.0).height_m == pytest.approx(2.0, abs=0.4)


def test_a_world_with_z_down_is_no_different() -> None:
    flip = np.diag([1.0, -1.0, -1.0])
    frames = [
        Frame(f.vehicle_id, f.image, f.bands, Pose(flip @ f.pose.position_enu_m, flip @ f.pose.R_cam2enu), f.camera)
        for f in flight(Plane(3.3))
    ]
    assert find_focus(frames, REGION, -12.0, 10.0).height_m == pytest.approx(-3.3, abs=0.3)


def test_lenses_may_distort() -> None:
    lens = replace(CAMERA, distortion=LensDistortion(LensModel.BROWN_CONRADY, (-0.25, 0.05, 0.0, 0.0, 0.0)))
    frames = [
        Frame(i, render(pose, Plane(2.0), camera=lens)[:, :, np.newaxis], ("grey",), pose, lens)
        for i, pose in enumerate(POSES[::2])
    ]
    result = find_focus(frames, REGION, -10.0, 12.0)
    assert result.height_m == pytest.approx(2.0, abs=0.1)
    assert result.agreement > 0.98
    taken_as_ideal = [replace(frame, camera=CAMERA) for frame in frames]
    assert abs(find_focus(taken_as_ideal, REGION, -10.0, 12.0).height_m - 2.0) > 0.4


def test_the_tilt_of_a_plane_is_found() -> None:
    plane = Plane.through([0.0, 0.0, 1.0], 0.25, -0.15)
    result = find_focus(flight(plane, share=0.3), REGION, -8.0, 8.0, tilt=True)
    assert result.found
    assert result.height_m == pytest.approx(1.0, abs=0.4)
    assert (result.plane.slope_x, result.plane.slope_y) == pytest.approx((0.25, -0.15), abs=0.05)
    level = find_focus(flight(plane, share=0.3), REGION, -8.0, 8.0)
    assert result.agreement > level.agreement
    assert level.plane.slope_x == 0.0


def test_a_level_plane_stays_level() -> None:
    result = find_focus(flight(Plane(2.0), share=0.3), REGION, -6.0, 10.0, tilt=True)
    assert abs(result.plane.slope_x) < 0.04
    assert abs(result.plane.slope_y) < 0.04
    assert result.height_m == pytest.approx(2.0, abs=0.3)


@pytest.mark.parametrize("seed", range(3))
def test_frames_that_share_nothing_are_not_in_focus_anywhere(seed: int) -> None:
    result = find_focus(flight(Plane(0.0), share=1.0, seed=seed), REGION, -10.0, 10.0)
    assert not result.found
    assert result.confidence < 0.2
    assert result.reason


def test_a_plane_out_of_the_range_is_not_found() -> None:
    result = find_focus(flight(Plane(0.0), share=0.2), REGION, 2.0, 12.0)
    assert not result.found
    assert result.reason


def test_cameras_in_one_place_cannot_tell_heights() -> None:
    poses = [nadir_pose([0.0, 0.0, ALTITUDE_M], heading_rad=0.5 * i) for i in range(4)]
    assert not find_focus(flight(Plane(0.0), share=0.3, poses=poses), REGION, -10.0, 10.0).found


def test_a_rival_lowers_confidence_and_a_range_without_it_helps() -> None:
    rng = np.random.default_rng(5)
    frames = []
    for index, pose in enumerate(POSES):
        image = render(pose, Plane(0.0)).copy()
        canopy = rng.random(image.shape) < 0.5
        image[canopy] = render(pose, Plane(10.0), seed=7)[canopy]
        frames.append(Frame(index, image[:, :, np.newaxis], ("grey",), pose, CAMERA))
    both = find_focus(frames, REGION, -8.0, 16.0)
    ground = find_focus(frames, REGION, -8.0, 6.0)
    assert both.confidence < 0.6 < ground.confidence
    assert ground.height_m == pytest.approx(0.0, abs=0.4)


def test_anomalies_come_into_focus_where_texture_misleads() -> None:
    rng = np.random.default_rng(6)
    frames = []
    for index, pose in enumerate(POSES):
        u, v = np.meshgrid(np.arange(CAMERA.width_px), np.arange(CAMERA.height_px))
        x, y, _ = intersect_plane(np.stack((u.ravel(), v.ravel()), axis=1), CAMERA, pose, 1.0).T
        warm = (np.hypot(x - 1.0, y + 0.5) < 0.5).reshape(u.shape)
        canopy = render(pose, Plane(10.0), seed=7)
        # Leaves at one height in full focus; the target shows through half of them.
        image = np.where(warm & (rng.random(u.shape) < 0.5), np.float32(900.0), canopy)
        frames.append(Frame(index, image[:, :, np.newaxis], ("thermal",), pose, CAMERA))
    assert find_focus(frames, REGION, -8.0, 16.0).height_m == pytest.approx(10.0, abs=0.5)
    result = find_focus(frames, REGION, -8.0, 16.0, signal=FocusSignal.ANOMALY)
    assert result.found
    assert result.height_m == pytest.approx(1.0, abs=0.6)


def test_the_curve_peaks_at_the_plane() -> None:
    heights_m = np.arange(-6.0, 7.0, 2.0)
    curve = focus_curve(flight(Plane(0.0)), REGION, [Plane(float(height_m)) for height_m in heights_m])
    assert heights_m[curve.values.argmax()] == 0.0
    assert curve.values.max() > 10.0 * curve.scatter


def test_regions_lay_the_same_points_on_every_plane() -> None:
    view = ViewRegion.whole(CAMERA, nadir_pose([3.0, 4.0, 30.0]))
    for region in (REGION, view):
        points = [region.points_m(plane) for plane in (Plane(0.0), Plane(2.0, 0.1, 0.2))]
        assert points[0].shape == points[1].shape
        assert 0.9 * focus_region.MAX_POINTS < len(points[0]) <= focus_region.MAX_POINTS
        np.testing.assert_allclose(points[1][:, 2], 2.0 + 0.1 * points[1][:, 0] + 0.2 * points[1][:, 1])
    np.testing.assert_allclose(view.centre_m(1.0), [3.0, 4.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(REGION.centre_m(1.0), [0.0, 0.0, 1.0])


def test_what_cannot_be_searched_is_refused() -> None:
    frames = flight(Plane(0.0))[:2]
    with pytest.raises(ImagingError, match="finite and ascending"):
        find_focus(frames, REGION, 5.0, 5.0)
    with pytest.raises(ImagingError, match="Fewer than two cameras"):
        find_focus(frames[:1], REGION, -5.0, 5.0)
    with pytest.raises(ImagingError, match="Fewer than two cameras"):
        find_focus(frames, REGION, 40.0, 50.0)
    with pytest.raises(ImagingError, match="at least two frames"):
        focus_curve([], REGION, [Plane(0.0)])
    with pytest.raises(ImagingError, match="must span an area"):
        GroundRegion(1.0, 0.0, 1.0, 5.0)
    with pytest.raises(ImagingError, match="must span an area"):
        ViewRegion(CAMERA, POSES[0], (0.0, 5.0, 10.0, 4.0))
