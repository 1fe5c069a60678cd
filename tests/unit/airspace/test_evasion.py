"""Paths beside vehicles that cannot be asked to make way, and places out of their columns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.airspace.accuracy import Accuracy
from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.plans import TrafficSituation, vet_plan
from aos_gcs.airspace.traffic import Obstacle, WaypointRequest
from aos_gcs.airspace.vetting import vet_waypoints
from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict
from tests.fakes.waypoints import request

SQUARE = ((-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0))
LIMITS = SafetyLimits(fence_enu_m=SQUARE, floor_m=20.0, ceiling_m=60.0, margin_m=5.0, separation_m=1.5)
RTK = Accuracy(0.014, 0.029)
DRIFT_M = 1.0
PILOTED = Obstacle(
    2, np.array([0.0, 20.0, 39.0]), column=True, accuracy=RTK, drift_m=DRIFT_M, left_alone="which has a pilot"
)
LOST = replace(PILOTED, drift_m=0.0, left_alone="which is not heard", home_enu_m=np.array([40.0, 20.0, 0.0]))
CLIMBING = replace(LOST, return_up_m=50.0)
"""A vehicle that is lost above terrain, where it climbs before it returns."""


def vehicle(start: tuple[float, float, float], **values: object) -> WaypointRequest:
    return replace(request(1, start, start), accuracy=RTK, **values)  # type: ignore[arg-type]


def plan(
    start: tuple[float, float, float], end: tuple[float, float, float], *obstacles: Obstacle, **values: object
) -> WaypointRecord:
    situation = TrafficSituation(
        limits=LIMITS, arrival_radius_m=0.5, movable=(vehicle(start, **values),), obstacles=obstacles
    )
    (record,) = vet_plan({1: np.array(end)}, situation, situation.detours())
    return record


def beside_m(record: WaypointRecord, other: Obstacle = PILOTED) -> float:
    assert record.sent_enu_m is not None
    return float(np.linalg.norm(np.array(record.sent_enu_m)[:2] - other.position_enu_m[:2]))


def test_a_path_ends_so_far_beside_a_vehicle_with_a_pilot_that_it_may_drift() -> None:
    approach = replace(vehicle((0.0, 40.0, 35.0)), requested_enu_m=np.array([0.0, 0.0, 35.0]))
    ends_m = []
    for drift_m in (0.0, DRIFT_M):
        (record,) = vet_waypoints([approach], [replace(PILOTED, drift_m=drift_m)], LIMITS)
        ends_m.append(beside_m(record))
    assert LIMITS.separation_m < ends_m[0] < LIMITS.separation_m + 0.3
    assert ends_m[1] >= LIMITS.separation_m + DRIFT_M


@pytest.mark.parametrize(
    ("start", "end"),
    [
        ((0.0, 20.8, 35.0), (0.0, 0.0, 35.0)),
        ((0.6, 20.4, 35.0), (0.0, 0.0, 35.0)),
        ((0.6, 20.0, 35.0), (0.6, 20.0, 35.0)),
        ((0.0, 20.0, 35.0), (0.0, 20.0, 35.0)),
    ],
)
def test_a_vehicle_in_the_column_of_one_with_a_pilot_moves_out_of_it(
    start: tuple[float, float, float], end: tuple[float, float, float]
) -> None:
    record = plan(start, end, PILOTED)
    assert record.verdict is WaypointVerdict.SHORTENED
    assert record.reason.startswith("clear of vehicle 2, which has a pilot, by ")
    assert record.requested_enu_m == end
    assert record.sent_enu_m is not None
    assert record.sent_enu_m[2] == start[2]
    assert beside_m(record) >= LIMITS.separation_m + DRIFT_M


@pytest.mark.parametrize(
    ("start", "other"),
    [
        ((0.0, 20.8, 35.0), LOST),
        ((0.6, 20.0, 35.0), LOST),
        ((0.0, 20.8, 35.0), CLIMBING),
        ((0.0, 20.8, 43.0), CLIMBING),
    ],
)
def test_a_vehicle_in_the_column_of_a_lost_one_moves_out_of_it(
    start: tuple[float, float, float], other: Obstacle
) -> None:
    end = (0.0, 0.0, start[2])
    record = plan(start, end, other)
    assert record.reason.startswith("clear of vehicle 2, which is not heard, by ")
    assert record.sent_enu_m is not None
    assert record.sent_enu_m[2] == start[2]
    assert beside_m(record, other) >= LIMITS.separation_m


@pytest.mark.parametrize(
    ("start", "end"),
    [((0.2, 30.0, 35.0), (0.0, 0.0, 35.0)), ((40.2, 30.0, 35.0), (40.0, 0.0, 35.0))],
    ids=["where it was heard last", "its launch point"],
)
def test_a_way_leads_around_the_columns_of_a_lost_vehicle(
    start: tuple[float, float, float], end: tuple[float, float, float]
) -> None:
    record = plan(start, end, LOST)
    assert record.verdict is WaypointVerdict.SHORTENED
    assert record.reason.startswith("around vehicle 2, which is not heard, by ")


def test_a_way_does_not_lead_around_where_a_lost_vehicle_that_moved_was_heard_last() -> None:
    moving = replace(LOST, stop_enu_m=np.array([8.0, 20.0, 39.0]))
    assert plan((0.2, 30.0, 35.0), (0.0, 0.0, 35.0), moving).reason.startswith("shortened ")


@pytest.mark.parametrize("north_m", [19.0, 20.0])
def test_a_path_that_leads_out_of_the_column_is_flown_as_planned(north_m: float) -> None:
    record = plan((0.0, north_m, 35.0), (0.0, 0.0, 35.0), PILOTED)
    assert record.verdict is WaypointVerdict.SENT


@pytest.mark.parametrize(
    ("start", "other"),
    [
        ((0.6, 20.0, 42.0), PILOTED),
        ((0.6, 20.0, 35.0), replace(PILOTED, left_alone="")),
        ((LIMITS.separation_m + 0.8 * DRIFT_M, 20.0, 35.0), PILOTED),
    ],
    ids=["above it", "it makes way", "hardly too near"],
)
def test_others_stay_where_they_are(start: tuple[float, float, float], other: Obstacle) -> None:
    assert plan(start, start, other).verdict is WaypointVerdict.SENT


def test_a_vehicle_that_must_not_be_sent_is_held_below_one_with_a_pilot_too() -> None:
    record = plan((0.6, 20.0, 35.0), (0.0, 0.0, 35.0), PILOTED, position_age_s=60.0)
    assert record.verdict is WaypointVerdict.HELD


def test_no_vehicle_moves_out_of_the_geofence() -> None:
    at_fence = replace(PILOTED, position_enu_m=np.array([44.0, 0.0, 39.0]))
    record = plan((44.5, 0.0, 35.0), (0.0, 0.0, 35.0), at_fence)
    assert record.sent_enu_m is None or record.sent_enu_m[0] <= 45.0
