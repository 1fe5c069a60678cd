"""A service that finds its vehicles in the air, such as one that was started again in mid-mission."""

from __future__ import annotations

import numpy as np
import pytest

from aos_gcs.api.convert.mission import allowed_actions
from aos_gcs.errors import MissionError
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import FlightMode, Hold, Land, ReturnToLaunch
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual


def in_the_air() -> Flight:
    """Vehicles hover in layers over the area before the mission has started."""
    flight = prepare(auto_start=False)
    for index, vehicle in enumerate(flight.fleet.members.values()):
        vehicle.armed = True
        vehicle.start_enu_m = vehicle.goal_enu_m = vehicle.home_enu_m + np.array([0.0, 30.0, 30.0 + 3.0 * index])
    return flight


def commands_of(flight: Flight) -> list[list[type]]:
    return [[type(command) for command in vehicle.commands] for vehicle in flight.fleet.members.values()]


async def until_checked(flight: Flight) -> None:
    await flight.until(lambda: flight.mission.phase is Phase.PREFLIGHT and len(flight.view.snapshot().preflight) > 0)


async def test_all_are_returned_by_their_autopilots_and_fly_the_mission_afterwards() -> None:
    flight = in_the_air()
    async with flying(flight) as run:
        await until_checked(flight)
        assert {Action.RETURN, Action.LAND} <= set(allowed_actions(flight.view.snapshot()))
        results = await flight.commands.act(Action.RETURN, None)
        assert [result.accepted for result in results] == [True] * 4
        assert commands_of(flight) == [[ReturnToLaunch]] * 4
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        assert not {Action.RETURN, Action.LAND} & set(allowed_actions(flight.view.snapshot()))
        await flight.commands.act(Action.START, None)
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        assert [flight.task(number) for number in (1, 2, 3, 4)] == [Task.SWARM] * 4
        await flight.commands.act(Action.RETURN, None)
        await run


async def test_a_hold_before_anything_is_heard_is_refused_and_holds_those_found_later() -> None:
    flight = in_the_air()
    members = dict(flight.fleet.members)
    flight.fleet.members.clear()
    async with flying(flight) as run:
        await flight.clock.sleep(1.0)
        with pytest.raises(MissionError, match="No vehicle is known to fly, so none was held"):
            await flight.commands.act(Action.HOLD, None)
        flight.fleet.members.update({1: members[1], 2: members[2]})
        await flight.clock.sleep(3.0)
        flight.fleet.members.update(members)
        await flight.clock.sleep(3.0)
        assert commands_of(flight) == [[Hold]] * 4
        await flight.commands.act(Action.ABORT, None)
        await run


@pytest.mark.parametrize(
    ("order", "holds"),
    [((Action.LAND, None), 0), ((Action.HOLD, (1,)), 1)],
    ids=["land all", "hold one"],
)
async def test_a_standing_hold_ends_by_another_order_and_not_by_a_hold_of_one(
    order: tuple[Action, tuple[int, ...] | None], holds: int
) -> None:
    flight = in_the_air()
    members = dict(flight.fleet.members)
    flight.fleet.members.pop(4)
    async with flying(flight) as run:
        await flight.clock.sleep(1.0)
        await flight.commands.act(Action.HOLD, None)
        await flight.commands.act(*order)
        flight.fleet.members.update(members)
        await flight.clock.sleep(3.0)
        assert commands_of(flight)[3].count(Hold) == holds
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_one_is_returned_while_the_others_hover() -> None:
    flight = in_the_air()
    async with flying(flight) as run:
        await until_checked(flight)
        (result,) = await flight.commands.act(Action.RETURN, (3,))
        assert result.accepted
        assert "by its autopilot" in result.text
        assert commands_of(flight) == [[], [], [ReturnToLaunch], []]
        await flight.commands.act(Action.ABORT, None)
        assert await run is Outcome.ABORTED


async def test_who_hovers_above_another_is_not_landed_on_it() -> None:
    flight = in_the_air()
    lower, upper = flight.fleet.members[1], flight.fleet.members[2]
    upper.start_enu_m = upper.goal_enu_m = lower.goal_enu_m + np.array([0.0, 0.0, 4.0])
    async with flying(flight) as run:
        await until_checked(flight)
        results = {result.vehicle_id: result for result in await flight.commands.act(Action.LAND, None)}
        assert commands_of(flight) == [[Land], [], [Land], [Land]]
        assert not results[2].accepted
        assert "vehicle 1 is or may come below it" in results[2].text
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_an_abort_brings_home_who_flies_and_leaves_pilots_alone() -> None:
    flight = in_the_air()
    flight.fleet.members[4].mode = FlightMode.MANUAL
    async with flying(flight) as run:
        await until_checked(flight)
        results = await flight.commands.act(Action.ABORT, None)
        assert await run is Outcome.ABORTED
    assert commands_of(flight) == [[ReturnToLaunch]] * 3 + [[]]
    assert [result.accepted for result in results] == [True] * 3 + [False]
    assert flight.view.snapshot().message == "Aborted: airborne vehicles return on their own."
