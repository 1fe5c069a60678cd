"""Vehicles that were carried after they had been switched on, or whose home somebody has set, on a fake fleet."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.errors import MissionError
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.checks import CheckStatus
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.preflight import checks
from aos_gcs.ports import Arm, Disarm, Takeoff
from aos_gcs.scripting import ScriptOptions, Swarm
from tests.fakes.fleet import FakeFleet, FakeVehicle
from tests.fakes.mission_flight import EXACT, Flight, flying, prepare

pytestmark = pytest.mark.virtual

ELSEWHERE = (0.0, -30.0, 0.0)


def switched_on_elsewhere(flight: Flight, number: int) -> FakeVehicle:
    """Let the home of a vehicle lie 30 m from where it stands."""
    vehicle = flight.fleet.members[number]
    vehicle.home_enu_m = vehicle.home_enu_m + np.array(ELSEWHERE)
    return vehicle


async def test_one_that_was_carried_is_warned_of_and_returns_to_where_it_was_armed() -> None:
    flight = prepare(errors=EXACT, auto_start=False)
    vehicle = switched_on_elsewhere(flight, 2)
    stood_enu_m = vehicle.position_enu_m()
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        check = flight.check(2, checks.HOME)
        assert (check.status, check.text) == (CheckStatus.WARN, "30 m from where it stands")
        assert "restart it where it stands" in check.remedy
        assert flight.check(1, checks.HOME).status is CheckStatus.PASS
        home_enu_m = flight.view.snapshot().vehicles[1].home_enu_m
        assert home_enu_m == pytest.approx(stood_enu_m, abs=0.05), "paths and fence begin where it stands"
        await flight.commands.act(Action.START, None)
        await flight.until(lambda: len(flight.view.steps()) == 1)
        assert flight.task(2) is Task.SWARM
        await flight.commands.act(Action.RETURN, None)
        await run
    assert vehicle.position_enu_m() == pytest.approx(stood_enu_m, abs=0.6)


@pytest.fixture
def homes_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let all vehicles keep their homes when they are armed, as those that somebody has set."""
    obey = FakeVehicle._obey

    def keep_home(vehicle: FakeVehicle, command: object) -> None:
        home_enu_m = vehicle.home_enu_m
        obey(vehicle, command)  # type: ignore[arg-type]
        if isinstance(command, Arm):
            vehicle.home_enu_m = home_enu_m

    monkeypatch.setattr(FakeVehicle, "_obey", keep_home)


@pytest.mark.usefixtures("homes_stay")
async def test_one_whose_autopilot_keeps_its_home_elsewhere_stays_on_the_ground() -> None:
    flight = prepare(errors=EXACT)
    vehicle = switched_on_elsewhere(flight, 2)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 1)
        assert [type(one) for one in vehicle.commands] == [Arm, Disarm]
        assert (vehicle.armed, flight.task(2)) == (False, Task.IDLE)
        assert any("stays on the ground: its autopilot has its home 30.0 m from" in text for text in flight.texts())
        assert any(isinstance(one, Takeoff) for one in flight.fleet.members[1].commands)
        await flight.commands.act(Action.RETURN, None)
        await run


@pytest.mark.usefixtures("homes_stay")
async def test_a_script_does_not_take_off_with_it_either() -> None:
    clock = LoopClock()
    fleet = FakeFleet(clock, 2, None, EXACT)
    area_enu_m = ((-20.0, 0.0), (20.0, 0.0), (20.0, 60.0), (-20.0, 60.0))
    swarm = Swarm(fleet, clock, Journal(clock), ScriptOptions(vehicles=2, area_enu_m=area_enu_m))
    vehicle = fleet.members[2]
    vehicle.home_enu_m = vehicle.home_enu_m + np.array(ELSEWHERE)
    watching = asyncio.create_task(swarm.watch())
    await swarm.get_ready()
    with pytest.raises(MissionError, match=r"its autopilot has its home 30\.0 m from where it stands"):
        await swarm.take_off()
    watching.cancel()
    assert [type(one) for one in vehicle.commands] == [Arm, Disarm]
