"""Searches planned for a probability of detection: what views their legs give, and what is proposed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geometry.projection import Plane
from aos_gcs.groundmap.directions import ViewDirections
from aos_gcs.groundmap.figures import DetectionFigures
from aos_gcs.groundmap.ground_map import open_map
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.planning.checks.advice import propose
from aos_gcs.planning.checks.check import check_plan
from aos_gcs.planning.detection.expected_views import LineOfCameras, expected_views, line_of, predicted_detection
from aos_gcs.planning.detection.pod_proposal import propose_pattern
from aos_gcs.planning.estimate import estimate_plan, planned_legs
from aos_gcs.planning.legs import ScanLeg, leg_formation, line_on
from aos_gcs.planning.plan import MissionPlan, apply_plan, plan_of
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_gcs.planning.settings import ForestSettings, MissionSettings

SQUARE = ((-60.0, 0.0), (60.0, 0.0), (60.0, 120.0), (-60.0, 120.0))
FOREST = ForestSettings(canopy_height_m=18.0, crown_base_m=4.4, occlusion=0.84)
PLAN = MissionPlan(vehicles=3, area_enu_m=SQUARE, layer_spacing_m=3.0, forest=FOREST, pod=0.9)
SETTINGS = MissionSettings(vehicles=3, area_enu_m=SQUARE, imaging=ImagingSettings())


def test_expected_views_are_those_that_the_map_of_searched_ground_counts(tmp_path: Path) -> None:
    directions = ViewDirections(0.06)
    line = LineOfCameras(np.array([-4.0, 5.0]), np.array([30.0, 33.0]), math.tan(math.radians(15.0)), 3.0)
    leg = ScanLeg((3.0, -8.0), (0.0, 1.0), 12.0)
    ground = open_map(tmp_path, GeodeticPosition(48.0, 14.0, 0.0), directions.step)
    camera = CameraModel.from_fov(64, 64, math.radians(30.0))
    image = np.zeros((64, 64, 1), np.float32)
    for aside_m, height_m in zip(line.aside_m, line.heights_m, strict=True):
        for along_m in np.arange(0.0, 12.1, 3.0):
            pose = nadir_pose((3.0 - aside_m, -8.0 + along_m, height_m))
            ground.add(Frame(1, image, ("thermal",), pose, camera), Plane(0.0))
    # Well inside of each footprint or outside: at its edge the map counts a cell that is seen by half.
    rows, columns = np.mgrid[-20:20:2, -16:16:2]
    places_m = np.column_stack((columns.ravel() + 0.5, -rows.ravel() - 0.5))
    counted = [
        int(ground.views[index][row % 32, column % 32]) if (index := (row // 32, column // 32)) in ground.views else 0
        for row, column in zip(rows.ravel(), columns.ravel(), strict=True)
    ]
    expected = expected_views(places_m, [leg], line, directions)
    assert np.count_nonzero(expected) > 100
    assert np.mean(expected == counted) > 0.8
    assert abs(float(np.mean(expected) - np.mean(counted))) < 0.15


def test_nothing_is_expected_of_places_that_no_camera_looks_at_or_may_look_from() -> None:
    line = LineOfCameras(np.zeros(1), np.array([35.0]), 0.4, 2.5)
    leg, directions = ScanLeg((0.0, 0.0), (0.0, 1.0), 50.0), ViewDirections(1.0 / 32.0)
    places_m = np.array([[0.0, 25.0], [30.0, 25.0]])
    seen, beside = expected_views(places_m, [leg], line, directions)
    assert seen > 5
    assert beside == 0
    zone = ((-5.0, -5.0), (5.0, -5.0), (5.0, 55.0), (-5.0, 55.0))
    assert expected_views(places_m, [leg], line, directions, [zone]).tolist() == [0, 0]


def test_the_proposed_search_reaches_what_is_wanted_faster_than_the_line_of_close_looks() -> None:
    pattern = propose_pattern(PLAN, 0.0)
    assert pattern is not None
    planned = estimate_plan(pattern.applied_to(PLAN), 0.0)
    assert planned.detection is not None
    assert planned.detection.standing == pytest.approx(0.9, abs=0.03)
    assert planned.detection.standing < planned.detection.sitting < planned.detection.lying
    assert len(planned.legs) == pattern.legs
    narrow = estimate_plan(replace(PLAN, search_speed_mps=pattern.search_speed_mps), 0.0)
    assert planned.flight_s == pytest.approx(pattern.flight_s)
    assert narrow.detection is not None
    assert narrow.flight_s > planned.flight_s


def test_no_greater_speed_reaches_what_is_wanted() -> None:
    pattern = propose_pattern(PLAN, 0.0)
    assert pattern is not None
    slow, fast = (
        replace(pattern.applied_to(PLAN), search_speed_mps=pattern.search_speed_mps + more_mps) for more_mps in (0, 0.1)
    )
    reached = [predicted_detection(plan, planned_legs(plan, 0.0), 0.0, 600) for plan in (slow, fast)]
    standing = [one.standing for one in reached if one is not None]
    # What is wanted, with 3 % more coverage, as the law is not known better, and a margin for views at few places.
    assert standing[0] >= 1.0 - 0.1**1.03 + 0.005 > standing[1]


def test_two_passes_reach_what_is_wanted_at_a_greater_speed() -> None:
    lone = replace(PLAN, vehicles=1, pod=0.8)
    one, two = propose_pattern(lone, 0.0), propose_pattern(replace(lone, passes=2), 0.0)
    assert one is not None
    assert two is not None
    assert two.search_speed_mps > 1.5 * one.search_speed_mps
    assert two.flight_s < 1.3 * one.flight_s
    assert len(estimate_plan(two.applied_to(replace(lone, passes=2)), 0.0).legs) == two.legs


def test_where_one_pass_does_not_suffice_legs_overlap() -> None:
    dense = replace(PLAN, vehicles=1, forest=replace(FOREST, occlusion=0.97), pod=0.8)
    pattern = propose_pattern(dense, 0.0)
    assert pattern is not None
    assert pattern.leg_spacing_m < 20.0  # a camera sees 33 m
    assert pattern.detection >= 0.8


def test_what_cannot_be_reached_is_known_from_the_most_legs_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    predicted: list[int] = []

    def counting(plan: MissionPlan, legs: Sequence[ScanLeg], *arguments: Any) -> DetectionFigures | None:
        predicted.append(len(legs))
        return predicted_detection(plan, legs, *arguments)

    monkeypatch.setattr("aos_gcs.planning.detection.pod_proposal.predicted_detection", counting)
    assert propose_pattern(replace(PLAN, vehicles=1, forest=replace(FOREST, occlusion=0.99), pod=0.95), 0.0) is None
    fewest, most = predicted
    assert fewest < 10
    assert most > 90


def test_a_proposal_ends_with_what_may_be_counted_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    lone = replace(PLAN, vehicles=1, pod=0.8)
    whole = propose_pattern(lone, 0.0)
    assert whole is not None
    monkeypatch.setattr("aos_gcs.planning.detection.pod_proposal._MOST_OF_A_PATTERN", 200_000)
    assert propose_pattern(lone, 0.0) == whole, "legs that are too many to be counted are not needed"
    monkeypatch.setattr("aos_gcs.planning.detection.pod_proposal._MOST_OF_A_PATTERN", 1)
    assert propose_pattern(lone, 0.0) is None


@pytest.mark.parametrize(
    "changes", [{"pod": None}, {"forest": None}, {"search_mode": SearchMode.STOPS}, {"cruise_speed_mps": 0.2}]
)
def test_nothing_is_proposed_where_nothing_is_wanted_or_known(changes: dict[str, object]) -> None:
    plan = replace(PLAN, **changes)  # type: ignore[arg-type]
    if "cruise_speed_mps" in changes:
        assert propose_pattern(plan, 0.0) is not None  # slow, but it reaches it
        return
    assert propose_pattern(plan, 0.0) is None


def test_what_is_proposed_is_not_proposed_again_once_taken() -> None:
    plan = PLAN
    names = {"line_spacing_m", "leg_spacing_m", "search_speed_mps"}
    offered = {one.field: one for one in propose(plan, 0.0) if one.field in names}
    assert set(offered) == names
    assert all("90%" in one.reason for one in offered.values())
    taken = replace(plan, **{name: round(one.value, 1) for name, one in offered.items()})  # type: ignore[arg-type]
    assert not names & {one.field for one in propose(taken, 0.0)}
    assert "pod" not in {problem.field for problem in check_plan(taken, SETTINGS)}


def test_more_frames_are_proposed_where_they_make_the_flight_faster() -> None:
    (offered,) = [one for one in propose(PLAN, 0.0) if one.field == "rate_hz"]
    assert offered.value == 3.0
    slow, fast = propose_pattern(PLAN, 0.0), propose_pattern(replace(PLAN, rate_hz=offered.value), 0.0)
    assert slow is not None
    assert fast is not None
    assert fast.search_speed_mps == pytest.approx(1.5 * slow.search_speed_mps, abs=0.3)
    assert fast.flight_s < 0.95 * slow.flight_s
    for quick in (replace(PLAN, rate_hz=3.0), replace(PLAN, pod=0.1), replace(PLAN, pod=None)):
        assert "rate_hz" not in {one.field for one in propose(quick, 0.0)}


@pytest.mark.parametrize(
    ("changes", "field", "words", "blocks"),
    [
        ({"search_speed_mps": 10.0}, "pod", "90% are wanted", False),
        ({"forest": None}, "pod", "Describe the forest", False),
        ({"search_mode": SearchMode.STOPS}, "pod", "in flight only", False),
        ({"pod": 1.0}, "pod", "between 5% and 99%", True),
        ({"line_spacing_m": 0.0}, "line_spacing_m", "above 0", True),
        ({"leg_spacing_m": 2000.0}, "leg_spacing_m", "1000 or less", True),
        ({"passes": 4}, "passes", "1 to 3 times", True),
    ],
)
def test_plans_that_miss_what_is_wanted_are_told(
    changes: dict[str, object], field: str, words: str, *, blocks: bool
) -> None:
    problems = check_plan(replace(PLAN, vehicles=1, **changes), SETTINGS)  # type: ignore[arg-type]
    (problem,) = [one for one in problems if one.field == field]
    assert words in problem.text
    assert problem.blocking is blocks


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"pod": 1.5}, "pod must lie"),
        ({"line_spacing_m": -1.0}, "line_spacing_m must"),
        ({"leg_spacing_m": 0.0}, "leg"),
        ({"passes": 0}, "passes must lie"),
    ],
)
def test_settings_of_a_search_out_of_range_are_refused(values: dict[str, float], words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        SearchSettings(**values)  # type: ignore[arg-type]


def test_the_spacings_go_from_the_plan_to_the_settings_and_back() -> None:
    plan = replace(PLAN, line_spacing_m=12.0, leg_spacing_m=36.0, passes=2, split=True)
    settings = apply_plan(SETTINGS, plan)
    assert settings.search == SearchSettings(pod=0.9, line_spacing_m=12.0, leg_spacing_m=36.0, passes=2, split=True)
    assert plan_of(settings).leg_spacing_m == 36.0
    assert plan_of(settings).passes == 2
    assert plan_of(settings).split
    assert len(planned_legs(plan, 0.0)) == 4
    assert line_of(plan, 0.0).aside_m.tolist() == [-12.0, 0.0, 12.0]


def test_a_line_keeps_the_middle_of_the_places_along_its_leg() -> None:
    leg = ScanLeg((10.0, 0.0), (0.0, 1.0), 100.0)
    places_m = np.array([[14.0, 22.0], [6.0, 18.0]])
    np.testing.assert_allclose(line_on(leg, places_m, 30.0), [[25.0, 20.0], [-5.0, 20.0]])
    assert leg_formation(leg, places_m, 30.0)[0, 0] == 25.0
