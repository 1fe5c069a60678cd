"""Looks that are left for later, because scanning on is expected to find a person sooner. In virtual time."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

from aos_gcs.airspace.limits import UNLIMITED, SafetyOverrides
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.findings import FindingChange, FindingStatus
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.planning.search_settings import LookOrder, SearchMode, SearchSettings
from aos_gcs.planning.settings import Deadlines, DetectionSettings
from aos_gcs.runtime.recorded.verification import Verification, verify_mission
from aos_gcs.runtime.simulated.virtual_time import run as run_virtually
from aos_gcs.store.reader import MissionReader
from tests.fakes.mission_flight import EXACT, Flight, ask_for_another, flying, prepare
from tests.fakes.recorded_search import write_search
from tests.fakes.restarted_flight import restarted

PERSON = (3.0, 90.0)
AREA = ((-15.0, 10.0), (15.0, 10.0), (15.0, 120.0), (-15.0, 120.0))
WARM = (0.0, 40.0, 22.0)
"""A warm thing before the person: east, north, degrees Celsius."""
WARMER = (0.0, 40.0, 24.0)
"""The same, which may be a person by its temperature."""
BY_GAIN = SearchSettings()
BY_GAIN_PAST = {"search": BY_GAIN, "area_enu_m": AREA, "camera_delay_s": 0.6, "errors": EXACT}
WHOLE_AREA = DetectionSettings(stop_at_first=False)


def past_warm(person: tuple[float, float] | None, warm: tuple[float, float, float], **changes: object) -> Flight:
    """Return a flight of three over the area, in which each camera sees the warm thing, too."""
    flight = prepare(3, person, **{**BY_GAIN_PAST, **changes})
    for vehicle in flight.fleet.members.values():
        vehicle.others = (warm,)
    return flight


def fly(
    search: SearchSettings,
    person: tuple[float, float] | None = PERSON,
    warm: tuple[float, float, float] = WARM,
    **changes: object,
) -> Flight:
    async def whole() -> Flight:
        flight = past_warm(person, warm, search=search, **changes)
        async with flying(flight) as run:
            await run
        return flight

    return run_virtually(whole())


def phases(flight: Flight) -> list[Phase]:
    steps = [flight.recorder.steps[number].phase for number in sorted(flight.recorder.steps)]
    return [phase for phase, before in zip(steps, [None, *steps], strict=False) if phase is not before]


def found_s(flight: Flight) -> float:
    return min(step.elapsed_s for step in flight.recorder.steps.values() if step.phase is Phase.FOUND)


def said(flight: Flight, text: str) -> list[str]:
    return [one for one in flight.texts() if text in one]


def test_a_person_behind_a_warm_thing_is_found_before_that_is_looked_at() -> None:
    first, by_gain = fly(SearchSettings(looks=LookOrder.FIRST)), fly(BY_GAIN)
    assert phases(first) == [Phase.SCAN, Phase.CONVERGE, Phase.SCAN, Phase.CONVERGE, Phase.FOUND]
    assert phases(by_gain) == [Phase.SCAN, Phase.CONVERGE, Phase.FOUND]
    assert found_s(by_gain) < found_s(first) - 5.0
    assert not said(first, "eft for later")


def test_what_is_left_for_later_is_looked_at_behind_the_last_leg_and_the_record_proves_it(tmp_path: Path) -> None:
    flight = fly(BY_GAIN, detection=WHOLE_AREA)
    assert flight.view.snapshot().outcome is Outcome.FOUND
    assert flight.view.snapshot().covered_fraction == 1.0
    assert (
        len(said(flight, "Left for later: ")) == len(said(flight, "Close look started (left for later before): ")) == 1
    )
    assert flight.smallest_m >= UNLIMITED.separation_m
    assert len(said(flight, "Possible person (")) == 1
    write_search(tmp_path / "mission", flight.recorder)
    with MissionReader(tmp_path / "mission") as reader:
        assert verify_mission(reader) == Verification(len(flight.recorder.steps), None)


def test_what_may_be_a_person_after_all_is_looked_at_behind_the_last_leg() -> None:
    flight = fly(BY_GAIN, None, WARMER)
    assert phases(flight) == [Phase.SCAN, Phase.CONVERGE, Phase.SCAN]
    swept = [step.elapsed_s for step in flight.recorder.steps.values() if step.branch == "sweep"]
    assert all(step.elapsed_s > max(swept) for step in flight.recorder.steps.values() if step.phase is Phase.CONVERGE)
    assert len(said(flight, "Close look started (left for later before): ")) == 1
    assert len(said(flight, "Undecided when the search ended")) == 1
    assert flight.view.snapshot().outcome is Outcome.FOUND


def test_with_stops_the_look_comes_first() -> None:
    flight = fly(SearchSettings(SearchMode.STOPS))
    assert phases(flight)[:2] == [Phase.SCAN, Phase.CONVERGE]
    assert not said(flight, "eft for later")


def test_where_the_time_is_over_what_was_not_looked_at_is_named() -> None:
    flight = fly(BY_GAIN, None, WARMER, deadlines=Deadlines(search_s=20.0))
    assert flight.view.snapshot().outcome is Outcome.NOT_FOUND
    assert len(said(flight, "Not examined (left for later): ")) == 1


def test_what_an_operator_has_rejected_is_not_looked_at_later() -> None:
    async def whole() -> Flight:
        flight = past_warm(None, WARMER)
        async with flying(flight) as run:
            await flight.until(lambda: bool(flight.view.snapshot().findings))
            (finding,) = flight.view.snapshot().findings
            await flight.commands.change_finding(finding.finding_id, FindingChange(status=FindingStatus.REJECTED))
            await run
        return flight

    flight = run_virtually(whole())
    assert phases(flight) == [Phase.SCAN]
    assert not said(flight, "Close look started")


def test_the_station_that_takes_up_a_flight_looks_at_what_the_one_before_left_and_the_record_proves_it(
    tmp_path: Path,
) -> None:
    async def until_left() -> MissionSnapshot:
        flight = past_warm(None, WARMER, detection=WHOLE_AREA)
        async with flying(flight) as run:
            await flight.until(lambda: bool(said(flight, "Left for later: ")))
            last = flight.view.snapshot()
            run.cancel()
        return last

    async def go_on(last: MissionSnapshot) -> Flight:
        flight = restarted(last, **BY_GAIN_PAST, detection=WHOLE_AREA)
        # The warm thing is gone: only what was left leads there.
        async with flying(flight) as run:
            await flight.until(lambda: flight.mission.phase is Phase.TAKEOFF)
            await flight.clock.sleep(1.0)
            await flight.commands.act(Action.RESUME, None)
            await run
        return flight

    last = run_virtually(until_left())
    (place,) = last.left_for_later
    flight = run_virtually(go_on(last))
    assert math.dist(place.place_enu_m, (0.0, 40.0)) < 2.0
    assert len(said(flight, "Close look started (left for later before): ")) == 1
    assert flight.view.snapshot().left_for_later == ()
    write_search(tmp_path / "mission", flight.recorder)
    with MissionReader(tmp_path / "mission") as reader:
        assert verify_mission(reader) == Verification(len(flight.recorder.steps), None)


def test_what_was_left_is_named_where_an_operator_ends_the_search() -> None:
    async def whole() -> Flight:
        flight = past_warm(None, WARMER)
        async with flying(flight) as run:
            await flight.until(lambda: bool(said(flight, "Left for later: ")))
            await flight.commands.act(Action.RETURN, None)
            await run
        return flight

    assert len(said(run_virtually(whole()), "Not examined (left for later): ")) == 1


async def next_flight(**changes: object) -> Flight:
    """Return the sortie that follows one whose time was over, when it has ended. The warm thing is gone meanwhile."""
    former = past_warm(None, WARMER, deadlines=Deadlines(search_s=20.0))
    async with flying(former) as run:
        await run
    following = await ask_for_another(former)
    (left,) = following.left_for_later
    assert math.dist(left.place_enu_m, (0.0, 40.0)) < 2.0
    assert "What is left for later, 1 place, is looked at behind the last leg" in following.text
    settings = replace(following.settings, deadlines=Deadlines(), **changes)
    flight = prepare(3, None, following=replace(following, settings=settings), errors=EXACT, camera_delay_s=0.6)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        await flight.commands.act(Action.START, None)
        await run
    return flight


def test_the_next_sortie_looks_at_what_the_former_one_left_and_the_record_proves_it(tmp_path: Path) -> None:
    flight = run_virtually(next_flight())
    assert len(said(flight, "Close look started (left for later before): ")) == 1
    assert not said(flight, "Not examined")
    assert flight.view.snapshot().left_for_later == ()
    write_search(tmp_path / "mission", flight.recorder)
    with MissionReader(tmp_path / "mission") as reader:
        assert verify_mission(reader) == Verification(len(flight.recorder.steps), None)


def test_a_place_that_the_next_geofence_keeps_vehicles_from_is_named_and_stays_left() -> None:
    south = ((-15.0, 5.0), (15.0, 5.0), (15.0, 15.0), (-15.0, 15.0))
    fence = SafetyOverrides(fence_enu_m=((-60.0, -40.0), (60.0, -40.0), (60.0, 58.0), (-60.0, 58.0)))
    flight = run_virtually(next_flight(area_enu_m=south, safety=fence))
    assert not said(flight, "Close look started")
    (text,) = said(flight, "Not examined (left for later): ")
    assert text.endswith("(the geofence keeps vehicles away)")
    assert len(flight.view.snapshot().left_for_later) == 1
