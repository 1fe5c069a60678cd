"""What a mission announces as a person, and what it leaves as something else: whole missions, in virtual time."""

from __future__ import annotations

import asyncio
from dataclasses import replace

import pytest

from aos_gcs.imaging.persons.decision import FindingKind
from aos_gcs.mission.model.findings import Finding, FindingChange, FindingStatus
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.planning.settings import DetectionSettings
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual

STONE = (4.0, 25.0, 18.0)
"""East, north and temperature of a stone; the ground has 12 degrees."""
PERSON = (-3.0, 48.0, 28.0)
NO_PERSON = {FindingKind.WARM_OBJECT, FindingKind.ANIMAL}
"""What a stone is taken for by the latest look: a guess."""
GOES_ON = DetectionSettings(threshold_m2=0.3, found_min_count=2, look_steps=8)


def over(*things: tuple[float, float, float], detection: DetectionSettings = GOES_ON) -> Flight:
    flight = prepare(target=None, detection=detection)
    for vehicle in flight.fleet.members.values():
        vehicle.others = things
    return flight


def findings(flight: Flight) -> tuple[Finding, ...]:
    return flight.view.snapshot().findings


def announced(flight: Flight) -> list[str]:
    return [text for text in flight.texts() if text.startswith("Possible person")]


async def test_a_warm_stone_is_looked_at_once_and_left() -> None:
    flight = over(STONE)
    async with flying(flight) as run:
        assert await run is Outcome.NOT_FOUND
    (stone,) = findings(flight)
    assert stone.kind in NO_PERSON
    assert stone.position_enu_m[:2] == pytest.approx(STONE[:2], abs=1.0)
    assert stone.person_confidence is not None
    assert stone.person_confidence < 0.5
    assert any("warmer than its surroundings" in reason for reason in stone.reasons)
    assert announced(flight) == []
    assert 0 < sum(step.phase is Phase.CONVERGE for step in flight.view.steps()) < GOES_ON.look_steps + 1
    left = [text for text in flight.texts() if text.endswith("The search goes on")]
    assert [text.split("?")[0] for text in left] in (["Warm object"], ["Animal"])
    assert any("whole area was scanned, nothing was found" in text for text in flight.texts())


async def test_behind_a_stone_a_person_is_found_and_the_search_goes_on_to_the_end_of_the_area() -> None:
    flight = over(STONE, PERSON)
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    person = next(finding for finding in findings(flight) if finding.kind is FindingKind.PERSON)
    assert person.position_enu_m[:2] == pytest.approx(PERSON[:2], abs=1.0)
    assert {finding.kind for finding in findings(flight)} - NO_PERSON == {FindingKind.PERSON}
    assert len(findings(flight)) == 2
    assert len(announced(flight)) == 1
    assert any("whole area was scanned, 1 possible person was found" in text for text in flight.texts())
    assert flight.recorder.outcome is not None
    assert flight.recorder.outcome.summary["persons"] == [person.finding_id]


async def test_two_persons_are_two_findings() -> None:
    other = (3.0, 60.0, 28.0)
    flight = over(PERSON, other)
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    assert [finding.kind for finding in findings(flight)] == [FindingKind.PERSON, FindingKind.PERSON]
    assert len(announced(flight)) == 2


async def test_the_search_stops_at_the_first_person_where_it_is_told_to() -> None:
    flight = over((3.0, 30.0, 28.0), (-3.0, 60.0, 28.0), detection=replace(GOES_ON, stop_at_first=True))
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    assert len(announced(flight)) == 1
    assert not any("whole area was scanned" in text for text in flight.texts())


async def test_a_rejected_person_is_not_proposed_again_and_the_mission_has_found_nothing() -> None:
    flight, rejected_in, changes = over(PERSON), list[int](), list[asyncio.Future[Finding]]()

    def reject() -> None:
        for finding in findings(flight):
            if finding.is_claimed and not changes:
                change = FindingChange(FindingStatus.REJECTED)
                changes.append(asyncio.ensure_future(flight.commands.change_finding(finding.finding_id, change)))
                rejected_in.append(flight.view.snapshot().step)

    # Steps that only watch take no time here: nobody who waits would see them.
    flight.recorder.on_flush = reject
    async with flying(flight) as run:
        assert await run is Outcome.NOT_FOUND
    assert len(announced(flight)) == len(rejected_in) == 1
    later = [step.phase for step in flight.view.steps() if step.step > rejected_in[0]]
    assert len(later) > 3
    assert set(later) == {Phase.SCAN}


async def test_an_operator_who_confirms_overrules_the_decision() -> None:
    flight = over(STONE)
    async with flying(flight) as run:
        await flight.until(lambda: bool(findings(flight)))
        await flight.commands.change_finding(1, FindingChange(FindingStatus.CONFIRMED), operator="Robin")
        assert await run is Outcome.FOUND


async def test_without_temperatures_an_anomaly_counts_as_a_find_and_says_so() -> None:
    flight = over(STONE)
    for vehicle in flight.fleet.members.values():
        vehicle.bands = ("red", "green", "blue")
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    (finding,) = findings(flight)
    assert (finding.kind, finding.person_confidence) == (FindingKind.ANOMALY, None)
    (text,) = (text for text in flight.texts() if text.startswith("Anomaly at"))
    assert "no temperatures" in text
