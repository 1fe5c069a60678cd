"""Missions of the study that are planned for a probability of detection, and what their plans promise."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.lab.missions.model import MissionsSettings
from aos_gcs.lab.missions.report import as_markdown, summarise
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.runtime.simulated import planned_missions
from aos_gcs.runtime.simulated.planned_missions import planned_for, predicted
from tests.fakes.target_sightings import SETTINGS
from tests.unit.lab.test_missions import EMPTY, FOUND

AREA = ((-60.0, 5.0), (60.0, 5.0), (60.0, 125.0), (-60.0, 125.0))


def mission(vehicles: int) -> MissionSettings:
    return replace(SETTINGS, vehicles=vehicles, vehicle_ids=(), area_enu_m=AREA)


def test_spacings_and_speed_are_those_of_the_planner_and_the_legs_are_flown_once() -> None:
    planned = planned_for(mission(3), 300.0, 0.75)
    assert planned.search.line_spacing_m == pytest.approx(20.0)
    assert planned.search.leg_spacing_m == pytest.approx(60.0)
    assert 4.0 < planned.flight.search_speed_mps < 7.0
    assert planned.search.pod is None
    assert planned.forest is not None
    assert planned.area_enu_m == AREA


def test_what_no_pattern_reaches_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    # The planner itself tries a hundred patterns before it gives up.
    monkeypatch.setattr(planned_missions, "propose_pattern", lambda *_: None)
    with pytest.raises(ConfigurationError, match=r"--pod 0\.99 cannot be reached by 1 vehicles at 1000 trees"):
        planned_for(mission(1), 1000.0, 0.99)


def test_the_middle_of_the_area_is_promised_more_than_a_place_outside_and_lying_persons_more_than_standing_ones() -> (
    None
):
    planned = planned_for(mission(3), 300.0, 0.75)
    places = [(0.0, 60.0), (0.0, 60.0), (0.0, 60.0), (0.0, 400.0)]
    standing, walking, lying, outside = predicted(planned, places, ["standing", "walking", "lying", "standing"])
    assert 0.75 < standing < lying <= 1.0
    assert walking == standing
    assert outside == 0.0
    assert predicted(planned, [], []) == ()
    assert predicted(mission(3), places, ["standing"] * 4) == ()


def test_the_report_compares_what_was_promised() -> None:
    planned = replace(FOUND, predicted=(0.8,), persons_noticed=1)
    missed = replace(planned, key=replace(FOUND.key, seed=9), predicted=(0.6,), persons_noticed=0, persons_found=0)
    (group,) = summarise([planned, missed, EMPTY], vehicles=3)
    assert group.predicted == pytest.approx(0.7)
    assert "| 300 | cool | rtk | 0.70 | 1 of 2: 50 % (9 to 91) | 1 of 2: 50 % (9 to 91) |" in as_markdown([group])
    assert "planned" not in as_markdown(summarise([FOUND], vehicles=3))


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"pod": 1.5}, "--pod must lie within"),
        ({"pod": 0.9, "search_mode": "stops"}, "--pod needs level ground"),
        ({"pod": 0.9, "terrain": "hills"}, "--pod needs level ground"),
        ({"looks": "never"}, "--looks must be first or gain"),
    ],
)
def test_settings_that_do_not_fit_are_refused(values: dict[str, Any], text: str) -> None:
    with pytest.raises(ConfigurationError, match=text):
        MissionsSettings(**values)


def test_studies_name_the_order_of_looks() -> None:
    assert MissionsSettings(looks="gain").name == "aos-apso, looks gain"
