"""Warm pixels of frames, and the bodies that they belong to."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.persons.evidence import gather_evidence
from aos_gcs.imaging.persons.warm_bodies import LINK_M, MAX_PIXELS, MIN_CONTRAST_K, WarmView, warm_bodies, warm_view

CAMERA = CameraModel.from_fov(128, 128, math.radians(50.0))
HEIGHT_M = 40.0
GSD_M = HEIGHT_M / CAMERA.fx_px
BANDS = ("red", "green", "blue", "thermal")


def frame_with_spot(
    spot_enu_m: tuple[float, float] | None = (2.0, -1.0),
    *,
    kelvin: float = 15.0,
    edge_px: int = 3,
    offset_k: float = 0.0,
    east_m: float = 0.0,
    vehicle_id: int = 1,
) -> Frame:
    """Forest of 11 °C and grey with a warm, red square."""
    rng = np.random.default_rng(vehicle_id)
    image = np.dstack([rng.normal(100.0, 5.0, (128, 128, 3)), rng.normal(11.0 + offset_k, 0.1, (128, 128))])
    pose = nadir_pose([east_m, 0.0, HEIGHT_M])
    if spot_enu_m is not None:
        column = round((spot_enu_m[0] - east_m) / GSD_M + CAMERA.cx_px)
        row = round(-spot_enu_m[1] / GSD_M + CAMERA.cy_px)
        half = edge_px // 2
        square = image[row - half : row + half + 1, column - half : column + half + 1]
        square[..., :3] = [200.0, 20.0, 20.0]
        square[..., 3] = 11.0 + offset_k + kelvin
    return Frame(vehicle_id, image.astype(np.float32), BANDS, pose, CAMERA)


def test_warm_pixels_lie_where_the_body_is() -> None:
    view = warm_view(frame_with_spot())
    assert view.points_enu_m.shape == (9, 2)
    np.testing.assert_allclose(view.points_enu_m.mean(axis=0), [2.0, -1.0], atol=GSD_M)
    assert view.area_m2 == pytest.approx(9 * GSD_M**2)


@pytest.mark.parametrize("offset_k", [-3.0, 0.0, 5.0])
def test_contrast_does_not_depend_on_the_cameras_offset(offset_k: float) -> None:
    np.testing.assert_allclose(warm_view(frame_with_spot(offset_k=offset_k)).contrast_k, 15.0, atol=0.1)


@pytest.mark.parametrize(("offset_k", "background_c"), [(5.0, 16.0), (273.15, None), (-273.15, None)])
def test_the_forests_temperature_is_known_unless_the_scale_is_wrong(
    offset_k: float, background_c: float | None
) -> None:
    view = warm_view(frame_with_spot(offset_k=offset_k))
    assert view.background_c == (None if background_c is None else pytest.approx(background_c, abs=0.1))
    np.testing.assert_allclose(view.contrast_k, 15.0, atol=0.1)


def test_lukewarm_and_empty_frames_show_nothing() -> None:
    assert len(warm_view(frame_with_spot(kelvin=MIN_CONTRAST_K / 3.0)).points_enu_m) == 0
    assert len(warm_view(frame_with_spot(None)).points_enu_m) == 0


def test_frames_without_thermal_are_refused() -> None:
    frame = frame_with_spot()
    with pytest.raises(ImagingError, match="red, green, blue"):
        warm_view(Frame(1, frame.image[..., :3], BANDS[:3], frame.pose, CAMERA))


def test_pixels_that_look_past_the_ground_are_left_out() -> None:
    frame = frame_with_spot()
    upwards = Pose(frame.pose.position_enu_m, np.eye(3))
    assert len(warm_view(Frame(1, frame.image, BANDS, upwards, CAMERA)).points_enu_m) == 0


def test_views_of_one_body_meet_whatever_the_frame() -> None:
    views = [warm_view(frame_with_spot(east_m=east_m, vehicle_id=i)) for i, east_m in enumerate([-5.0, 0.0, 5.0], 1)]
    (body,) = warm_bodies(views)
    assert [view.vehicle_id for view in body] == [1, 2, 3]


def test_bodies_apart_are_told_apart_and_the_largest_comes_first() -> None:
    small, large = frame_with_spot((-4.0, 0.0), edge_px=3), frame_with_spot((4.0, 0.0), edge_px=7, vehicle_id=2)
    bodies = warm_bodies([warm_view(small), warm_view(large)])
    assert [[view.vehicle_id for view in body] for body in bodies] == [[2], [1]]
    assert sum(len(view.points_enu_m) for body in bodies for view in body) == 9 + 49


def test_nothing_warm_is_no_body() -> None:
    assert warm_bodies([]) == ()
    assert warm_bodies([warm_view(frame_with_spot(None))]) == ()


def sunlit_frame(share: float, edge_px: int = 512) -> Frame:
    """Forest of 11 °C, of which a share is 7 K warmer."""
    rng = np.random.default_rng(3)
    camera = CameraModel.from_fov(edge_px, edge_px, math.radians(50.0))
    thermal = rng.normal(11.0, 0.1, (edge_px, edge_px, 1)) + 7.0 * (rng.random((edge_px, edge_px, 1)) < share)
    return Frame(1, thermal.astype(np.float32), ("thermal",), nadir_pose([0.0, 0.0, HEIGHT_M]), camera)


@pytest.mark.parametrize("share", [0.1, 0.4])
def test_a_sunlit_clearing_is_thinned_out(share: float) -> None:
    frame = sunlit_frame(share)
    view = warm_view(frame)
    assert MAX_PIXELS / 4 < len(view.points_enu_m) <= MAX_PIXELS
    gsd_m = HEIGHT_M / frame.camera.fx_px
    assert view.area_m2 == pytest.approx(share * (512 * gsd_m) ** 2, rel=0.05)
    assert np.ptp(view.points_enu_m, axis=0) == pytest.approx([512 * gsd_m] * 2, rel=0.02)


def test_spots_of_sun_on_a_warm_day_join_nothing() -> None:
    """A fifth of a forest of 25 °C lies in the sun, 2 K warmer in the mean, and a person shows 8 K."""
    frame = frame_with_spot(kelvin=8.0, offset_k=14.0)
    rng = np.random.default_rng(5)
    thermal = frame.image[..., 3]
    spots_k = np.where(rng.random((16, 16)) < 0.2, rng.normal(2.5, 1.0, (16, 16)), 0.0)
    sun_k = np.where(thermal < 30.0, np.kron(spots_k, np.ones((8, 8))), 0.0)
    assert (sun_k > MIN_CONTRAST_K).sum() > 9
    lit = np.dstack([frame.image[..., :3], thermal + sun_k]).astype(np.float32)
    (person,), *corners = warm_bodies([warm_view(dataclasses.replace(frame, image=lit))])
    np.testing.assert_allclose(person.points_enu_m.mean(axis=0), [2.0, -1.0], atol=GSD_M)
    assert {len(view.points_enu_m) for (view,) in corners} == {1}, "of the largest spots, sharpened"


@pytest.mark.parametrize(("share", "in_sun"), [(0.0, False), (0.05, False), (0.3, True)])
def test_the_sun_is_known_by_the_ground_that_it_warms(share: float, in_sun: bool) -> None:
    assert warm_view(sunlit_frame(share, edge_px=64)).in_sun is in_sun


@pytest.mark.parametrize(("level", "in_sun"), [(10.0, False), (90.0, True)])
def test_nothing_is_in_the_sun_by_night(level: float, in_sun: bool) -> None:
    thermal = sunlit_frame(0.3, edge_px=64)
    colours = np.full((64, 64, 3), level, np.float32)
    frame = dataclasses.replace(thermal, image=np.concatenate((colours, thermal.image), axis=2), bands=BANDS)
    assert warm_view(frame).in_sun is in_sun


def test_nothing_compares_rows_under_the_lock_of_the_interpreter(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sorting rows did that for seconds: every other thread, with the heartbeat, stood still."""
    unique = np.unique

    def checked(values: np.ndarray, *args: object, **options: object) -> object:
        assert values.ndim == 1
        assert values.dtype != object
        return unique(values, *args, **options)  # type: ignore[call-overload]

    monkeypatch.setattr(np, "unique", checked)
    assert warm_bodies([warm_view(sunlit_frame(0.3, edge_px=64))])


