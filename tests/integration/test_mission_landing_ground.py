"""Vehicles that land where others stand on the ground; a fake fleet in virtual time."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aos_gcs.airspace.spacing import nearest_free
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Goto, Land
from tests.fakes.fleet import FakeVehicle
from tests.fakes.mission_flight import Flight, flying, prepare
from tests.fakes.paused_swarm import Paused, paused

pytestmark = pytest.mark.virtual

SEPARATION_M = 1.5


def park(flight: Flight, east_m: float, north_m: float) -> FakeVehicle:
    """Switch a spare vehicle on that stands somewhere, and takes no part."""
    number = max(flight.fleet.members) + 1
    spare = FakeVehicle(number, flight.clock, np.array([east_m, north_m, 0.0]), None)
    flight.fleet.members[number] = spare
    return spare


def beside_m(one: FakeVehicle, other: FakeVehicle) -> float:
    return math.dist(one.true_enu_m()[:2], other.true_enu_m()[:2])


async def above_one_that_has_landed(swarm: Paused) -> None:
    assert await swarm.land(1) == []
    await swarm.flight.until(lambda: swarm.flight.task(1) is Task.LANDED)
    landed_enu_m = swarm.vehicle(1).position_enu_m()
    await swarm.fly(2, float(landed_enu_m[0]) + 0.3, float(landed_enu_m[1]))


async def test_a_vehicle_is_not_landed_onto_one_that_has_landed() -> None:
    async with paused() as swarm:
        await above_one_that_has_landed(swarm)
        assert await swarm.land(2) == ["vehicle 1 stands on the ground below it: return it"]
        assert Land() not in swarm.vehicle(2).commands
        await swarm.fly(2, 0.0, 40.0)
        assert await swarm.land(2) == []
        await swarm.flight.until(lambda: swarm.flight.task(2) is Task.LANDED)


async def test_where_all_land_a_vehicle_moves_aside_from_one_that_has_landed() -> None:
    async with paused() as swarm:
        await above_one_that_has_landed(swarm)
        assert await swarm.land() == []
        await swarm.flight.until(lambda: all(swarm.flight.task(number) is Task.LANDED for number in (1, 2, 3)))
        assert beside_m(swarm.vehicle(1), swarm.vehicle(2)) > SEPARATION_M


async def test_spots_about_the_return_point_where_another_stands_are_passed_over() -> None:
    flight = prepare(3, None, return_enu_m=(0.0, -10.0))
    spare = park(flight, 3.0, -10.0)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 1)
        await flight.commands.act(Action.RETURN, None)
        await run
    vehicles = list(flight.fleet.members.values())
    nearest_m = min(beside_m(one, other) for one in vehicles[:3] for other in vehicles if other is not one)
    assert nearest_m > SEPARATION_M
    assert all(beside_m(one, spare) < 10.0 for one in vehicles[:3])


@pytest.mark.parametrize("numbers", [None, (2,)])
async def test_a_vehicle_whose_launch_point_is_occupied_lands_beside_it(numbers: tuple[int, ...] | None) -> None:
    flight = prepare(3, None)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 1)
        await flight.commands.act(Action.PAUSE, None)
        vehicle = flight.fleet.members[2]
        spare = park(flight, float(vehicle.home_enu_m[0]) + 0.5, float(vehicle.home_enu_m[1]))
        await flight.clock.sleep(1.0)
        await flight.commands.act(Action.RETURN, numbers)
        await flight.until(lambda: flight.task(2) is Task.LANDED)
        if not run.done() and numbers:
            await flight.commands.act(Action.ABORT, None)
        await run
    others = [other for other in flight.fleet.members.values() if other is not vehicle]
    assert min(beside_m(vehicle, other) for other in others) > SEPARATION_M
    assert beside_m(vehicle, spare) < 10.0
    assert "lands beside its landing place: vehicle 4 stands there" in flight.texts()


async def test_a_vehicle_that_is_parked_at_the_landing_place_meanwhile_sends_the_other_aside() -> None:
    flight = prepare(3, None)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 1)
        await flight.commands.act(Action.PAUSE, None)
        vehicle = flight.fleet.members[2]
        await flight.commands.act(Action.RETURN, (2,))
        await flight.until(lambda: isinstance(vehicle.commands[-1], Goto))
        spare = park(flight, float(vehicle.home_enu_m[0]), float(vehicle.home_enu_m[1]))
        await flight.until(lambda: flight.task(2) is Task.LANDED)
        await flight.commands.act(Action.ABORT, None)
        await run
    assert SEPARATION_M < beside_m(vehicle, spare) < 10.0


async def test_vehicles_whose_neighbours_stand_at_launch_distance_land_at_their_launch_points() -> None:
    flight = prepare(3, None)
    for number, vehicle in flight.fleet.members.items():
        vehicle.home_enu_m = vehicle.start_enu_m = vehicle.goal_enu_m = np.array([2.3 * number, 0.0, 0.0])
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 1)
        await flight.commands.act(Action.PAUSE, None)
        for number in (1, 3):
            await flight.commands.act(Action.RETURN, (number,))
            await flight.until(lambda number=number: flight.task(number) is Task.LANDED)  # type: ignore[misc]
        await flight.commands.act(Action.RETURN, None)
        await run
    for vehicle in flight.fleet.members.values():
        assert math.dist(vehicle.position_enu_m()[:2], vehicle.home_enu_m[:2]) < 0.6


def test_the_nearest_free_place_keeps_clear_of_all_that_is_taken() -> None:
    taken_m = np.array([[0.0, 0.0], [3.0, 0.0]])
    place_m = nearest_free(np.array([1.0, 0.0]), taken_m, np.array([2.0, 2.5]), lambda many_m: many_m[:, 1] < 0.0)
    assert place_m is not None
    assert place_m[1] < 0.0
    assert (np.linalg.norm(taken_m - place_m, axis=1) >= [2.0, 2.5]).all()
    assert np.linalg.norm(place_m - [1.0, 0.0]) < 3.0


def test_there_may_be_no_free_place() -> None:
    assert nearest_free(np.zeros(2), np.zeros((1, 2)), np.array([99.0]), lambda many_m: many_m[:, 1] < 0.0) is None
