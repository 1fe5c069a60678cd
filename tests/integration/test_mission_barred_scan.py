"""A scan that a no-go zone bars goes on behind it, or on the next leg, and says what it has left out."""

from __future__ import annotations

import pytest

from aos_gcs.airspace.limits import SafetyOverrides
from aos_gcs.airspace.polygon import Polygon
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.phases import PHASE_NAMES
from aos_gcs.planning.settings import Deadlines
from tests.fakes.mission_flight import EXACT, Flight, flying, prepare

pytestmark = pytest.mark.virtual

AREA = ((-12.0, 10.0), (12.0, 10.0), (12.0, 34.0), (-12.0, 34.0))
ACROSS = ((-25.0, 16.0), (25.0, 16.0), (25.0, 24.0), (-25.0, 24.0))
"""Wider than the line, with a way around it inside the fence."""
IN_ONE_WAY = ((4.0, 14.0), (9.0, 14.0), (9.0, 24.0), (4.0, 24.0))
"""Before one vehicle of the line, too deep for the pull of the others to carry it past."""
WIDE_AREA = ((-50.0, 10.0), (50.0, 10.0), (50.0, 18.0), (-50.0, 18.0))
TO_THE_END_OF_ONE_LEG = ((12.0, 14.0), (80.0, 14.0), (80.0, 60.0), (12.0, 60.0))
SHORT_AREA = ((-12.0, 10.0), (12.0, 10.0), (12.0, 16.0), (-12.0, 16.0))
ASIDE = ((20.0, 10.0), (25.0, 10.0), (25.0, 24.0), (20.0, 24.0))


async def scan_past(zone: Polygon, area: Polygon = AREA) -> Flight:
    """Return the flight after a mission that sees nothing; stuck, it would end by its deadline."""
    deadlines = Deadlines(connect_s=5.0, preflight_s=15.0, capture_s=5.0, search_s=240.0)
    safety = SafetyOverrides(no_go_enu_m=(zone,), margin_m=1.0)
    flight = prepare(target=None, errors=EXACT, area_enu_m=area, safety=safety, deadlines=deadlines)
    async with flying(flight) as run:
        assert await run is Outcome.NOT_FOUND
    return flight


async def test_a_zone_across_the_way_is_left_behind_and_told_once() -> None:
    flight = await scan_past(ACROSS)
    told = [text for text in flight.texts() if "is blocked" in text]
    assert len(told) == 1
    assert "Leg 1 is blocked after 5 of 24 m" in told[0]
    assert "no-go zone 1" in told[0]
    assert furthest_north_m(flight) > 32.0
    (over,) = (text for text in flight.texts() if "Scan complete, nothing was found" in text)
    assert "of its legs were left out" in over


@pytest.mark.slow
async def test_a_vehicle_that_cannot_go_on_stops_the_others_for_a_while_only() -> None:
    flight = await scan_past(IN_ONE_WAY)
    assert any("(vehicle 4: held: no-go zone 1" in text for text in flight.texts())
    assert furthest_north_m(flight) > 32.0


async def test_the_next_leg_is_flown_where_the_rest_of_one_is_barred() -> None:
    flight = await scan_past(TO_THE_END_OF_ONE_LEG, WIDE_AREA)
    told = [text for text in flight.texts() if "is blocked" in text]
    assert len(told) == 1
    assert told[0].endswith("The scan leaves out the rest of it")
    assert told[0].startswith("Leg 1 ")
    assert flight.texts().count(PHASE_NAMES[Phase.LINE]) == len(flight.view.snapshot().legs_enu_m)


async def test_a_scan_that_nothing_bars_says_that_it_saw_it_all() -> None:
    flight = await scan_past(ASIDE, SHORT_AREA)
    assert not any("is blocked" in text for text in flight.texts())
    assert "Scan complete: the whole area was scanned, nothing was found" in flight.texts()


def furthest_north_m(flight: Flight) -> float:
    """Return how far the scan has sent its line."""
    sent = [waypoint.sent_enu_m for step in flight.view.steps() for waypoint in step.waypoints]
    return max(place_enu_m[1] for place_enu_m in sent if place_enu_m is not None)
