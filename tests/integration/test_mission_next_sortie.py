"""Sorties of one operation: what the next one begins with, and what it does not inherit."""

from __future__ import annotations

import asyncio

import pytest

from aos_gcs.errors import MissionError
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.findings import FindingChange, FindingStatus
from aos_gcs.mission.model.phase import Outcome, Phase
from tests.fakes.mission_flight import Flight, ask_for_another, flying, prepare
from tests.fakes.retraced import check_decisions_again

pytestmark = pytest.mark.virtual


async def fly(flight: Flight) -> Outcome:
    async with flying(flight) as run:
        return await run


async def test_the_next_sortie_keeps_findings_and_judgements_but_neither_tracks_nor_the_outcome() -> None:
    flight = prepare()
    assert await fly(flight) is Outcome.FOUND
    (found,) = flight.view.snapshot().findings
    await flight.commands.change_finding(found.finding_id, FindingChange(FindingStatus.CONFIRMED), operator="Ada")
    following = await ask_for_another(flight)
    assert (following.number, following.operation) == (2, "m")
    assert not following.settings.auto_start
    assert following.settings.origin == flight.view.snapshot().origin

    second = prepare(target=None, following=following)
    assert second.view.snapshot().outcome is Outcome.OPEN
    async with flying(second) as run:
        await second.until(lambda: second.mission.phase is Phase.READY)
        await second.commands.act(Action.START, None)
        assert await run is Outcome.NOT_FOUND
    (kept,) = second.view.snapshot().findings
    assert (kept.found_in, kept.status, kept.operator) == ("m", FindingStatus.CONFIRMED, "Ada")
    assert (kept.position_enu_m, kept.track_id, kept.step) == (found.position_enu_m, None, found.step)
    assert any(text.startswith("Sortie 2.") for text in second.texts())
    assert second.recorder.outcome is not None
    assert second.recorder.outcome.summary["persons"] == []
    third = await ask_for_another(second)
    assert (third.number, third.operation) == (3, "m")
    assert [finding.found_in for finding in third.findings] == ["m"], "the mission that has found it"


async def test_a_person_seen_again_is_the_finding_of_the_former_sortie() -> None:
    flight = prepare()
    await fly(flight)
    assert any(text.startswith("Possible person") for text in flight.texts())
    following = await ask_for_another(flight)
    second = prepare(following=following)
    async with flying(second) as run:
        await second.until(lambda: second.mission.phase is Phase.READY)
        await second.commands.act(Action.START, None)
        assert await run is Outcome.FOUND
    (found,) = second.view.snapshot().findings
    assert (found.finding_id, found.found_in) == (1, "")
    assert found.step > 0
    assert found.found_at_s > 0.0
    assert not any(text.startswith("Possible person") for text in second.texts()), "announced once in an operation"
    check_decisions_again(second.recorder)


async def test_there_is_no_new_sortie_before_the_end_or_while_a_vehicle_flies() -> None:
    flight = prepare(3)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        with pytest.raises(MissionError, match="the mission is not over"):
            await flight.commands.act(Action.NEW_SORTIE, None)
        await flight.commands.act(Action.RETURN, None)
        await run
    flight.fleet.members[2].armed = True
    flight.fleet.members[2].start_enu_m = flight.fleet.members[2].goal_enu_m = (
        flight.fleet.members[2].true_enu_m() + 20.0
    )
    async with flight.journal.recorded(flight.recorder):
        staying = asyncio.create_task(flight.mission.stay())
        await flight.clock.sleep(1.0)
        with pytest.raises(MissionError, match="a vehicle still flies"):
            await flight.commands.act(Action.NEW_SORTIE, None)
        assert not staying.done()
        staying.cancel()


async def test_a_place_marked_before_the_launch_keeps_the_time_of_the_mark() -> None:
    flight = prepare(target=None, auto_start=False)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        marked_utc_s = flight.clock.utc_s()
        marked = await flight.commands.add_finding((4.0, -6.0, 0.0), "tent", operator="Ada")
        await asyncio.sleep(30.0)
        await flight.commands.act(Action.START, None)
        assert await run is Outcome.NOT_FOUND
    snapshot = flight.view.snapshot()
    (finding,) = snapshot.findings
    assert snapshot.started_utc_s is not None
    assert finding.found_at_s == finding.seen_at_s <= -30.0
    assert snapshot.started_utc_s + finding.found_at_s == pytest.approx(marked_utc_s, abs=0.01)
    assert finding.comment == marked.comment
    check_decisions_again(flight.recorder)