def view_at(vehicle_id: int, points_enu_m: list[tuple[float, float]]) -> WarmView:
    points = np.array(points_enu_m, dtype=np.float64).reshape(-1, 2)
    return WarmView(vehicle_id, points, np.full(len(points), 12.0), 0.01, CAMERA, nadir_pose([0.0, 0.0, HEIGHT_M]))


PLACES = st.lists(st.tuples(st.integers(-20, 20), st.integers(-20, 20)), max_size=30)


@given(st.lists(PLACES, min_size=1, max_size=4))
def test_bodies_are_the_points_that_chains_of_near_cells_join(places: list[list[tuple[int, int]]]) -> None:
    # Centres of cells of 0.25 m: distances of points are those of their cells.
    views = [view_at(i, [(0.75 * x + 0.125, 0.75 * y + 0.125) for x, y in points]) for i, points in enumerate(places)]
    left = {(i, k) for i, view in enumerate(views) for k in range(len(view.points_enu_m))}
    expected = []
    while left:
        body, fresh = set(), {left.pop()}
        while fresh:
            body |= fresh
            near = {
                (i, k)
                for i, k in left
                if any(math.dist(views[i].points_enu_m[k], views[j].points_enu_m[m]) <= LINK_M for j, m in fresh)
            }
            left, fresh = left - near, near
        expected.append(sorted((i, *views[i].points_enu_m[k]) for i, k in body))
    bodies = warm_bodies(views)
    found = [sorted((part.vehicle_id, *point) for part in body for point in part.points_enu_m) for body in bodies]
    assert sorted(found) == sorted(expected)
    assert [len(body) for body in found] == sorted(map(len, found), reverse=True)


