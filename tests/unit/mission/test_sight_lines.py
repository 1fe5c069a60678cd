"""Lines of sight of all steps: a better place than that of the latest ones, unless the body walks."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.geolocation import Geolocation, Uncertainty, geolocate
from aos_gcs.imaging.model import BlobView
from aos_gcs.mission.search.targets.sight_lines import MAX_LINES, SightLines

CAMERA = CameraModel.from_fov(512, 512, math.radians(50.0))
UNCERTAINTY = Uncertainty(position_horizontal_m=0.02, position_vertical_m=0.05)
ALTITUDE_M, BODY_M = 35.0, 0.6


def views_of(
    body_m: tuple[float, float], places_m: list[tuple[float, float]], biases_m: NDArray[np.float64]
) -> list[BlobView]:
    """One view per vehicle, displaced by its constant error of attitude; the body's height hides the ground behind."""
    views = []
    for vehicle_id, (place_m, bias_m) in enumerate(zip(places_m, biases_m, strict=True), start=1):
        pose = nadir_pose([*place_m, ALTITUDE_M])
        point_m = np.array(body_m) + (np.array(body_m) - place_m) * BODY_M / (ALTITUDE_M - BODY_M) + bias_m
        views.append(BlobView(vehicle_id, point_m, CAMERA, pose))
    return views


def error_m(place: Geolocation, body_m: tuple[float, float]) -> float:
    return float(np.linalg.norm(place.position_enu_m[:2] - body_m))


def circle(step: int, count: int, shift_m: float = 0.0) -> list[tuple[float, float]]:
    angles = [2.0 * math.pi * index / count + 0.4 * step for index in range(count)]
    return [(8.0 * math.cos(angle) + shift_m, 8.0 * math.sin(angle)) for angle in angles]


def test_all_vehicles_that_ever_saw_a_body_locate_it() -> None:
    rng = np.random.default_rng(4)
    late, together = [], []
    for _ in range(20):
        biases_m = rng.normal(scale=0.6, size=(5, 2))
        lines, place = SightLines(), None
        for step in range(8):
            # All vehicles saw it at first; one does at the end.
            seen = 5 if step < 4 else 1
            views = views_of((1.0, -2.0), circle(step, seen), biases_m[:seen])
            latest = geolocate(views, 0.0, UNCERTAINTY)
            lines, place = lines.extended(views, latest, 0.0, UNCERTAINTY)
        assert place is not None
        late.append(error_m(latest, (1.0, -2.0)))
        together.append(error_m(place, (1.0, -2.0)))
    assert np.median(together) < 0.6 * np.median(late)


def test_the_place_is_never_worse_known_than_by_the_latest_steps() -> None:
    rng = np.random.default_rng(1)
    lines, sigmas = SightLines(), []
    for step in range(6):
        views = views_of((0.0, 0.0), circle(step, 3), rng.normal(scale=0.3, size=(3, 2)))
        latest = geolocate(views, 0.0, UNCERTAINTY)
        lines, place = lines.extended(views, latest, 0.0, UNCERTAINTY)
        assert np.trace(place.covariance_m2[:2, :2]) <= np.trace(latest.covariance_m2[:2, :2])
        sigmas.append(np.trace(place.covariance_m2[:2, :2]))
    assert sigmas == sorted(sigmas, reverse=True)


def test_a_body_that_walks_away_is_where_it_was_seen_last() -> None:
    lines, none = SightLines(), np.zeros((4, 2))
    for step in range(12):
        body_m = (0.5 * step, 0.0)
        views = views_of(body_m, circle(step, 4, body_m[0]), none)
        latest = geolocate(views, 0.0, UNCERTAINTY)
        lines, place = lines.extended(views, latest, 0.0, UNCERTAINTY)
        assert error_m(place, body_m) < 2.0


def test_lines_are_bounded_and_come_from_all_steps_and_vehicles() -> None:
    lines, none = SightLines(), np.zeros((10, 2))
    for step in range(40):
        views = views_of((0.0, 0.0), circle(step, 10), none)
        lines, _ = lines.extended(views, geolocate(views, 0.0, UNCERTAINTY), 0.0, UNCERTAINTY)
    assert len(lines.lines) == MAX_LINES
    per_vehicle = np.bincount([line.view.vehicle_id for line in lines.lines], minlength=11)[1:]
    assert per_vehicle.min() >= MAX_LINES // 20
    per_quarter = np.bincount([line.number // 100 for line in lines.lines], minlength=4)
    assert per_quarter.min() >= MAX_LINES // 8


def test_lines_are_taken_to_the_focal_plane_in_use() -> None:
    none = np.zeros((4, 2))
    views = views_of((3.0, 1.0), circle(0, 4), none)
    lines, _ = SightLines().extended(views, geolocate(views, 0.0, UNCERTAINTY), 0.0, UNCERTAINTY)
    raised = [
        BlobView(
            v.vehicle_id,
            v.pose.position_enu_m[:2] + (v.point_enu_m - v.pose.position_enu_m[:2]) * 33 / 35,
            CAMERA,
            v.pose,
        )
        for v in views_of((3.0, 1.0), circle(1, 4), none)
    ]
    latest = geolocate(raised, 2.0, UNCERTAINTY)
    _, place = lines.extended(raised, latest, 2.0, UNCERTAINTY)
    assert place.position_enu_m[:2] == pytest.approx([3.0, 1.0], abs=0.15)
