"""The station's pulse: how late its loop runs, and what is reported when it stands still."""

from __future__ import annotations

import asyncio

import pytest

from aos_gcs.mission.health import CatchingUp, LoopMonitor
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.events import NoticeRecord
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import FlightMode, Severity
from tests.fakes.hand_time import stand_still
from tests.fakes.mission_flight import flying, prepare

pytestmark = pytest.mark.virtual


async def test_the_pulse_is_healthy_only_while_it_beats() -> None:
    monitor = LoopMonitor()
    beating = asyncio.create_task(monitor.run(pytest.fail))
    await asyncio.sleep(30.0)
    assert monitor.is_healthy()
    beating.cancel()
    await asyncio.sleep(0.9)
    assert monitor.is_healthy()
    await asyncio.sleep(0.2)
    assert not monitor.is_healthy()


async def test_lags_are_taken_once_per_step() -> None:
    monitor = LoopMonitor()
    assert monitor.take_step_lag_p99_ms() == 0.0
    assert monitor.lag_p99_ms() == 0.0
    beating = asyncio.create_task(monitor.run(pytest.fail))
    await asyncio.sleep(1.0)
    beating.cancel()
    lag_ms = monitor.take_step_lag_p99_ms()
    assert lag_ms == monitor.lag_p99_ms()
    assert monitor.take_step_lag_p99_ms() == 0.0


async def test_stalls_are_told_once_with_their_length(monkeypatch: pytest.MonkeyPatch) -> None:
    monitor, told = LoopMonitor(), []
    beating = asyncio.create_task(monitor.run(told.append))
    for duration_s in (0.9, 2.0, 1.5, 3.0):
        await asyncio.sleep(1.0)
        stand_still(monkeypatch, duration_s)
    await asyncio.sleep(11.0)
    stand_still(monkeypatch, 1.5)
    await asyncio.sleep(1.0)
    beating.cancel()
    assert told == pytest.approx([2.0, 3.0, 1.5], abs=0.1), "short ones after a longer one are no news"
    assert monitor.longest_stall_s == pytest.approx(3.0, abs=0.1)


def test_a_station_that_stalls_again_and_again_still_judges_silence() -> None:
    catching_up = CatchingUp()
    assert not any(catching_up.look(0.1 * tick) for tick in range(50))
    assert catching_up.look(12.0)
    assert catching_up.look(12.9)
    assert not catching_up.look(13.1)
    judged = [not catching_up.look(100.0 + 1.2 * tick) for tick in range(100)]
    assert sum(judged) >= 70


async def test_a_stall_is_the_stations_fault_and_no_lost_link(monkeypatch: pytest.MonkeyPatch) -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        for vehicle in flight.fleet.members.values():
            vehicle.silent_since_s = flight.clock.now_s()
        stand_still(monkeypatch, 7.0)
        await flight.clock.sleep(0.3)  # what they have sent meanwhile is read only now
        for vehicle in flight.fleet.members.values():
            vehicle.silent_since_s = None
        await run
    assert not [text for text in flight.texts() if "link lost" in text]
    (notice,) = [
        event.data
        for event in flight.recorder.events
        if isinstance(event.data, NoticeRecord) and "unresponsive" in event.data.text
    ]
    assert notice.severity is Severity.CRITICAL
    assert notice.text.startswith(("Station unresponsive for 6.", "Station unresponsive for 7."))
    assert flight.recorder.outcome is not None
    assert flight.recorder.outcome.summary["longest_stall_s"] == pytest.approx(7.0, abs=0.6)


async def test_a_vehicle_that_stays_silent_after_a_stall_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        flight.fleet.members[2].silent_since_s = flight.clock.now_s()
        stand_still(monkeypatch, 7.0)
        await flight.clock.sleep(1.5)
        assert flight.task(2) is Task.LOST
        assert flight.task(1) is Task.SWARM
        run.cancel()
    (text,) = [text for text in flight.texts() if text.startswith("link lost")]
    assert "its own overload may be the cause" in text


async def test_the_heartbeat_goes_on_after_the_end_while_a_pilot_flies() -> None:
    flight = prepare(3)
    piloted = flight.fleet.members[2]
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        piloted.mode = FlightMode.MANUAL
        await flight.commands.act(Action.LAND, None)
        await run
    assert flight.mission.phase is Phase.DONE
    assert flight.mission.is_any_flying
    async with flight.journal.recorded(flight.recorder), asyncio.TaskGroup() as group:
        staying = group.create_task(flight.mission.stay(until_landed=True))
        for _ in range(60):
            await flight.clock.sleep(1.0)
            assert flight.pulse.is_healthy()
        (result,) = await flight.commands.act(Action.LAND, (2,))
        assert result.accepted
        await staying
    assert not piloted.state.armed


async def test_the_heartbeat_goes_on_for_as_long_as_the_page_is_up() -> None:
    flight = prepare(2)
    async with flying(flight) as run:
        await flight.commands.act(Action.ABORT, None)
        await run
    staying = asyncio.create_task(flight.mission.stay())
    await flight.clock.sleep(60.0)
    assert flight.pulse.is_healthy()
    staying.cancel()
