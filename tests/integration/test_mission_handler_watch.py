"""Handlers of phases that hang, in virtual time: they are ended, and if they cannot be, the heartbeat stops."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest

from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.search.frames.vision import Vision
from aos_gcs.ports import Capture
from tests.fakes.fleet import FakeVehicle
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual


async def hang(*_: object, **__: object) -> Capture:
    return await asyncio.Event().wait()  # type: ignore[return-value]


async def unhealthy_moments(flight: Flight, is_over: Callable[[], bool]) -> int:
    """Count the tenths of a second without heartbeat until it is over."""
    count = 0
    while not is_over():
        await flight.clock.sleep(0.1)
        count += not flight.pulse.is_healthy()
    return count


@pytest.mark.parametrize("hanging", [(FakeVehicle, "capture"), (Vision, "see")], ids=["camera", "imaging"])
async def test_a_step_that_hangs_is_ended_and_all_return(
    hanging: tuple[type, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    flight = prepare(3)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        monkeypatch.setattr(*hanging, hang)
        assert await unhealthy_moments(flight, run.done) == 0
        assert await run is Outcome.FAILED
    assert any("makes no progress: all vehicles return" in text for text in flight.texts())
    assert [flight.task(number) for number in (1, 2, 3)] == [Task.LANDED] * 3


async def test_a_handler_that_cannot_be_ended_stops_the_heartbeat() -> None:
    flight, released = prepare(3), asyncio.Event()

    async def stubborn() -> Phase:
        while not released.is_set():
            try:
                await released.wait()
            except asyncio.CancelledError:
                continue
        return Phase.RETURN

    flight.mission.sortie.handlers = {**flight.mission.sortie.handlers, Phase.SCAN: stubborn}
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        await flight.clock.sleep(4.0)
        assert flight.pulse.is_healthy()
        await flight.clock.sleep(4.0)
        assert not flight.pulse.is_healthy()
        released.set()
        await flight.clock.sleep(2.0)
        assert flight.pulse.is_healthy()
        assert await run is Outcome.FAILED


async def test_a_mission_that_waits_long_is_no_mission_that_hangs() -> None:
    flight = prepare(3)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.TAKEOFF)
        for vehicle in flight.fleet.members.values():
            vehicle.speed_mps = 0.6  # a climb of a minute
            vehicle.fly_to(vehicle.goal_enu_m)
        assert await unhealthy_moments(flight, lambda: flight.mission.phase is Phase.SCAN) == 0
        run.cancel()
    assert not any("makes no progress" in text for text in flight.texts())
