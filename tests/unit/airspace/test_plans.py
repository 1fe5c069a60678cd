"""Ways in layers that follow the ground: no vetted piece meets the floor, and none the layer of another vehicle."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs.airspace.limits import GroundLimits, SafetyLimits
from aos_gcs.airspace.plans import TrafficSituation, vet_plan
from aos_gcs.airspace.reference_surface import ReferenceSurface, reference_surface
from aos_gcs.airspace.separation import segment_distance
from aos_gcs.airspace.traffic import Obstacle
from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict
from tests.fakes.waypoints import request
from tests.unit.airspace.test_reference_surface import BOUNDS, places, raster, reliefs, slopes

FloatArray = NDArray[np.float64]
FLOOR_M, LOWEST_M, SPACING_M, SEPARATION_M = 30.0, 35.0, 2.0, 1.5
FENCE = ((-100.0, -90.0), (100.0, -90.0), (100.0, 95.0), (-100.0, 95.0))
HIGH_M = 5000.0


def limits(**changes: object) -> SafetyLimits:
    return SafetyLimits(
        **{"fence_enu_m": FENCE, "floor_m": -HIGH_M, "ceiling_m": HIGH_M, "separation_m": SEPARATION_M, **changes}
    )


def in_layer(surface: ReferenceSurface, place_m: FloatArray, layer: int = 0) -> FloatArray:
    return np.array([*place_m, LOWEST_M + SPACING_M * layer + surface.at(place_m)])


def flown(
    starts_m: list[FloatArray], ends_m: list[FloatArray], surface: ReferenceSurface, **values: object
) -> tuple[WaypointRecord, ...]:
    """Return what becomes of ways between places in the layers of vehicles 1, 2, ..."""
    movable = [
        request(number + 1, in_layer(surface, start_m, number), in_layer(surface, start_m, number))
        for number, start_m in enumerate(starts_m)
    ]
    planned = {number + 1: in_layer(surface, end_m, number) for number, end_m in enumerate(ends_m)}
    ground = values.pop("ground", None)
    situation = TrafficSituation(limits=limits(**values), arrival_radius_m=0.5, movable=tuple(movable))
    return vet_plan(planned, situation, situation.detours(), ground, surface)


@given(heights_m=reliefs(), slope=slopes, start_m=places, end_m=places)
def test_no_vetted_piece_meets_the_floor(
    heights_m: FloatArray, slope: float, start_m: FloatArray, end_m: FloatArray
) -> None:
    ground = raster(heights_m)
    above = GroundLimits(floor_m=FLOOR_M, ceiling_m=HIGH_M, offsets_m=ground.offsets_m)
    surface = reference_surface(ground, BOUNDS, slope)
    (record,) = flown([start_m], [end_m], surface, above_ground=above, ground=ground)
    assume(record.sent_enu_m is not None)
    way_m = in_layer(surface, start_m), np.array(record.sent_enu_m)
    profile = ground.along(way_m[0][None], way_m[1][None])
    assert (profile.least_up_m - profile.highest_m)[profile.is_known].min(initial=np.inf) >= FLOOR_M - 1e-3
    assert profile.is_known.all() or not np.isfinite(ground.bounds_at(start_m[None])[1]).all()


@given(heights_m=reliefs(), slope=slopes, start_m=places, end_m=places)
def test_where_all_ground_is_known_every_way_gets_on_in_its_layer(
    heights_m: FloatArray, slope: float, start_m: FloatArray, end_m: FloatArray
) -> None:
    """The lowest layer leaves the room that straight pieces need: nothing holds a vehicle above its own ground."""
    ground = raster(np.nan_to_num(heights_m))
    above = GroundLimits(floor_m=FLOOR_M, ceiling_m=HIGH_M, offsets_m=ground.offsets_m)
    surface, place_m = reference_surface(ground, BOUNDS, slope), start_m
    for _ in range(400):
        (record,) = flown([place_m], [end_m], surface, above_ground=above, ground=ground)
        assert record.verdict is WaypointVerdict.SENT or record.reason.startswith("along the ground, by ")
        assert record.sent_enu_m is not None
        place_m = np.array(record.sent_enu_m[:2])
        assert record.sent_enu_m[2] == pytest.approx(LOWEST_M + surface.at(place_m))
        if record.verdict is WaypointVerdict.SENT:
            return
    raise AssertionError("it did not get there")


@given(
    heights_m=reliefs(),
    slope=st.sampled_from([0.05, 0.1, 0.2]),
    ends_m=st.lists(places, min_size=4, max_size=4),
    turn_rad=st.floats(0.0, 6.3),
)
def test_layers_stay_apart_wherever_two_vehicles_can_meet(
    heights_m: FloatArray, slope: float, ends_m: list[FloatArray], turn_rad: float
) -> None:
    surface = reference_surface(raster(heights_m), BOUNDS, slope)
    here_m, step_m = ends_m[0], np.array((np.cos(turn_rad), np.sin(turn_rad)))
    for beside_m in (0.0, 0.5, SEPARATION_M):
        apart_m = in_layer(surface, here_m + beside_m * step_m, 1) - in_layer(surface, here_m, 0)
        assert np.linalg.norm(apart_m) >= SEPARATION_M
    records = flown([ends_m[0], ends_m[2]], [ends_m[1], ends_m[3]], surface)
    segments = [
        (in_layer(surface, start_m, number), np.array(record.sent_enu_m))
        for number, (start_m, record) in enumerate(zip(ends_m[::2], records, strict=True))
        if record.sent_enu_m is not None
    ]
    if len(segments) == 2:
        assert segment_distance(*segments[0], *segments[1]) >= SEPARATION_M - 1e-6


def test_a_returning_vehicle_occupies_the_columns_and_the_way_at_the_height_of_its_return() -> None:
    obstacle = Obstacle(
        1,
        np.array((0.0, 0.0, 20.0)),
        column=True,
        bottom_m=-15.0,
        home_enu_m=np.array((100.0, 0.0, -10.0)),
        return_up_m=60.0,
    )
    corners = {tuple(corner) for segment in obstacle.segments().tolist() for corner in segment}
    assert corners == {(0.0, 0.0, -15.0), (0.0, 0.0, 60.0), (100.0, 0.0, 60.0), (100.0, 0.0, -15.0)}
    level = Obstacle(
        1, np.array((0.0, 0.0, 70.0)), column=True, home_enu_m=np.array((100.0, 0.0, 0.0)), return_up_m=60.0
    )
    assert math.isclose(float(level.segments()[..., 2].max()), 70.0), "autopilots do not descend before they are home"
