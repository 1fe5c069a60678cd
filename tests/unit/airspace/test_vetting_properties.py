"""Safety of waypoints: what holds for any input."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs.airspace.accuracy import EXACT, Accuracy
from aos_gcs.airspace.detours import Detours
from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.plans import TrafficSituation, vet_plan
from aos_gcs.airspace.polygon import as_polygon, signed_depth_m
from aos_gcs.airspace.separation import segment_distance
from aos_gcs.airspace.traffic import Obstacle, Traffic, WaypointRequest
from aos_gcs.airspace.vetting import _Far, vet_waypoints
from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict
from tests.fakes.waypoints import request

FloatArray = NDArray[np.float64]
SQUARE = ((-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0))
NOTCHED = ((-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (0.0, -10.0), (-50.0, 50.0))


ZONE = ((-30.0, -40.0), (-10.0, -45.0), (-20.0, -20.0))
FREE = SafetyLimits(fence_enu_m=NOTCHED, no_go_enu_m=(ZONE,), floor_m=20.0, ceiling_m=40.0, margin_m=3.0)
points = st.one_of(
    st.tuples(st.floats(-60.0, 60.0), st.floats(-60.0, 60.0), st.floats(15.0, 45.0)),
    st.tuples(st.floats(-5.0, 5.0), st.floats(-20.0, -5.0), st.floats(25.0, 35.0)),
)
"""Anywhere about the fence, or in a crowd at the tip of its notch."""
segments = st.tuples(points, points, st.floats(0.0, 3.5))
"""Start, end and link age: some are outside the limits, some silent."""


def airborne(
    drawn: list[tuple[tuple[float, float, float], tuple[float, float, float], float]],
) -> list[WaypointRequest]:
    return [request(10 + row, start, end, link_age_s=age) for row, (start, end, age) in enumerate(drawn)]


def segment_of(vehicle: WaypointRequest, record: WaypointRecord, samples: int = 60) -> FloatArray:
    end = vehicle.position_enu_m if record.sent_enu_m is None else np.array(record.sent_enu_m)
    fraction = np.linspace(0.0, 1.0, samples)[:, None]
    return vehicle.position_enu_m + fraction * (end - vehicle.position_enu_m)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(segments, min_size=1, max_size=6),
    st.lists(st.tuples(points, st.booleans(), st.none() | points), max_size=2),
)
def test_no_admitted_segment_violates_a_limit(
    drawn: list[tuple[tuple[float, float, float], tuple[float, float, float], float]],
    drawn_obstacles: list[tuple[tuple[float, float, float], bool, tuple[float, float, float] | None]],
) -> None:
    vehicles = airborne(drawn)
    obstacles = [
        Obstacle(row, np.array(at), column=column, home_enu_m=None if home is None else np.array(home))
        for row, (at, column, home) in enumerate(drawn_obstacles)
    ]
    sampled = [
        segment_of(vehicle, record)
        for vehicle, record in zip(vehicles, vet_waypoints(vehicles, obstacles, FREE), strict=True)
    ]
    fence, zone = as_polygon(FREE.fence_enu_m, "fence"), as_polygon(ZONE, "zone")
    for segment in sampled:
        for vertices, side in ((fence, 1.0), (zone, -1.0)):
            depth = side * signed_depth_m(segment[0, :2], vertices)
            if depth > 0.0:
                allowed = min(FREE.margin_m, depth) - 1e-6
                assert min(side * signed_depth_m(point, vertices) for point in segment[:, :2]) >= allowed
        assert segment[:, 2].min() >= min(FREE.floor_m, segment[0, 2]) - 1e-6
        assert segment[:, 2].max() <= max(FREE.ceiling_m, segment[0, 2]) + 1e-6
    for obstacle in obstacles:
        for low, high in obstacle.segments():
            sampled.append(low + np.linspace(0.0, 1.0, 60)[:, None] * (high - low))
    for one, other in combinations(range(len(sampled)), 2):
        if other >= len(vehicles) and one >= len(vehicles):
            continue
        distances = np.linalg.norm(sampled[one][:, None] - sampled[other][None, :], axis=2)
        start = sampled[one][0]
        end = sampled[other][-1] if other >= len(vehicles) else sampled[other][0]
        present = float(segment_distance(start, start, sampled[other][0], end))
        assert distances.min() >= min(FREE.separation_m, present) - 1e-5


@settings(max_examples=40, deadline=None)
@given(st.lists(segments, min_size=2, max_size=6), st.randoms(use_true_random=False))
def test_the_order_of_the_arguments_changes_nothing(
    drawn: list[tuple[tuple[float, float, float], tuple[float, float, float], float]],
    random: np.random.Generator,
) -> None:
    vehicles = airborne(drawn)
    records = vet_waypoints(vehicles, [], FREE)
    shuffled = list(vehicles)
    random.shuffle(shuffled)
    by_id = {record.vehicle_id: record for record in vet_waypoints(shuffled, [], FREE)}
    assert [by_id[vehicle.vehicle_id] for vehicle in vehicles] == list(records)


@settings(max_examples=40, deadline=None)
@given(st.lists(segments, min_size=1, max_size=5))
def test_what_was_granted_is_not_cut_again(
    drawn: list[tuple[tuple[float, float, float], tuple[float, float, float], float]],
) -> None:
    # All start inside: a part of a segment back from outside does not lead back inside.
    wide = replace(FREE, no_go_enu_m=(), fence_enu_m=tuple((2.0 * east_m, 2.0 * north_m) for east_m, north_m in SQUARE))
    vehicles = airborne(drawn)
    records = vet_waypoints(vehicles, [], wide)
    again = [
        WaypointRequest(
            vehicle_id=vehicle.vehicle_id,
            position_enu_m=vehicle.position_enu_m,
            requested_enu_m=vehicle.position_enu_m if record.sent_enu_m is None else np.array(record.sent_enu_m),
            link_age_s=0.1,
            position_age_s=0.1,
            battery_fraction=0.9,
        )
        for vehicle, record in zip(vehicles, records, strict=True)
    ]
    for vehicle, record, second in zip(vehicles, records, vet_waypoints(again, [], wide), strict=True):
        first_segment, second_segment = segment_of(vehicle, record), segment_of(vehicle, second)
        assert np.array_equal(first_segment[-1], second_segment[-1])


def test_a_hundred_vehicles_in_their_own_cells_all_fly() -> None:
    cells = np.stack(np.meshgrid(np.arange(10), np.arange(10)), axis=-1).reshape(-1, 2) * 8.0 - 40.0
    rng = np.random.default_rng(1)
    starts = np.column_stack([cells + rng.uniform(0.0, 6.0, (100, 2)), np.full(100, 35.0)])
    ends = np.column_stack([cells + rng.uniform(0.0, 6.0, (100, 2)), np.full(100, 35.0)])
    limits = SafetyLimits(fence_enu_m=SQUARE, floor_m=20.0, ceiling_m=60.0)
    vehicles = [request(row, tuple(starts[row]), tuple(ends[row])) for row in range(100)]
    assert {record.verdict for record in vet_waypoints(vehicles, [], limits)} == {WaypointVerdict.SENT}


errors = st.sampled_from([EXACT, Accuracy(0.02, 0.03), Accuracy(1.5, 0.4), Accuracy(0.5, 2.0)])


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(segments, errors), min_size=1, max_size=6),
    st.lists(st.tuples(points, errors, st.none() | points), max_size=3),
)
def test_vehicles_that_are_passed_over_as_too_far_would_change_nothing(
    drawn: list[tuple[tuple[tuple[float, float, float], tuple[float, float, float], float], Accuracy]],
    drawn_obstacles: list[tuple[tuple[float, float, float], Accuracy, tuple[float, float, float] | None]],
) -> None:
    moving = airborne([segment for segment, _ in drawn])
    moving = [replace(one, accuracy=accuracy) for one, (_, accuracy) in zip(moving, drawn, strict=True)]
    obstacles = [
        Obstacle(row, np.array(at), accuracy=accuracy, waypoint_enu_m=None if end is None else np.array(end))
        for row, (at, accuracy, end) in enumerate(drawn_obstacles)
    ]
    vetted = vet_waypoints(moving, obstacles, FREE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Traffic, "_near", lambda traffic, *_: np.ones(len(traffic._ids), dtype=np.bool_))
        assert vet_waypoints(moving, obstacles, FREE) == vetted


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize(("count", "spread_m"), [(6, 60.0), (40, 150.0)])
def test_large_fleets_are_vetted_together_as_one_by_one(seed: int, count: int, spread_m: float) -> None:
    rng = np.random.default_rng(seed)
    limits = replace(FREE, fence_enu_m=tuple((5.0 * east_m, 5.0 * north_m) for east_m, north_m in NOTCHED))
    starts = np.column_stack([rng.uniform(-spread_m, spread_m, (count, 2)), rng.uniform(19.0, 41.0, count)])
    ends = starts + rng.normal(0.0, [30.0, 30.0, 2.0], (count, 3)) * rng.choice([0.0, 0.1, 1.0], (count, 1))
    if seed % 2:
        ends = rng.normal([0.0, -100.0, 30.0], [8.0, 8.0, 1.0], (count, 3))  # all to one place
    ends[3, 1] = np.inf
    accuracies = [EXACT, Accuracy(0.02, 0.03), Accuracy(1.5, 0.4)]
    movable = tuple(
        replace(
            request(10 + row, tuple(starts[row]), tuple(starts[row]), link_age_s=9.0 if row == 5 else 0.1),
            accuracy=accuracies[row % 3],
            waypoint_enu_m=starts[row] + rng.normal(0.0, 5.0, 3) if row % 4 == 0 else None,
            stop_enu_m=starts[row] + rng.normal(0.0, 1.0, 3) if row % 5 == 0 else None,
        )
        for row in rng.permutation(count)
    )
    obstacles = tuple(Obstacle(row, rng.uniform(-spread_m, spread_m, 3), column=row % 2 == 0) for row in range(4))
    situation = TrafficSituation(limits=limits, arrival_radius_m=0.5, movable=movable, obstacles=obstacles)
    planned_enu_m = {10 + row: ends[row] for row in range(count)}
    vetted = vet_plan(planned_enu_m, situation, situation.detours())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("aos_gcs.airspace.vetting._far", lambda *_: _Far(frozenset(), frozenset()))
        patch.setattr(Detours, "_are_far", lambda _, starts_m, __: np.zeros(len(starts_m), dtype=np.bool_))
        assert vet_plan(planned_enu_m, situation, situation.detours()) == vetted
    assert len({record.verdict for record in vetted}) > 1
