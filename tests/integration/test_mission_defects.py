"""Defects, disks and images that fail during a mission, on a fake fleet in virtual time."""

from __future__ import annotations

import asyncio
import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import (
    Capture,
    FlightMode,
    ReturnToLaunch,
)
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual


# --- defects and disks -----------------------------------------------------------------------------------------------


async def test_a_disk_that_hangs_delays_no_hold_and_hardly_its_answer() -> None:
    flight = prepare()
    flight.recorder.is_stuck = True
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.TAKEOFF)
        async with asyncio.timeout(2.0):
            results = await flight.commands.act(Action.HOLD, None)
        assert all(result.accepted for result in results)
        await flight.commands.act(Action.ABORT, None)
        await run
    assert any("action hold may be missing" in text for text in flight.texts())


async def test_a_disk_that_hangs_does_not_stop_the_search() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        flight.recorder.is_stuck = True
        assert await run is Outcome.FOUND
    assert all(vehicle.task is Task.LANDED for vehicle in flight.view.snapshot().vehicles)
    assert any("step 4 may be missing" in text for text in flight.texts())


@pytest.mark.parametrize("culprit", ["handler", "monitor"])
async def test_a_defect_sends_all_home_and_is_reported(culprit: str) -> None:
    flight = prepare()
    pilot = flight.fleet.members[1]

    def fail(*_args: object, **_settings: object) -> None:
        raise ZeroDivisionError("a defect")

    with pytest.raises(ExceptionGroup) as caught:  # noqa: PT012 - the mission is the statement
        async with flying(flight) as run:
            await flight.until(lambda: len(flight.view.steps()) == 2)
            pilot.mode = FlightMode.MANUAL
            owner, name = {
                "handler": (flight.mission.sortie.search.decider, "decide"),
                "monitor": (flight.mission._monitor._proximity, "look"),
            }[culprit]
            setattr(owner, name, fail)
            await run
    assert caught.group_contains(ZeroDivisionError)
    assert [isinstance(v.commands[-1], ReturnToLaunch) for v in flight.fleet.members.values()] == [False] + [True] * 3
    assert flight.recorder.outcome is not None
    assert flight.recorder.outcome.outcome is Outcome.FAILED
    assert any("ZeroDivisionError" in text for text in flight.texts())


async def test_a_farewell_that_fails_still_closes_the_record() -> None:
    flight = prepare()

    async def fail(*_args: object) -> None:
        raise ZeroDivisionError("a broken driver")

    with pytest.raises(ExceptionGroup):  # noqa: PT012 - the mission is the statement
        async with flying(flight) as run:
            await flight.until(lambda: len(flight.view.steps()) == 2)
            flight.fleet.members[2].execute = fail  # type: ignore[method-assign]
            await run
    assert flight.recorder.outcome is not None
    assert all(isinstance(flight.fleet.members[i].commands[-1], ReturnToLaunch) for i in (1, 3, 4))


# --- frames that cannot be used --------------------------------------------------------------------------------------


def blind_cameras(flight: Flight, vehicle_ids: set[int]) -> None:
    """Let some cameras deliver images that show nothing."""
    for vehicle_id in vehicle_ids:
        vehicle = flight.fleet.members[vehicle_id]
        take = vehicle.capture

        async def capture(deadline_s: float, take: Callable = take) -> Capture:
            taken = await take(deadline_s)
            return dataclasses.replace(taken, image=np.full_like(taken.image, 7))

        vehicle.capture = capture  # type: ignore[method-assign]


async def test_an_image_that_shows_nothing_counts_as_missing_with_the_reason() -> None:
    flight = prepare()
    blind_cameras(flight, {1})
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 2)
        for record in flight.view.steps():
            assert list(record.missing) == [1]
            assert "the same everywhere" in record.missing[1]
            assert 1 not in record.fitness
            assert 1 in {waypoint.vehicle_id for waypoint in record.waypoints}
        assert any("goes on without its frame: its image is the same" in text for text in flight.texts())
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_swarm_whose_images_all_show_nothing_comes_home() -> None:
    flight = prepare()
    blind_cameras(flight, set(flight.fleet.members))
    async with flying(flight) as run:
        assert await run is Outcome.FAILED
    assert any("No camera delivered a usable frame in 3 steps" in text for text in flight.texts())
