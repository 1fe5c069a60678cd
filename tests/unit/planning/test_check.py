"""Plans: what is wrong with them, what they take, what would be better."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.airspace.accuracy import needed_spacing_m
from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.airspace.raster import PlanRaster
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.planning.checks.advice import propose
from aos_gcs.planning.checks.check import check_plan
from aos_gcs.planning.detection import expected_views
from aos_gcs.planning.estimate import PlanEstimate, estimate_plan, scan_step_m
from aos_gcs.planning.plan import MissionPlan, apply_plan, plan_of
from aos_gcs.planning.search_settings import SearchMode
from aos_gcs.planning.settings import ForestSettings, MissionSettings

SQUARE = ((-50.0, 0.0), (50.0, 0.0), (50.0, 100.0), (-50.0, 100.0))
PLAN = MissionPlan(vehicles=5, area_enu_m=SQUARE, layer_spacing_m=3.0, search_mode=SearchMode.STOPS)
SETTINGS = MissionSettings(vehicles=5, area_enu_m=SQUARE, imaging=ImagingSettings())
FOREST = ForestSettings(canopy_height_m=25.0, crown_base_m=5.0)
WIDE = ((-70.0, -20.0), (70.0, -20.0), (70.0, 120.0), (-70.0, 120.0))
WALL = ((-80.0, -10.0), (80.0, -10.0), (80.0, -5.0), (-80.0, -5.0))
"""Zone from one side of the wide fence to the other, south of the square."""
WALLED = {"no_go_enu_m": (WALL,), "fence_enu_m": WIDE, "fence_margin_m": 0.0}


def circle(radius_m: float, count: int) -> tuple[tuple[float, float], ...]:
    angles_rad = [math.tau * index / count for index in range(count)]
    return tuple((radius_m * math.cos(angle), 50.0 + radius_m * math.sin(angle)) for angle in angles_rad)


def blocking(plan: MissionPlan) -> dict[str, str]:
    return {problem.field: problem.text for problem in check_plan(plan, SETTINGS) if problem.blocking}


def test_a_good_plan_has_no_problem() -> None:
    assert check_plan(PLAN, SETTINGS) == []


@pytest.mark.parametrize(
    ("changes", "field", "words"),
    [
        ({"area_enu_m": ()}, "area_enu_m", "empty"),
        ({"area_enu_m": ((0.0, 0.0), (9.0, 9.0), (9.0, 0.0), (0.0, 9.0))}, "area_enu_m", "cross"),
        ({"area_enu_m": ((0.0, 0.0), (9e5, 0.0), (0.0, 9e5))}, "area_enu_m", "from the origin"),
        ({"area_enu_m": tuple((math.cos(i), math.sin(i)) for i in range(501))}, "area_enu_m", "500 or fewer"),
        ({"no_go_enu_m": (SQUARE[:2],)}, "no_go_enu_m[0]", "three or more points"),
        ({"no_go_enu_m": (SQUARE,)}, "no_go_enu_m", "nothing is left"),
        ({"fence_enu_m": ((-40.0, -10.0), (60.0, -10.0), (60.0, 110.0), (-40.0, 110.0))}, "area_enu_m", "geofence"),
        ({"launch_enu_m": (0.0, 50.0), "no_go_enu_m": (((-5, 45), (5, 45), (5, 55), (-5, 55)),)}, "launch_enu_m", "1"),
        ({"fence_enu_m": SQUARE, "return_enu_m": (0.0, -9.0)}, "return_enu_m", "outside of the geofence"),
        ({"launch_enu_m": (math.nan, 0.0)}, "launch_enu_m", "move it"),
        ({"launch_enu_m": (0.0, 4.5e6)}, "launch_enu_m", "swapped"),
        ({"no_go_enu_m": tuple(circle(20.0, 101) for _ in range(2))}, "no_go_enu_m", "200 in all"),
        ({"area_enu_m": circle(4900.0, 9), "vehicles": 2}, "area_enu_m", "legs, 100 are allowed"),
        ({"fence_margin_m": 5.0, "fence_enu_m": WIDE, "launch_enu_m": (0.0, -16.0)}, "launch_enu_m", "4.0 m from"),
        ({**WALLED, "launch_enu_m": (0.0, -15.0)}, "launch_enu_m", "cut off"),
        ({**WALLED, "return_enu_m": (0.0, -15.0)}, "return_enu_m", "cut off"),
        ({"vehicles": 0}, "vehicles", "1 to 250"),
        ({"layer_spacing_m": 1.0}, "layer_spacing_m", "too close"),
        ({"layer_spacing_m": math.nan}, "layer_spacing_m", "above 0"),
        ({"layer_spacing_m": 1e300}, "layer_spacing_m", "100 or less"),
        ({"layer_spacing_m": 99.0, "vehicles": 12}, "layer_spacing_m", "The highest layer is at 1124 m"),
        ({"lowest_layer_m": 1e300}, "lowest_layer_m", "1000 or less"),
        ({"cruise_speed_mps": 1e-300}, "cruise_speed_mps", "0.1 or more"),
        ({"cruise_speed_mps": 1e300}, "cruise_speed_mps", "50 or less"),
        ({"search_speed_mps": 0.0}, "search_speed_mps", "above 0"),
        ({"search_speed_mps": 1e-9}, "search_speed_mps", "0.1 or more"),
        ({"search_speed_mps": 60.0}, "search_speed_mps", "50 or less"),
        ({"rate_hz": 0.0}, "rate_hz", "above 0"),
        ({"rate_hz": 11.0}, "rate_hz", "10 or less"),
        ({"ceiling_m": 1e300}, "ceiling_m", "within 1000 m"),
        ({"floor_m": -1e300}, "floor_m", "within 1000 m"),
        ({"search_s": 1e300}, "search_s", "86400 or less"),
        ({"fence_margin_m": 1e300}, "fence_margin_m", "5000 or less"),
        ({"ceiling_m": 40.0}, "ceiling_m", "47 m"),
        ({"floor_m": 36.0}, "floor_m", "above the lowest layer"),
        ({"lowest_layer_m": 20.0, "forest": FOREST}, "lowest_layer_m", "tree tops"),
        ({"lowest_layer_m": -1.0}, "lowest_layer_m", "above"),
        ({"lowest_layer_m": 1.0}, "lowest_layer_m", "5 or more"),
        ({"forest": replace(FOREST, crown_base_m=30.0)}, "forest", "crown_base_m"),
        ({"strategy": "magic"}, "strategy", "magic"),
        ({"strategy_parameters": {"gamma": 7.0}}, "strategy_parameters.gamma", "below 1"),
        ({"strategy_parameters": {"gama": 0.7}}, "strategy_parameters.gama", "has no parameter"),
        ({"strategy_parameters": {"min_factor": 0.55}}, "strategy_parameters.initial_c_s_hat", "between"),
        ({"strategy": "aos-pso", "spacing_m": 2.0}, "strategy_parameters.c_s_m", "at most c4_m"),
        ({"search_s": 0.0}, "search_s", "above 0"),
        ({"spacing_m": 0.0}, "spacing_m", "above 0"),
        ({"cruise_speed_mps": 0.0}, "cruise_speed_mps", "above 0"),
        ({"min_battery_fraction": 0.95}, "min_battery_fraction", "reserve"),
        ({"fence_margin_m": -1.0}, "fence_margin_m", "negative"),
        ({"camera_fov_rad": 3.1}, "camera_fov_rad", "field of view"),
    ],
)
def test_every_problem_names_its_field(changes: dict[str, object], field: str, words: str) -> None:
    found = blocking(replace(PLAN, **changes))  # type: ignore[arg-type]
    assert words in found[field]


def test_vehicles_that_stand_where_they_must_not_are_named() -> None:
    pond = replace(PLAN, no_go_enu_m=(((-5.0, -30.0), (5.0, -30.0), (5.0, -20.0), (-5.0, -20.0)),))
    homes = {3: (0.0, -25.0), 1: (2.0, -25.0), 2: (20.0, -25.0)}
    (problem,) = check_plan(pond, SETTINGS, homes)
    assert problem.field == "launch_enu_m"
    assert problem.text == "Vehicles 1, 3 are inside of no-go zone 1; move one of them."
    assert not problem.blocking


def test_a_wall_that_can_be_flown_around_bars_nothing() -> None:
    wall = ((-40.0, -10.0), (40.0, -10.0), (40.0, -5.0), (-40.0, -5.0))
    launch_enu_m, fence_margin_m = (0.0, -15.0), 0.0
    plan = replace(
        PLAN, no_go_enu_m=(wall,), fence_enu_m=WIDE, launch_enu_m=launch_enu_m, fence_margin_m=fence_margin_m
    )
    assert blocking(plan) == {}


def test_all_problems_are_reported_at_once() -> None:
    found = blocking(replace(PLAN, vehicles=0, strategy="magic", area_enu_m=()))
    assert {"vehicles", "strategy", "area_enu_m"} <= found.keys()


def test_a_plan_beyond_the_battery_can_be_flown_but_is_warned_of() -> None:
    (warning,) = check_plan(replace(PLAN, endurance_s=300.0), SETTINGS)
    assert (warning.field, warning.blocking) == ("endurance_s", False)


def test_a_single_vehicle_can_be_flown_and_it_is_said_how_it_looks_closer() -> None:
    (advice,) = check_plan(replace(PLAN, vehicles=1, search_mode=SearchMode.CONTINUOUS), SETTINGS)
    assert (advice.field, advice.blocking) == ("vehicles", False)
    assert "visiting places around what it has seen" in advice.text


@pytest.mark.parametrize(
    ("vehicles", "mode", "is_told"), [(7, "continuous", True), (8, "continuous", False), (7, "stops", False)]
)
def test_a_split_with_too_few_vehicles_is_told(vehicles: int, mode: str, *, is_told: bool) -> None:
    plan = replace(PLAN, vehicles=vehicles, search_mode=SearchMode(mode), split=True)
    advice = [problem for problem in check_plan(plan, SETTINGS) if problem.field == "split"]
    assert [(one.blocking, one.text) for one in advice] == is_told * [
        (False, "It takes 8 vehicles, 5 that look closely and 3 that scan on: with 7, all look closely.")
    ]


@pytest.mark.parametrize(
    ("spacing_m", "text"),
    [
        (2.0, "fail preflight: with a separation of 1.5 m they leave no room for gusts; 2.2 m and more do"),
        (2.5, "need heights known by RTK; without it, 3 m"),
    ],
)
def test_layers_that_preflight_would_refuse_are_warned_of_in_the_plan(spacing_m: float, text: str) -> None:
    (warning,) = check_plan(replace(PLAN, layer_spacing_m=spacing_m), SETTINGS)
    assert (warning.field, warning.blocking) == ("layer_spacing_m", False)
    assert text in warning.text
    joint_m = spacing_m - needed_spacing_m(SETTINGS.safety.applied_to(UNLIMITED).separation_m, 0.0)
    assert (joint_m < 0.0) == ("fail preflight" in warning.text), "as preflight reckons"


def test_heights_that_need_a_permission_are_warned_of() -> None:
    (warning,) = check_plan(replace(PLAN, vehicles=40), SETTINGS)
    assert (warning.field, warning.blocking) == ("ceiling_m", False)
    assert "152 m" in warning.text


def test_every_refused_parameter_is_reported() -> None:
    found = blocking(replace(PLAN, strategy_parameters={"gamma": 7.0, "c5": True}))
    assert found.keys() == {"strategy_parameters.gamma", "strategy_parameters.c5"}


def test_a_plan_beyond_the_time_for_searching_is_warned_of() -> None:
    (warning,) = check_plan(replace(PLAN, search_s=300.0), SETTINGS)
    assert (warning.field, warning.blocking) == ("search_s", False)


def test_an_area_may_touch_its_fence() -> None:
    assert blocking(replace(PLAN, fence_enu_m=SQUARE)) == {}


def test_a_margin_in_which_vehicles_do_not_stop_is_warned_of() -> None:
    (warning,) = check_plan(replace(PLAN, fence_margin_m=30.0), SETTINGS)
    assert (warning.field, warning.blocking) == ("fence_margin_m", False)
    assert "32.5 m, the stopping distance at 10 m/s: 10.0 m in 1 s of reaction, 20.0 m of braking" in warning.text
    assert check_plan(replace(PLAN, fence_margin_m=30.0, cruise_speed_mps=8.0, search_s=3000.0), SETTINGS) == []
    assert check_plan(replace(PLAN, fence_margin_m=32.5), SETTINGS) == []


def test_an_area_within_the_margin_of_its_fence_is_warned_of() -> None:
    (warning,) = check_plan(replace(PLAN, fence_enu_m=WIDE), SETTINGS)
    assert (warning.field, warning.blocking) == ("fence_enu_m", False)
    assert "within 20 m of the geofence, whose margin is 32.5 m" in warning.text


def test_a_launch_point_in_the_margin_of_the_fence_is_refused() -> None:
    found = blocking(replace(PLAN, fence_enu_m=WIDE, launch_enu_m=(0.0, -15.0)))
    assert "5.0 m from the geofence, within the margin of 32.5 m" in found["launch_enu_m"]


def test_no_go_zones_are_kept_as_drawn_unless_a_margin_is_set() -> None:
    pond = replace(PLAN, no_go_enu_m=(((-5.0, -30.0), (5.0, -30.0), (5.0, -20.0), (-5.0, -20.0)),))
    beside = replace(pond, launch_enu_m=(10.0, -25.0))
    assert blocking(beside) == {}
    assert "within the margin of 40 m" in blocking(replace(beside, fence_margin_m=40.0))["launch_enu_m"]


def test_the_estimate_adds_up() -> None:
    estimate = estimate_plan(PLAN, 0.0)
    assert estimate.area_m2 == pytest.approx(1e4, rel=0.01)
    assert estimate.covered_fraction == pytest.approx(1.0, abs=0.01)
    # A swath of 4 x 4.2 m and one footprint of 32.6 m covers 100 m in three legs.
    assert len(estimate.legs) == 3
    assert estimate.path_m >= 300.0
    steps = 300.0 / scan_step_m(PLAN)
    assert estimate.scan_s / steps == pytest.approx(3.0, abs=0.2)  # as in recorded missions
    assert estimate.scan_s < estimate.flight_s == pytest.approx(1500.0 * estimate.battery_fraction)


def test_without_stops_legs_take_as_long_as_their_flight() -> None:
    swept = estimate_plan(replace(PLAN, search_mode=SearchMode.CONTINUOUS), 0.0)
    # Three legs of 100 m at 5 m/s, each with 2 s to speed up and slow down, and a step at rest.
    assert swept.scan_s == pytest.approx(3 * (20.0 + 2.0 + 1.2))
    stops = estimate_plan(PLAN, 0.0)
    assert stops.scan_s > 4.0 * swept.scan_s
    assert swept.hectares_per_hour == pytest.approx(3600.0 * swept.area_m2 / 1e4 / swept.flight_s, rel=0.01)
    slow = estimate_plan(replace(PLAN, search_mode=SearchMode.CONTINUOUS, cruise_speed_mps=2.5), 0.0)
    assert slow.scan_s == pytest.approx(3 * (40.0 + 1.0 + 1.2))


@pytest.mark.parametrize(
    ("speed_mps", "rate_hz", "proposed_mps"), [(5.0, 2.0, None), (10.0, 2.0, 8.4), (5.0, 1.0, 4.2)]
)
def test_frames_that_are_farther_apart_than_the_vehicles_are_advised_against(
    speed_mps: float, rate_hz: float, proposed_mps: float | None
) -> None:
    plan = replace(PLAN, search_mode=SearchMode.CONTINUOUS, search_speed_mps=speed_mps, rate_hz=rate_hz)
    found = {one.field: one.value for one in propose(plan, 0.0)}
    assert found.get("search_speed_mps") == (None if proposed_mps is None else pytest.approx(proposed_mps))
    assert "search_speed_mps" not in {one.field for one in propose(replace(plan, search_mode=SearchMode.STOPS), 0.0)}


def test_no_go_zones_are_not_covered() -> None:
    half = ((-50.0, 0.0), (0.0, 0.0), (0.0, 100.0), (-50.0, 100.0))
    estimate = estimate_plan(replace(PLAN, no_go_enu_m=(half,)), 0.0)
    assert estimate.free_area_m2 == pytest.approx(5e3, rel=0.02)
    assert estimate.covered_fraction == pytest.approx(0.5, abs=0.02)


@given(st.floats(0.5, 3.0), st.floats(0.5, 3.0), st.floats(0.0, math.tau))
def test_a_raster_knows_the_area_of_a_turned_rectangle(width: float, height: float, angle_rad: float) -> None:
    east, north = math.cos(angle_rad), math.sin(angle_rad)
    corners = [(-width, -height), (width, -height), (width, height), (-width, height)]
    polygon = tuple((x * east - y * north, x * north + y * east) for x, y in corners)
    raster = PlanRaster.around(polygon)
    assert raster.area_m2(raster.inside([polygon])) == pytest.approx(4.0 * width * height, rel=0.03)


def test_a_long_area_is_better_searched_along() -> None:
    long = ((-150.0, 0.0), (150.0, 0.0), (150.0, 45.0), (-150.0, 45.0))
    (proposal,) = propose(replace(PLAN, area_enu_m=long), 0.0)
    assert proposal.field == "scan_heading_rad"
    assert math.degrees(proposal.value) == pytest.approx(90.0, abs=10.0)
    assert ": 1 leg, " in proposal.reason


@pytest.mark.parametrize("area_enu_m", [SQUARE, circle(40.0, 5), ((0.0, 0.0), (160.0, 20.0), (30.0, 90.0))])
@pytest.mark.parametrize("return_enu_m", [None, (120.0, 40.0)])
def test_another_heading_is_proposed_only_where_the_estimate_says_that_it_is_faster(
    area_enu_m: tuple[tuple[float, float], ...], return_enu_m: tuple[float, float] | None
) -> None:
    # Legs are flown at a tenth of the speed of transfers: a shorter path may take longer.
    for heading_deg in (0.0, 35.0, 90.0, 140.0):
        plan = replace(
            PLAN, area_enu_m=area_enu_m, return_enu_m=return_enu_m, scan_heading_rad=math.radians(heading_deg)
        )
        present_s = estimate_plan(plan, 0.0).flight_s
        for proposal in propose(plan, 0.0):
            turned = replace(plan, scan_heading_rad=proposal.value)
            estimate = estimate_plan(turned, 0.0)
            assert estimate.flight_s < present_s
            # Told in the figures and the form of the estimate.
            minutes, seconds = divmod(int(estimate.flight_s), 60)
            assert f"{minutes:02}:{seconds:02}, {100 * estimate.battery_fraction:.0f} % of" in proposal.reason
            assert propose(turned, 0.0) == ()


def test_a_forest_asks_for_spacing_and_number() -> None:
    found = {proposal.field: proposal for proposal in propose(replace(PLAN, forest=FOREST), 0.0)}
    assert found["vehicles"].value == 10
    assert "occluders" in found["spacing_m"].reason
    better = replace(PLAN, forest=FOREST, vehicles=10, spacing_m=found["spacing_m"].value)
    assert "vehicles" not in {proposal.field for proposal in propose(better, 0.0)}


def test_settings_and_plan_go_to_and_fro() -> None:
    plan = replace(
        PLAN,
        no_go_enu_m=(((1.0, 1.0), (2.0, 1.0), (2.0, 2.0)),),
        return_enu_m=(3.0, -4.0),
        scan_heading_rad=1.0,
        ceiling_m=60.0,
        min_battery_fraction=0.3,
        cruise_speed_mps=7.0,
        spacing_m=5.0,
        search_s=700.0,
        strategy_parameters={"gamma": 0.8},
        forest=FOREST,
    )
    again = plan_of(apply_plan(SETTINGS, plan))
    assert again.scan_heading_rad == pytest.approx(1.0)
    assert replace(again, scan_heading_rad=1.0) == plan


def test_the_spacing_becomes_the_parameter_of_the_strategy() -> None:
    assert apply_plan(SETTINGS, replace(PLAN, spacing_m=5.0)).strategy_parameters == {"c4_m": 5.0}


def test_a_plan_that_leaves_the_fence_open_takes_back_an_earlier_one() -> None:
    fenced = apply_plan(SETTINGS, replace(PLAN, fence_enu_m=SQUARE, ceiling_m=60.0))
    again = apply_plan(fenced, PLAN).safety
    assert (again.fence_enu_m, again.ceiling_m) == (None, None)


def counted_exposures(plan: MissionPlan, monkeypatch: pytest.MonkeyPatch) -> int:
    counted = [0]
    counting = expected_views._exposures

    def exposures(*arguments: Any) -> Iterator[Any]:
        for places, cameras_m in counting(*arguments):
            counted[0] += len(places)
            yield places, cameras_m

    with monkeypatch.context() as patched:
        patched.setattr(expected_views, "_exposures", exposures)
        estimate_plan(plan, 0.0)
    return counted[0]


@pytest.mark.parametrize("changes", [{}, {"search_speed_mps": 0.5}, {"vehicles": 20}, {"leg_spacing_m": 5.0}])
def test_the_exposures_of_a_plan_are_known_before_they_are_counted(
    changes: dict[str, object], monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = replace(PLAN, search_mode=SearchMode.CONTINUOUS, forest=FOREST, **changes)  # type: ignore[arg-type]
    legs = len(estimate_plan(plan, 0.0).legs)
    expected = expected_views.exposures_of_places(plan, 0.0, legs)
    assert 0.5 * expected < counted_exposures(plan, monkeypatch) < 1.1 * expected


def test_a_plan_with_more_exposures_than_can_be_counted_is_refused_before_they_are() -> None:
    slow = replace(PLAN, vehicles=100, search_speed_mps=0.1, rate_hz=10.0, forest=FOREST)
    for mode in SearchMode:
        found = blocking(replace(slow, search_mode=mode))
        assert "Frames of 100 vehicles are 0.01 m apart along the legs" in found["search_speed_mps"], mode
    assert "search_speed_mps" not in blocking(replace(slow, forest=None))
    many = replace(PLAN, vehicles=250, area_enu_m=circle(500.0, 9), layer_spacing_m=2.5, forest=FOREST)
    assert expected_views.exposures_of_places(many, 0.0, 2) < expected_views.MOST_EXPOSURES, "as many as can fly"


def test_a_check_without_memory_is_a_refusal_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    def exhausted(*_: object) -> PlanEstimate:
        raise MemoryError

    monkeypatch.setattr("aos_gcs.planning.checks.check.estimate_over_ground", exhausted)
    (problem,) = check_plan(PLAN, SETTINGS)
    assert problem.blocking
    assert "more memory than the station has" in problem.text
