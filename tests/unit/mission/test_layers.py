"""Takeoff, the flights to the line and home, and landing: no two planned paths meet, whatever the launch points."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs.airspace.limits import MIN_LAUNCH_DISTANCE_M, SafetyLimits
from aos_gcs.airspace.separation import segment_distance
from aos_gcs.airspace.traffic import WaypointRequest
from aos_gcs.airspace.vetting import vet_waypoints
from aos_gcs.airspace.waypoints import WaypointVerdict
from aos_gcs.planning.legs import ScanLeg, leg_formation
from aos_gcs.planning.proposal import altitude_layers, propose_fence
from aos_gcs.planning.settings import FlightSettings

FloatArray = NDArray[np.float64]
FLIGHT = FlightSettings()
AREA_ENU_M = ((-60.0, 30.0), (60.0, 30.0), (60.0, 150.0), (-60.0, 150.0))


@st.composite
def launch_points(draw: st.DrawFn) -> FloatArray:
    """Draw up to twelve points on a slope that preflight would let start, in the order of the vehicles' ids."""
    count = draw(st.integers(2, 12))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    width_m = draw(st.floats(8.0, 40.0))
    points: list[FloatArray] = []
    while len(points) < count:
        east_m, north_m = rng.uniform(-width_m, width_m, 2)
        point = np.array([east_m, north_m, 0.1 * east_m])
        if all(np.hypot(*(point - other)[:2]) >= MIN_LAUNCH_DISTANCE_M for other in points):
            points.append(point)
    return np.array(points)


def layers_above(homes_enu_m: FloatArray) -> FloatArray:
    heights_m = altitude_layers(len(homes_enu_m), FLIGHT.lowest_layer_m, FLIGHT.layer_spacing_m)
    return np.column_stack([homes_enu_m[:, :2], heights_m])


def limits_of(homes_enu_m: FloatArray) -> SafetyLimits:
    return SafetyLimits(
        fence_enu_m=propose_fence(AREA_ENU_M, homes_enu_m[:, :2], 30.0),
        floor_m=FLIGHT.lowest_layer_m - 5.0,
        ceiling_m=FLIGHT.lowest_layer_m + FLIGHT.layer_spacing_m * len(homes_enu_m) + 5.0,
    )


def assert_apart(starts_m: FloatArray, ends_m: FloatArray, limits: SafetyLimits) -> None:
    """Compare whole paths with one another, at any speeds."""
    for one, other in combinations(range(len(starts_m)), 2):
        gap_m = segment_distance(starts_m[one], ends_m[one], starts_m[other], ends_m[other])
        assert gap_m >= limits.separation_m


def assert_granted(starts_m: FloatArray, ends_m: FloatArray, limits: SafetyLimits) -> None:
    movers = [
        WaypointRequest(
            vehicle_id=row + 1,
            position_enu_m=start_m,
            requested_enu_m=end_m,
            link_age_s=0.1,
            position_age_s=0.1,
            battery_fraction=0.9,
        )
        for row, (start_m, end_m) in enumerate(zip(starts_m, ends_m, strict=True))
    ]
    assert {record.verdict for record in vet_waypoints(movers, [], limits)} == {WaypointVerdict.SENT}


@settings(max_examples=30, deadline=None)
@given(launch_points())
def test_all_climb_and_land_at_the_same_time(homes_enu_m: FloatArray) -> None:
    assert_apart(homes_enu_m, layers_above(homes_enu_m), limits_of(homes_enu_m))


@settings(max_examples=30, deadline=None)
@given(launch_points(), st.floats(3.0, 12.0), st.floats(0.0, 6.28))
def test_the_paths_to_the_line_and_home_are_flown_whole(
    homes_enu_m: FloatArray, spacing_m: float, heading_rad: float
) -> None:
    above_enu_m, limits = layers_above(homes_enu_m), limits_of(homes_enu_m)
    leg = ScanLeg((0.0, 90.0), (float(np.sin(heading_rad)), float(np.cos(heading_rad))), 50.0)
    line_m = leg_formation(leg, above_enu_m[:, :2], min(spacing_m, 110.0 / len(homes_enu_m)))
    line_enu_m = np.column_stack([line_m, above_enu_m[:, 2]])
    for starts_m, ends_m in ((above_enu_m, line_enu_m), (line_enu_m, above_enu_m)):
        assert_apart(starts_m, ends_m, limits)
        assert_granted(starts_m, ends_m, limits)
