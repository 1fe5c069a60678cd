"""Vehicles that land: what is below them, also below the way to their stop; a fake fleet in virtual time."""

from __future__ import annotations

import numpy as np
import pytest

from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Hold, Land
from tests.fakes.paused_swarm import paused

pytestmark = pytest.mark.virtual

SEPARATION_M = 1.5


async def test_a_moving_vehicle_is_not_landed_onto_one_that_hovers_below_the_way_to_its_stop() -> None:
    async with paused() as swarm:
        await swarm.fly(1, 0.0, 70.0)
        await swarm.fly(3, 0.0, 20.0)
        await swarm.set_off(3, 88.0)
        await swarm.flight.until(lambda: bool(swarm.vehicle(3).position_enu_m()[1] > 53.0))
        assert await swarm.land(3) == [
            "vehicle 1 is or may come below it before it stops: hold it, then land it",
        ]
        assert Land() not in swarm.vehicle(3).commands
        await swarm.flight.commands.act(Action.HOLD, (3,))
        assert await swarm.land(3) == [], "it hovers beside vehicle 1"
        await swarm.flight.until(lambda: swarm.flight.task(3) is Task.LANDED)


async def test_a_moving_vehicle_lands_at_once_where_nobody_is_below_the_way_to_its_stop() -> None:
    async with paused() as swarm:
        await swarm.fly(1, 0.0, 70.0)
        await swarm.fly(3, 0.0, 20.0)
        await swarm.set_off(3, 60.0)
        await swarm.flight.until(lambda: bool(swarm.vehicle(3).position_enu_m()[1] > 25.0))
        assert await swarm.land(3) == []
        assert swarm.vehicle(3).commands[-1] == Land()


async def test_all_that_move_stop_before_they_land_and_move_apart_where_they_have_stopped() -> None:
    async with paused() as swarm:
        await swarm.fly(1, 0.0, 80.0)
        await swarm.fly(3, 0.0, 20.0)
        await swarm.set_off(1, 20.0)
        await swarm.set_off(3, 80.0)
        vehicles = swarm.vehicle(1), swarm.vehicle(3)
        first, third = vehicles
        await swarm.flight.until(lambda: bool(first.position_enu_m()[1] - third.position_enu_m()[1] < 1.0))
        told = [len(vehicle.commands) for vehicle in vehicles]
        assert await swarm.land() == []
        await swarm.flight.until(lambda: all(swarm.flight.task(number) is Task.LANDED for number in (1, 2, 3)))
        assert all(isinstance(vehicle.commands[before], Hold) for vehicle, before in zip(vehicles, told, strict=True))
        places_enu_m = [vehicle.true_enu_m() for vehicle in vehicles]
        assert np.linalg.norm(places_enu_m[0] - places_enu_m[1]) > SEPARATION_M


async def test_the_way_to_the_stop_of_a_vehicle_that_lands_is_kept_free_below() -> None:
    """The vehicle comes down anywhere on that way, and ends at the place where it stops."""
    async with paused() as swarm:
        await swarm.fly(1, -8.0, 40.0)
        await swarm.fly(3, 0.0, 20.0)
        await swarm.set_off(3, 60.0)
        await swarm.flight.until(lambda: bool(swarm.vehicle(3).position_enu_m()[1] > 22.0))
        across = swarm.roster.layers.at(swarm.member(1), np.array([8.0, 40.0, 0.0]))
        assert across is not None
        (before,) = swarm.control.vet({1: across})
        assert before.reason == ""
        lander = swarm.member(3)
        lander.last_command = Land()  # handed to the link: it still flies on as before
        (record,) = swarm.control.vet({1: across})
        assert "vehicle 3" in record.reason
        await swarm.flight.commands.act(Action.HOLD, None)
