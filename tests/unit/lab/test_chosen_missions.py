"""Missions of the study along chosen legs: what is chosen, and what cannot be."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.lab.missions.model import MissionsSettings
from aos_gcs.planning.detection.expected_views import line_of, predicted_detection
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.plan import plan_of
from aos_gcs.planning.proposal import FREE_GROUND_M
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.runtime.simulated.planned_missions import planned_for, predicted, with_chosen_legs
from aos_gcs.swarm.line import line_axis
from tests.unit.lab.test_planned_missions import mission

POD = 0.6


@cache
def planned(vehicles: int) -> MissionSettings:
    return planned_for(mission(vehicles), 300.0, POD)


@cache
def chosen(vehicles: int) -> tuple[MissionSettings, tuple[ScanLeg, ...]]:
    return with_chosen_legs(planned(vehicles), POD)


@pytest.mark.parametrize("vehicles", [1, 3])
def test_each_leg_begins_where_the_one_before_has_ended_and_the_line_keeps_to_the_free_ground(vehicles: int) -> None:
    settings, legs = chosen(vehicles)
    assert legs[0].start_enu_m == pytest.approx((0.0, 5.0)), "the place of the area that is nearest to the launch site"
    for before, leg in pairwise(legs):
        assert before.end_enu_m == pytest.approx(leg.start_enu_m)
    aside_m = line_of(plan_of(settings), 0.0).aside_m
    for leg in legs:
        across = line_axis(np.array(leg.direction_enu))
        for middle_m in (leg.start_enu_m, leg.end_enu_m):
            places_m = np.array(middle_m) + aside_m[:, np.newaxis] * across
            beyond_m = np.abs(places_m - (0.0, 65.0)).max() - 60.0
            assert beyond_m <= (FREE_GROUND_M if vehicles > 1 else 0.0) + 1e-6


def test_the_legs_reach_what_is_wanted_and_are_the_same_each_time() -> None:
    settings, legs = chosen(1)
    detection = predicted_detection(plan_of(settings), legs, 0.0)
    assert detection is not None
    assert detection.standing == pytest.approx(POD, abs=0.05)
    assert with_chosen_legs(planned(1), POD) == (settings, legs)


def test_persons_are_promised_what_the_legs_show_of_their_places() -> None:
    settings, _ = chosen(1)
    leg = ScanLeg((-40.0, 20.0), (1.0, 0.0), 80.0)
    below, aside = predicted(settings, [(0.0, 20.0), (0.0, 110.0)], ["standing", "standing"], [leg])
    assert below > 0.5
    assert aside == 0.0


def test_a_line_that_the_free_ground_has_no_room_for_is_refused() -> None:
    narrow = planned(10)
    wide = replace(narrow, search=replace(narrow.search, line_spacing_m=40.0))
    with pytest.raises(ConfigurationError, match=r"--pod 0\.6 cannot be reached along chosen legs: .* --legs planned"):
        with_chosen_legs(wide, POD)


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"legs": "curved", "pod": 0.9}, "--legs must be planned or chosen, got 'curved'"),
        ({"legs": "chosen"}, "--legs chosen needs --pod"),
    ],
)
def test_settings_that_do_not_fit_are_refused(values: dict[str, Any], text: str) -> None:
    with pytest.raises(ConfigurationError, match=text):
        MissionsSettings(**values)


def test_studies_name_chosen_legs() -> None:
    assert MissionsSettings(pod=0.9, legs="chosen").name == "aos-apso, chosen legs"
    assert MissionsSettings(pod=0.9).name == "aos-apso"
