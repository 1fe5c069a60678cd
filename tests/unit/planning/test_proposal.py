"""The limits of a flight: proposed around area, launch points and layers, unless they are set."""

import math
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.airspace.limits import MIN_LAUNCH_DISTANCE_M, UNLIMITED, SafetyLimits, SafetyOverrides
from aos_gcs.airspace.polygon import as_polygon, signed_depth_m
from aos_gcs.airspace.stopping import DECELERATION_MPS2, POSITION_ERROR_M, REACTION_S, StoppingDistance
from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.planning.proposal import FREE_GROUND_M, propose_fence, propose_limits
from aos_gcs.planning.settings import FlightSettings, MissionSettings

AREA_ENU_M = ((0.0, 40.0), (60.0, 40.0), (60.0, 100.0), (0.0, 100.0))
HOMES_ENU_M = [np.array([east_m, 0.0, 1.0]) for east_m in (0.0, 5.0, 10.0)]
PROPOSED = {"fence_enu_m", "floor_m", "ceiling_m", "margin_m", "no_go_margin_m"}
DEFAULTS = [entry.name for entry in fields(SafetyOverrides) if entry.name not in PROPOSED]


def limits_with(overrides: SafetyOverrides, return_enu_m: tuple[float, float] | None = None) -> SafetyLimits:
    settings = MissionSettings(
        vehicles=3,
        area_enu_m=AREA_ENU_M,
        imaging=ImagingSettings(),
        safety=overrides,
        return_enu_m=return_enu_m,
        flight=FlightSettings(lowest_layer_m=35.0, layer_spacing_m=2.0),
    )
    return propose_limits(settings, HOMES_ENU_M)


@pytest.mark.parametrize("name", DEFAULTS)
def test_writing_a_default_changes_nothing(name: str) -> None:
    written = limits_with(SafetyOverrides(**{name: getattr(UNLIMITED, name)}))
    left_out = limits_with(SafetyOverrides())
    assert written == left_out
    assert written.launch_distance_m == left_out.launch_distance_m


def test_launch_points_keep_two_metres_and_the_separation() -> None:
    assert limits_with(SafetyOverrides()).launch_distance_m == MIN_LAUNCH_DISTANCE_M
    assert limits_with(SafetyOverrides(separation_m=3.0)).launch_distance_m == 3.0


@pytest.mark.parametrize("margin_m", [None, 0.0, 12.0])
def test_area_launch_and_return_points_lie_within_the_fence_and_its_margin(margin_m: float | None) -> None:
    limits = limits_with(SafetyOverrides(margin_m=margin_m), return_enu_m=(-200.0, 0.0))
    fence_m = as_polygon(limits.fence_enu_m, "fence")
    for point_m in (*AREA_ENU_M, *(home_enu_m[:2] for home_enu_m in HOMES_ENU_M), (-200.0, 0.0)):
        assert signed_depth_m(np.array(point_m), fence_m) >= FREE_GROUND_M + limits.margin_m - 1e-6


def test_the_margin_is_the_stopping_distance_unless_it_is_set() -> None:
    limits = limits_with(SafetyOverrides())
    assert (limits.margin_m, limits.no_go_margin_m) == (StoppingDistance(10.0).total_m, POSITION_ERROR_M)
    assert limits_with(SafetyOverrides(margin_m=0.0)).margin_m == 0.0
    assert limits_with(SafetyOverrides(margin_m=2.0)).no_go_margin_m is None  # zones have the same


@given(st.floats(0.5, 50.0))
def test_a_vehicle_at_full_speed_that_is_held_at_the_margin_stops_inside_the_fence(speed_mps: float) -> None:
    margin_m, step_s = StoppingDistance(speed_mps).total_m, 0.01
    position_m, velocity_mps, time_s = POSITION_ERROR_M, speed_mps, 0.0
    while velocity_mps > 0.0:
        position_m += velocity_mps * step_s
        time_s += step_s
        if time_s > REACTION_S:
            velocity_mps -= DECELERATION_MPS2 * step_s
    assert position_m <= margin_m + speed_mps * 3.0 * step_s
    assert position_m >= 0.9 * margin_m - 1.0  # and the margin is not wider than that


def test_floor_and_ceiling_lie_around_the_layers() -> None:
    limits = limits_with(SafetyOverrides())
    assert (limits.floor_m, limits.ceiling_m) == (30.0, 44.0)


def test_what_is_set_holds() -> None:
    fence_enu_m = ((-50.0, -50.0), (150.0, -50.0), (50.0, 250.0))
    limits = limits_with(SafetyOverrides(fence_enu_m=fence_enu_m, ceiling_m=60.0, margin_m=2.0))
    assert (limits.fence_enu_m, limits.ceiling_m, limits.margin_m) == (fence_enu_m, 60.0, 2.0)
    assert limits.floor_m == 30.0


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"separation_m": 0.0}, "separation_m must be above 0"),
        ({"separation_m": 1.0}, "must lie within separation_m"),
        ({"ceiling_m": math.nan}, "ceiling_m must be a finite number"),
        ({"floor_m": 50.0, "ceiling_m": 40.0}, "must be below ceiling_m"),
        ({"fence_enu_m": ((0.0, 0.0), (1.0, 1.0))}, "fence_enu_m must have three or more points"),
    ],
)
def test_values_out_of_range_are_refused_when_they_are_set(wrong: dict[str, object], text: str) -> None:
    with pytest.raises(ConfigurationError, match=text):
        SafetyOverrides(**wrong)


def test_values_that_contradict_the_proposal_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="floor_m"):
        limits_with(SafetyOverrides(floor_m=50.0))


def test_a_launch_point_that_all_but_coincides_with_a_corner_of_the_area_is_no_problem() -> None:
    area_enu_m = ((0.0, 0.0), (30.0, 0.0), (30.0, 30.0), (0.0, 30.0))
    fence_enu_m = propose_fence(area_enu_m, [(1e-9, -2e-9)], 30.0)
    assert as_polygon(fence_enu_m, "fence").shape == (len(fence_enu_m), 2)
