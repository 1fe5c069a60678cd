"""Separation of positions that err: granted paths keep the true distance, wherever in their accuracy vehicles are."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs.airspace.accuracy import (
    EXACT,
    Accuracy,
    clearances,
    greatest_accuracy_m,
    joint_errors_m,
    needed_spacing_m,
)
from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.traffic import Obstacle, WaypointRequest
from aos_gcs.airspace.vetting import vet_waypoints
from aos_gcs.airspace.waypoints import WaypointVerdict

FloatArray = NDArray[np.float64]
SEPARATION_M = 1.5
LIMITS = SafetyLimits(
    fence_enu_m=((-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0)),
    floor_m=20.0,
    ceiling_m=60.0,
    separation_m=SEPARATION_M,
)
sizes = st.floats(0.0, 4.0)


def test_exact_positions_keep_the_separation_alone() -> None:
    for clearance in clearances(SEPARATION_M, np.zeros(1), np.zeros(1)):
        assert (clearance.wide_m[0], clearance.high_m[0]) == (SEPARATION_M, SEPARATION_M)
    assert joint_errors_m(EXACT, EXACT) == (0.0, 0.0)


@given(sizes, sizes, st.floats(0.0, np.pi / 2))
def test_an_offset_outside_of_the_clearances_is_a_true_distance_of_the_separation(
    horizontal_m: float, vertical_m: float, sphere_angle: float
) -> None:
    both = clearances(SEPARATION_M, np.array([horizontal_m]), np.array([vertical_m]))
    # The rim of the cylinder of errors, moved by the separation in any direction, lies within the ellipsoid.
    beside_m = horizontal_m + SEPARATION_M * np.cos(sphere_angle)
    above_m = vertical_m + SEPARATION_M * np.sin(sphere_angle)
    for clearance in both:
        assert (beside_m / clearance.wide_m[0]) ** 2 + (above_m / clearance.high_m[0]) ** 2 <= 1.0 + 1e-6


@given(st.floats(0.0, 3.0))
def test_layers_of_the_needed_spacing_bear_the_accuracy(vertical_m: float) -> None:
    spacing_m = needed_spacing_m(SEPARATION_M, vertical_m)
    assert greatest_accuracy_m(SEPARATION_M, spacing_m) == pytest.approx(vertical_m, abs=1e-9)
    errors_m = joint_errors_m(Accuracy(0.0, vertical_m), Accuracy(0.0, vertical_m))
    low, _ = clearances(SEPARATION_M, *np.atleast_2d(errors_m).T)
    assert spacing_m >= low.high_m[0]


def request(vehicle_id: int, start: FloatArray, end: FloatArray, accuracy: Accuracy) -> WaypointRequest:
    return WaypointRequest(
        vehicle_id=vehicle_id,
        position_enu_m=start,
        requested_enu_m=end,
        link_age_s=0.1,
        position_age_s=0.1,
        battery_fraction=0.9,
        accuracy=accuracy,
    )


def test_inaccurate_positions_keep_farther_apart_beside_than_above() -> None:
    accuracy = Accuracy(1.0, 0.1)
    end = np.array([20.0, 0.0, 35.0])
    beside = Obstacle(2, np.array([8.0, 3.0, 35.0]), accuracy=accuracy)
    (record,) = vet_waypoints([request(1, np.array([0.0, 0.0, 35.0]), end, accuracy)], [beside], LIMITS)
    assert record.verdict is WaypointVerdict.SHORTENED
    assert "it would pass vehicle 2 at 3.0 m" in record.reason
    assert "limit 4.4 m beside, 1.9 m above or below" in record.reason
    above = Obstacle(2, np.array([8.0, 3.0, 37.0]), accuracy=accuracy)
    (record,) = vet_waypoints([request(1, np.array([0.0, 0.0, 35.0]), end, accuracy)], [above], LIMITS)
    assert record.verdict is WaypointVerdict.SENT


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 6), st.floats(0.0, 1.5), st.floats(0.0, 1.5))
def test_true_paths_of_granted_waypoints_keep_the_separation(
    seed: int, count: int, horizontal_m: float, vertical_m: float
) -> None:
    rng = np.random.default_rng(seed)
    accuracy = Accuracy(horizontal_m, vertical_m)
    both = clearances(SEPARATION_M, *np.atleast_2d(joint_errors_m(accuracy, accuracy)).T)
    starts: list[FloatArray] = []
    while len(starts) < count:
        start = rng.uniform([-20.0, -20.0, 25.0], [20.0, 20.0, 55.0])
        offsets = [start - other for other in starts]
        if all(any(np.linalg.norm(one.scale()[0] * offset) > one.wide_m[0] for one in both) for offset in offsets):
            starts.append(start)
    requests = [
        request(row + 1, start, rng.uniform([-20.0, -20.0, 25.0], [20.0, 20.0, 55.0]), accuracy)
        for row, start in enumerate(starts)
    ]
    records = vet_waypoints(requests, [], LIMITS)
    # Twice the accuracy is what is reckoned with for one vehicle, and for two together by their root sum.
    errors = rng.standard_normal((count, 3))
    beside = np.linalg.norm(errors[:, :2], axis=1, keepdims=True)
    errors = np.sqrt(2.0) * np.hstack([horizontal_m * errors[:, :2] / beside, vertical_m * np.sign(errors[:, 2:])])
    shares = np.linspace(0.0, 1.0, 40)[:, None]
    paths = [
        start + shares * (np.array(record.sent_enu_m or start) - start) - error
        for start, record, error in zip(starts, records, errors, strict=True)
    ]
    for one, other in combinations(paths, 2):
        assert np.linalg.norm(one[:, None] - other, axis=2).min() >= SEPARATION_M - 1e-5
