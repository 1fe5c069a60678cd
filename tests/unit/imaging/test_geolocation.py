"""Positions of targets and their covariances, against finite differences and Monte Carlo."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from scipy.special import chdtri

from aos_gcs.errors import ConfigurationError, ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import intersect_plane, project_points
from aos_gcs.imaging.geolocation import Uncertainty, geolocate, locate_together, pixel_jacobian, pose_jacobian
from aos_gcs.imaging.model import BlobView
from aos_gcs.imaging.surfaces.terrain import Terrain

CAMERA = CameraModel.from_fov(512, 512, math.radians(50.0))
PERFECT = Uncertainty(0.0, 0.0, 0.0, 0.0, 0.0, pixel_px=0.0, focal_height_m=0.0, target_height_sigma_m=0.0)


def tilted(pose: Pose, rotation_rad: tuple[float, float, float]) -> Pose:
    return Pose(pose.position_enu_m, Rotation.from_rotvec(rotation_rad).as_matrix() @ pose.R_cam2enu)


def view(vehicle_id: int, reported: Pose, pixel: np.ndarray, plane_height_m: float = 0.0) -> BlobView:
    point = intersect_plane(pixel, CAMERA, reported, plane_height_m)[0]
    return BlobView(vehicle_id, point[:2], CAMERA, reported)


def exact_view(vehicle_id: int, pose: Pose, seen_enu_m: tuple[float, float, float]) -> BlobView:
    return view(vehicle_id, pose, project_points([seen_enu_m], CAMERA, pose))


@given(
    offset_m=st.tuples(st.floats(-12, 12), st.floats(-12, 12)),
    tilt_rad=st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(-3, 3)),
    pixel=st.tuples(st.floats(0, 511), st.floats(0, 511)),
)
def test_jacobians_agree_with_finite_differences(
    offset_m: tuple[float, float], tilt_rad: tuple[float, float, float], pixel: tuple[float, float]
) -> None:
    pose = tilted(nadir_pose([*offset_m, 35.0]), tilt_rad)

    def meets(errors: np.ndarray) -> np.ndarray:
        moved = tilted(Pose(pose.position_enu_m + errors[:3], pose.R_cam2enu), tuple(errors[3:6]))
        return intersect_plane([np.add(pixel, errors[6:])], CAMERA, moved, 1.5)[0]

    steps = 1e-5 * np.eye(8)
    numeric = np.column_stack([(meets(step) - meets(-step))[:2] / 2e-5 for step in steps])
    ray_m = meets(np.zeros(8)) - pose.position_enu_m
    analytic = np.hstack((pose_jacobian(ray_m), pixel_jacobian(ray_m, CAMERA, pose)))
    np.testing.assert_allclose(analytic, numeric, rtol=1e-5, atol=1e-6)


@given(st.integers(2, 8), st.floats(0.0, 1.8), st.integers(0, 1000))
def test_exact_views_meet_at_the_ground_below_what_is_seen(n: int, seen_at_m: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    poses = [nadir_pose([*rng.uniform(-10, 10, 2), rng.uniform(30, 40)]) for _ in range(n)]
    settings = dataclasses.replace(PERFECT, target_height_m=seen_at_m, target_extent_m=0.01)
    located = geolocate([exact_view(i, pose, (1.0, 2.0, seen_at_m)) for i, pose in enumerate(poses)], 0.0, settings)
    np.testing.assert_allclose(located.position_enu_m, [1.0, 2.0, 0.0], atol=1e-9)


def test_lines_of_sight_tell_the_height_of_what_is_seen() -> None:
    poses = [nadir_pose([east, -10.0, 35.0]) for east in (-10.0, -5.0, 0.0, 5.0, 10.0)]
    views = [exact_view(i, pose, (0.0, 0.0, 1.6)) for i, pose in enumerate(poses)]
    settings = dataclasses.replace(PERFECT, target_height_sigma_m=0.8, target_height_m=0.8, target_extent_m=0.02)
    centroid_m = np.mean([view.point_enu_m for view in views], axis=0)
    assert np.linalg.norm(centroid_m) > 0.4
    assert np.linalg.norm(geolocate(views, 0.0, settings).position_enu_m[:2]) < 0.02


def test_opposite_headings_tell_the_tilt_of_a_camera() -> None:
    def located(headings_rad: tuple[float, ...]) -> tuple[float, float]:
        views = []
        for index, heading_rad in enumerate(headings_rad):
            reported = nadir_pose([4.0 + index, -2.0, 35.0], heading_rad)
            askew = Rotation.from_rotvec([math.radians(1.2), 0.0, 0.0]).as_matrix()
            true = Pose(reported.position_enu_m, reported.R_cam2enu @ askew)
            views.append(view(1, reported, project_points([(0.0, 0.0, 0.0)], CAMERA, true)))
        settings = dataclasses.replace(
            PERFECT, attitude_rad=math.radians(1.0), persistent_share=0.95, target_height_m=0.0, target_extent_m=0.05
        )
        place = geolocate(views, 0.0, settings)
        return float(np.linalg.norm(place.position_enu_m[:2])), math.sqrt(float(place.covariance_m2[0, 0]))

    one_way_m, one_way_sigma_m = located((0.0, 0.0, 0.0, 0.0))
    both_ways_m, both_ways_sigma_m = located((0.0, math.pi, 0.0, 0.0))
    assert one_way_m > 0.7
    assert both_ways_m < 0.1, "even where most views are of one heading"
    assert both_ways_sigma_m < 0.5 * one_way_sigma_m


def test_independent_vehicles_average_out_and_the_height_of_the_plane_does_not() -> None:
    def located(n: int, settings: Uncertainty) -> np.ndarray:
        pose = nadir_pose([-8.0, 0.0, 35.0])
        return geolocate([exact_view(i, pose, (0.0, 0.0, 0.0)) for i in range(n)], 0.0, settings).covariance_m2

    positions = dataclasses.replace(PERFECT, position_horizontal_m=0.5, target_extent_m=1e-4)
    np.testing.assert_allclose(located(9, positions)[:2, :2], located(1, positions)[:2, :2] / 9, atol=1e-7)
    heights = dataclasses.replace(PERFECT, focal_height_m=1.0, target_extent_m=1e-4)
    np.testing.assert_allclose(located(9, heights), located(1, heights), atol=1e-7)
    assert located(9, heights)[0, 0] == pytest.approx((8 / 35) ** 2, rel=1e-3)
    assert located(9, heights)[2, 2] == pytest.approx(1.0)


def test_frames_of_one_vehicle_share_its_biases() -> None:
    pose = nadir_pose([3.0, 0.0, 35.0])
    settings = dataclasses.replace(PERFECT, position_horizontal_m=0.5, target_extent_m=1e-3)
    same = geolocate([exact_view(7, pose, (0.0, 0.0, 0.0)) for _ in range(4)], 0.0, settings)
    others = geolocate([exact_view(i, pose, (0.0, 0.0, 0.0)) for i in range(4)], 0.0, settings)
    assert same.systematic_m2[0, 0] == pytest.approx(0.8 * 0.25, rel=1e-3)
    assert others.systematic_m2[0, 0] == pytest.approx(0.8 * 0.25 / 4, rel=1e-3)
    np.testing.assert_allclose(same.random_m2, others.random_m2, rtol=1e-3)


def test_a_moving_camera_adds_its_clock() -> None:
    views = [exact_view(1, nadir_pose([0.0, 0.0, 35.0]), (0.0, 0.0, 0.0))]
    settings = dataclasses.replace(PERFECT, clock_s=0.03, target_extent_m=1e-4)
    assert locate_together([views], 0.0, settings, 5.0)[0].random_m2[1, 1] == pytest.approx(0.15**2, rel=1e-3)


def test_a_frame_that_tells_how_well_it_knows_its_time_weighs_by_that() -> None:
    pose = nadir_pose([0.0, 0.0, 35.0])
    views = [exact_view(number, pose, (1.0, 2.0, 0.6)) for number in (1, 2)]
    told = [dataclasses.replace(view, time_sigma_s=sigma_s) for view, sigma_s in zip(views, (0.3, 0.02), strict=True)]
    (one, other) = (locate_together([[view]], 0.0, Uncertainty(), 5.0)[0].random_m2[0, 0] for view in told)
    assert one - other == pytest.approx(5.0**2 * (0.3**2 - 0.02**2))


def test_the_covariance_is_that_of_the_errors() -> None:
    """Errors of simulated swarms, normalised by the covariance, follow chi-square with three degrees of freedom."""
    rng = np.random.default_rng(1)
    settings = Uncertainty(focal_height_m=0.8)
    pose_sigmas = [settings.position_horizontal_m] * 2 + [settings.position_vertical_m]
    turn_sigmas = [settings.attitude_rad] * 2 + [settings.yaw_rad]
    runs, normalised = 250, []
    for _ in range(runs):
        ground_m = rng.normal(0.0, settings.focal_height_m)
        target = np.array([*rng.uniform(-2, 2, 2), ground_m])
        middle = np.add(target, [*rng.normal(0.0, settings.target_extent_m, 2), settings.target_height_m])
        middle[2] += rng.normal(0.0, settings.target_height_sigma_m)
        views = []
        for vehicle_id in range(6):
            true = nadir_pose([*rng.uniform(-10, 10, 2), 35.0], heading_rad=rng.uniform(0, 6))
            seen = np.add(middle, [*rng.normal(0.0, settings.target_extent_m, 2), 0.0])
            pixel = project_points([seen], CAMERA, true) + rng.normal(0.0, settings.pixel_px, 2)
            moved = Pose(true.position_enu_m + rng.normal(0.0, pose_sigmas), true.R_cam2enu)
            views.append(view(vehicle_id, tilted(moved, tuple(rng.normal(0.0, turn_sigmas))), pixel))
        located = geolocate(views, 0.0, settings)
        error_m = located.position_enu_m - target
        normalised.append(error_m @ np.linalg.solve(located.covariance_m2, error_m))
    low, high = chdtri(3 * runs, [0.999, 0.001]) / runs
    assert low < np.mean(normalised) < high


def swarm_views(rng: np.random.Generator, seen_enu_m: list[np.ndarray], settings: Uncertainty) -> list[list[BlobView]]:
    """One frame of each of six vehicles with poses that err; only three of them see the first target."""
    targets: list[list[BlobView]] = [[] for _ in seen_enu_m]
    for vehicle_id in range(6):
        true = nadir_pose([*rng.uniform(-10, 10, 2), 35.0])
        moved = Pose(true.position_enu_m + rng.normal(0.0, settings.position_horizontal_m, 3), true.R_cam2enu)
        sigmas = [settings.attitude_rad, settings.attitude_rad, settings.yaw_rad]
        reported = tilted(moved, tuple(rng.normal(0.0, sigmas)))
        for index, seen in enumerate(seen_enu_m):
            if index > 0 or vehicle_id < 3:
                targets[index].append(view(vehicle_id, reported, project_points([seen], CAMERA, true)))
    return targets


def test_other_targets_sharpen_a_place_and_the_covariance_knows_it() -> None:
    rng = np.random.default_rng(3)
    settings = Uncertainty(
        position_vertical_m=0.5, pixel_px=0.0, focal_height_m=0.0, target_height_sigma_m=0.0, target_extent_m=0.05
    )
    seen = [np.array([east, north, settings.target_height_m]) for east, north in ((0, 0), (8, 3), (-6, 5), (2, -9))]
    alone, together, normalised = [], [], []
    for _ in range(120):
        targets = swarm_views(rng, seen, settings)
        alone.append(geolocate(targets[0], 0.0, settings).position_enu_m)
        located = locate_together(targets, 0.0, settings)[0]
        together.append(located.position_enu_m)
        covariance_m2 = located.covariance_m2[:2, :2] - settings.target_extent_m**2 * np.eye(2)
        normalised.append(together[-1][:2] @ np.linalg.solve(covariance_m2, together[-1][:2]))
    assert np.linalg.norm(together, axis=1).mean() < 0.85 * np.linalg.norm(alone, axis=1).mean()
    low, high = chdtri(2 * len(normalised), [0.999, 0.001]) / len(normalised)
    assert low < np.mean(normalised) < high


def test_targets_that_share_no_vehicle_are_located_as_if_alone() -> None:
    settings = Uncertainty()
    targets = swarm_views(np.random.default_rng(4), [np.array([0.0, 0.0, 0.9]), np.array([5.0, 5.0, 0.9])], settings)
    others = [dataclasses.replace(view, vehicle_id=view.vehicle_id + 100) for view in targets[1]]
    for target, located in zip((targets[0], others), locate_together([targets[0], others], 0.0, settings), strict=True):
        alone = geolocate(target, 0.0, settings)
        np.testing.assert_allclose(located.position_enu_m, alone.position_enu_m, atol=1e-9)
        np.testing.assert_allclose(located.random_m2, alone.random_m2, atol=1e-9)
        np.testing.assert_allclose(located.systematic_m2, alone.systematic_m2, atol=1e-9)


def test_vehicles_that_hover_in_one_place_keep_the_covariance_positive() -> None:
    rng = np.random.default_rng(0)
    poses = [nadir_pose([4.0 * number, 0.0, 35.0]) for number in range(5)]
    settings = Uncertainty(persistent_share=0.0, pixel_px=0.1, target_extent_m=0.01)
    for _ in range(30):
        places_enu_m = rng.uniform([-12.0, -12.0, 0.5], [12.0, 12.0, 0.5], (4, 3))
        targets = [
            [
                exact_view(number, pose, tuple(place_enu_m))
                for _step in range(3)
                for number, pose in enumerate(poses)
                if number == 0 or rng.random() < 0.6
            ]
            for place_enu_m in places_enu_m
        ]
        for place in locate_together(targets, 0.0, settings):
            assert np.linalg.eigvalsh(place.covariance_m2).min() > 0.0


def test_no_targets_are_nowhere() -> None:
    assert locate_together([], 0.0, Uncertainty()) == ()


def test_a_target_without_views_is_refused() -> None:
    with pytest.raises(ImagingError, match="no view"):
        locate_together(
            [swarm_views(np.random.default_rng(0), [np.zeros(3)], Uncertainty())[0], []], 0.0, Uncertainty()
        )
    with pytest.raises(ImagingError, match="no view"):
        geolocate([], 0.0, Uncertainty())


@pytest.mark.parametrize(
    "wrong", [{"yaw_rad": -0.1}, {"clock_s": math.inf}, {"persistent_share": 1.1}, {"target_extent_m": 0.0}]
)
def test_values_out_of_range_are_refused_by_name(wrong: dict[str, float]) -> None:
    with pytest.raises(ConfigurationError, match=next(iter(wrong))):
        Uncertainty(**wrong)


SLOPE = 0.2


def slope(up_m: float = 0.0) -> Terrain:
    """Return ground that rises by 20 % to the north, 40 m to each side of the origin."""
    north_m = np.arange(-40.0, 41.0, 2.0)
    return Terrain(-40.0, -40.0, 2.0, np.repeat(up_m + SLOPE * north_m[:, np.newaxis], len(north_m), axis=1))


def views_of(seen_enu_m: tuple[float, float, float], plane_height_m: float) -> list[BlobView]:
    """Return views from south and east, on a plane that may lie far above or below what they see."""
    poses = [nadir_pose([east_m, -12.0, 35.0]) for east_m in (-4.0, 2.0, 8.0)]
    return [
        view(number, pose, project_points([seen_enu_m], CAMERA, pose), plane_height_m)
        for number, pose in enumerate(poses)
    ]


@pytest.mark.parametrize("plane_height_m", [-3.0, 0.0, 4.0])
def test_targets_stand_on_the_ground_in_view_whatever_the_plane(plane_height_m: float) -> None:
    settings = dataclasses.replace(PERFECT, target_height_m=0.6, target_height_sigma_m=0.4, focal_height_m=1.0)
    places_m = [(-2.0, -15.0), (1.0, 2.0)]
    targets = [views_of((*place_m, SLOPE * place_m[1] + 0.6), plane_height_m) for place_m in places_m]
    located = locate_together(targets, plane_height_m, settings, ground=slope())
    for found, place_m in zip(located, places_m, strict=True):
        np.testing.assert_allclose(found.position_enu_m, (*place_m, SLOPE * place_m[1]), atol=0.05)


def test_where_the_ground_is_not_known_or_above_the_cameras_targets_stand_on_the_plane() -> None:
    views = views_of((1.0, 2.0, 0.6), 0.0)
    on_plane = geolocate(views, 0.0, Uncertainty()).position_enu_m
    holed = dataclasses.replace(slope(), heights_m=np.where(np.eye(41) > 0, 0.0, np.nan))
    for ground in (holed, slope(up_m=60.0)):
        np.testing.assert_array_equal(geolocate(views, 0.0, Uncertainty(), ground=ground).position_enu_m, on_plane)
