"""Commands out of a network that stalled, in a mission that has gone on."""

from __future__ import annotations

import asyncio

import pytest

from aos_gcs.api.convert.seen import parse_seen
from aos_gcs.api.events.hub import EventHub
from aos_gcs.mission.command_order import OutdatedError
from aos_gcs.mission.model.actions import Action, Seen
from aos_gcs.mission.model.phase import Phase, Suspension
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual


def seen(flight: Flight) -> Seen:
    """Return what an operator sees at this moment."""
    hub = EventHub(flight.view)
    return parse_seen(hub.seen())


async def test_a_launch_that_comes_late_arms_no_vehicle() -> None:
    flight = prepare(auto_start=False)
    async with flying(flight):
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        state = seen(flight)
        await asyncio.sleep(30.0)
        with pytest.raises(OutdatedError, match=r"30\.\d s old"):
            await flight.commands.act(Action.START, None, operator="Ada", seen=state)
        assert flight.mission.phase is Phase.READY
        assert not any(vehicle.armed for vehicle in flight.fleet.members.values())
        assert "30." in str(flight.recorder.actions[-1].refusal), "the audit log has it"

        await flight.commands.act(Action.START, None, operator="Ada", seen=seen(flight))
        await flight.until(lambda: flight.mission.phase is Phase.TAKEOFF)


async def test_an_old_resume_does_not_undo_the_hold_of_another_operator() -> None:
    flight = prepare()
    async with flying(flight):
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        await flight.commands.act(Action.PAUSE, None, operator="Ada", seen=seen(flight))
        state = seen(flight)
        await flight.commands.act(Action.HOLD, None, operator="Robin", seen=seen(flight))
        with pytest.raises(OutdatedError, match="Robin sent hold meanwhile"):
            await flight.commands.act(Action.RESUME, None, operator="Ada", seen=state)
        assert flight.mission.suspension is Suspension.HELD
        await flight.commands.act(Action.HOLD, None, operator="Ada", seen=state)
        await flight.commands.act(Action.RESUME, None, operator="Ada", seen=seen(flight))
        assert flight.mission.suspension is Suspension.NONE


async def test_a_mission_that_has_ended_shows_nothing_older_than_now() -> None:
    flight = prepare(target=None)
    hub = EventHub(flight.view)
    async with flying(flight) as run:
        following = asyncio.create_task(hub.run())
        await run
        await asyncio.sleep(60.0)
        now_s = asyncio.get_running_loop().time()
        assert parse_seen(hub.shown()).at_s == pytest.approx(now_s, abs=0.01)
        following.cancel()


async def test_who_comes_after_the_end_of_a_mission_may_ask_for_a_new_sortie() -> None:
    """The last page was closed before the landing; one opened after it was told the age of what that had shown."""
    flight = prepare(target=None)
    hub = EventHub(flight.view)
    async with flying(flight) as run:
        following = asyncio.create_task(hub.run())
        with hub.connect():
            await flight.until(lambda: flight.mission.phase is Phase.SCAN)
            await asyncio.sleep(1.0)
        await run
        await asyncio.sleep(60.0)
        with hub.connect():
            now_s = asyncio.get_running_loop().time()
            assert parse_seen(hub.shown()).at_s == pytest.approx(now_s, abs=0.01)
        following.cancel()


async def test_what_a_mission_shows_that_hangs_gets_older() -> None:
    flight = prepare(auto_start=False)
    hub = EventHub(flight.view)
    async with flying(flight) as run:
        following = asyncio.create_task(hub.run())
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        now_s = asyncio.get_running_loop().time()
        assert parse_seen(hub.shown()).at_s == pytest.approx(now_s, abs=0.5)
        run.cancel()
        await asyncio.sleep(60.0)
        assert parse_seen(hub.shown()).at_s == pytest.approx(now_s, abs=6.0)
        following.cancel()
