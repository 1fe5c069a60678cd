"""Whole plans over random relief: line by line and leg by leg, nothing that is sent meets the floor above ground."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs.airspace.limits import GroundLimits, SafetyLimits
from aos_gcs.airspace.plans import TrafficSituation, vet_plan
from aos_gcs.airspace.reference_surface import LEVEL, ReferenceSurface, reference_surface
from aos_gcs.airspace.terrain import GroundRaster
from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict
from aos_gcs.planning.legs import ScanLeg, leg_formation, scan_legs
from tests.fakes.waypoints import request
from tests.unit.airspace.test_reference_surface import BOUNDS, raster, reliefs

FloatArray = NDArray[np.float64]
FENCE = ((-100.0, -90.0), (100.0, -90.0), (100.0, 95.0), (-100.0, 95.0))
FLOOR_M, CEILING_M, SEPARATION_M, LOWEST_M, LAYERS_M = 30.0, 150.0, 1.5, 40.0, 3.0
MOVES_PER_GOAL = 12
"""Most waypoints on the way to one goal: a swarm that gets no farther goes on with the next one."""
WHERE = re.compile(r"the ground (at|is not known at) -?\d+ m east, -?\d+ m north")
HOW_MUCH = re.compile(r"\d+\.\d m (below the floor|beyond the ceiling) above ground|is not known")


@dataclass(frozen=True)
class RandomPlan:
    heights_m: FloatArray
    vehicles: int
    spacing_m: float
    legs: tuple[ScanLeg, ...]
    follows: bool


@st.composite
def plans(draw: st.DrawFn) -> RandomPlan:
    middle_m = np.array((draw(st.floats(-20.0, 20.0)), draw(st.floats(-20.0, 20.0))))
    half_m = np.array((draw(st.floats(15.0, 45.0)), draw(st.floats(15.0, 45.0))))
    turn_rad, heading_rad = draw(st.floats(0.0, math.pi)), draw(st.floats(0.0, math.pi))
    turn = np.array([[math.cos(turn_rad), -math.sin(turn_rad)], [math.sin(turn_rad), math.cos(turn_rad)]])
    corners_m = middle_m + (np.array(((-1, -1), (1, -1), (1, 1), (-1, 1))) * half_m) @ turn.T
    vehicles, spacing_m = draw(st.integers(2, 5)), draw(st.floats(2.0, 6.0))
    direction = np.array((math.sin(heading_rad), math.cos(heading_rad)))
    legs = scan_legs(corners_m.tolist(), corners_m[0], direction, n=vehicles, spacing_m=spacing_m, footprint_m=30.0)
    return RandomPlan(draw(reliefs()), vehicles, spacing_m, legs, draw(st.booleans()))


class Swarm:
    """Vehicles that fly what is granted, each in its layer, and what has become of each of their waypoints."""

    def __init__(self, plan: RandomPlan, ground: GroundRaster) -> None:
        above = GroundLimits(floor_m=FLOOR_M, ceiling_m=CEILING_M, offsets_m=ground.offsets_m)
        self.limits = SafetyLimits(
            fence_enu_m=FENCE, floor_m=-1e4, ceiling_m=1e4, separation_m=SEPARATION_M, above_ground=above
        )
        self.surface: ReferenceSurface = reference_surface(ground, BOUNDS, 0.2) if plan.follows else LEVEL
        self.ground = ground
        self.level_m = 0.0 if plan.follows else float(np.nanmax(plan.heights_m, initial=0.0)) * 0.7
        places_m = leg_formation(plan.legs[0], np.zeros((plan.vehicles, 2)), plan.spacing_m)
        self.places_m = [self.in_layer(number, place_m) for number, place_m in enumerate(places_m)]
        self.flown: list[tuple[FloatArray, WaypointRecord]] = []

    def in_layer(self, number: int, place_m: FloatArray) -> FloatArray:
        up_m = LOWEST_M + LAYERS_M * number + self.level_m + self.surface.at(place_m)
        return np.array((*place_m, up_m))

    def fly_to(self, goals_m: FloatArray) -> None:
        """Go on to one place per vehicle, shape (n, 2), for as long as somebody gets on."""
        planned = {number + 1: self.in_layer(number, goal_m) for number, goal_m in enumerate(goals_m)}
        for _ in range(MOVES_PER_GOAL):
            movable = tuple(
                request(number + 1, tuple(place_m), tuple(place_m)) for number, place_m in enumerate(self.places_m)
            )
            situation = TrafficSituation(limits=self.limits, arrival_radius_m=0.5, movable=movable)
            records = vet_plan(planned, situation, situation.detours(), self.ground, self.surface)
            moved_m = 0.0
            for record in records:
                before_m = self.places_m[record.vehicle_id - 1]
                self.flown.append((before_m, record))
                if record.sent_enu_m is not None:
                    self.places_m[record.vehicle_id - 1] = np.array(record.sent_enu_m)
                    moved_m = max(moved_m, math.dist(before_m, record.sent_enu_m))
            if moved_m < 0.1 or all(record.verdict is WaypointVerdict.SENT for record in records):
                return


def fly(plan: RandomPlan) -> None:
    """Fly a plan and check all that was sent, and the reasons for what was not."""
    ground = raster(plan.heights_m)
    swarm = Swarm(plan, ground)
    for leg in plan.legs:
        horizontal_m = np.array(swarm.places_m)[:, :2]
        line_m = leg_formation(leg, horizontal_m, plan.spacing_m)
        swarm.fly_to(line_m)
        swarm.fly_to(line_m + leg.length_m * np.array(leg.direction_enu))
    for before_m, record in swarm.flown:
        if record.sent_enu_m is not None and not np.array_equal(before_m, record.sent_enu_m):
            check_heights(ground, before_m, np.array(record.sent_enu_m))
        if record.verdict is not WaypointVerdict.SENT and "ground" in record.reason:
            assert record.reason.startswith("along the ground, by ") or WHERE.search(record.reason), record.reason
            assert record.reason.startswith("along the ground, by ") or HOW_MUCH.search(record.reason), record.reason


def check_heights(ground: GroundRaster, start_m: FloatArray, end_m: FloatArray) -> None:
    """Check a segment at places of its own, not at those that the vetting looks at."""
    along = np.linspace(0.0, 1.0, 400)[:, None]
    path_m = start_m + along * (end_m - start_m)
    lowest_m, highest_m = ground.bounds_at(path_m[:, :2])
    known = np.isfinite(highest_m)
    if known[0]:
        assert known.all(), "it does not enter ground that is not known"
    least_m, most_m = path_m[:, 2] - highest_m, path_m[:, 2] - lowest_m
    first = int(np.argmax(known))
    if known.any():
        assert least_m[known].min() >= min(FLOOR_M, least_m[first]) - 1e-3
        assert most_m[known].max() <= max(CEILING_M, most_m[first]) + 1e-3


@settings(max_examples=20, deadline=None)
@given(plan=plans())
def test_no_segment_of_a_plan_meets_the_floor(plan: RandomPlan) -> None:
    fly(plan)


@pytest.mark.slow
@pytest.mark.timeout(900)
@settings(max_examples=1000, deadline=None)
@given(plan=plans())
def test_no_segment_of_a_thousand_plans_meets_the_floor(plan: RandomPlan) -> None:
    fly(plan)