def test_a_point_near_the_horizon_is_a_body_of_its_own() -> None:
    bodies = warm_bodies([view_at(1, [(0.0, 0.0), (0.5, 0.0), (1e15, -1e15)])])
    assert [sum(len(part.points_enu_m) for part in body) for body in bodies] == [2, 1]


def test_evidence_sums_a_body_up() -> None:
    frames = [frame_with_spot(kelvin=14.0, edge_px=3), frame_with_spot(kelvin=20.0, edge_px=5, vehicle_id=2)]
    frames.append(frame_with_spot(kelvin=14.0, edge_px=3))
    (body,) = warm_bodies([warm_view(frame) for frame in frames])
    evidence = gather_evidence(body)
    assert (evidence.views, evidence.vehicles) == (3, 2)
    assert evidence.area_m2 == pytest.approx(25 * GSD_M**2)
    assert evidence.extent_m == pytest.approx(4 * GSD_M)
    assert evidence.contrast_median_k == pytest.approx(20.0, abs=0.2)
    assert evidence.contrast_peak_k == pytest.approx(20.0, abs=0.2)
    assert evidence.background_c == pytest.approx(11.0, abs=0.1)


@pytest.mark.parametrize(
    ("speeds_mps", "contrast_k", "is_smeared"),
    [
        ((0.0, 1.0, 5.0, 5.0), 12.0, False),
        ((0.0, 5.0, 5.0, 5.0), 7.0, True),
        ((5.0, 5.0, 5.0, 5.0), 7.0, True),
        ((0.0, 0.0, 0.0, 0.0), 12.0, False),
    ],
)
def test_contrasts_are_those_of_cameras_that_hovered_where_two_did(
    speeds_mps: tuple[float, ...], contrast_k: float, is_smeared: bool
) -> None:
    contrasts_k = (12.0 if speed_mps < 2.0 else 7.0 for speed_mps in speeds_mps)
    views = [
        dataclasses.replace(
            view_at(number, [(0.1 * number, 0.0)]),
            speed_mps=speed_mps,
            contrast_k=np.array([kelvin]),
            pixel_area_m2=GSD_M**2 / 16,
        )
        for number, (speed_mps, kelvin) in enumerate(zip(speeds_mps, contrasts_k, strict=True))
    ]
    evidence = gather_evidence(views, views)
    assert evidence.contrast_median_k == pytest.approx(contrast_k)
    assert evidence.is_smeared is is_smeared
    assert (evidence.views, evidence.vehicles) == (4, 4)


def test_a_view_on_another_plane_is_that_of_a_look_at_it() -> None:
    frame = frame_with_spot()
    moved, looked = warm_view(frame, 0.0).on_plane(0.0, 6.5), warm_view(frame, 6.5)
    np.testing.assert_allclose(moved.points_enu_m, looked.points_enu_m, atol=1e-9)
    np.testing.assert_array_equal(moved.contrast_k, looked.contrast_k)
    assert moved.area_m2 == pytest.approx(looked.area_m2)
    assert len(warm_view(frame, 0.0).on_plane(0.0, HEIGHT_M).points_enu_m) == 0


def test_places_of_a_single_vehicle_count_as_vehicles_where_they_are_apart() -> None:
    at_m = [0.0, 1.0, 3.0, 6.0]
    own = [dataclasses.replace(view_at(1, [(0.0, 0.0)]), pose=nadir_pose([east_m, 0.0, HEIGHT_M])) for east_m in at_m]
    # One metre farther on, it sees through the same gaps.
    assert gather_evidence(own, own).vehicles == 3
    assert gather_evidence(own[:1], own).vehicles == 1
    # In a swarm, vehicles count.
    swarm = [*own, view_at(2, [(9.0, 9.0)])]
    assert gather_evidence(own, swarm).vehicles == 1
    assert gather_evidence(swarm, swarm).vehicles == 2
