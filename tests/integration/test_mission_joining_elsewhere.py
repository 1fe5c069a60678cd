"""Vehicles that join from where they have landed, away from their launch points, on a fake fleet in virtual time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.mission.fleet.reinforcements import launch_place
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import PreflightSettings
from aos_gcs.ports import Arm, Disarm, Takeoff
from tests.fakes.fleet import FRAME, FakeVehicle
from tests.fakes.joining import paused
from tests.fakes.mission_flight import EXACT, Flight, flying, prepare

pytestmark = pytest.mark.virtual

FAR = (0.0, -30.0, -3.0)
"""A place behind the launch points, below them."""


async def down_at(flight: Flight, number: int, place_enu_m: tuple[float, float, float]) -> FakeVehicle:
    """Have a vehicle of the swarm land, and stand at a place then; return it."""
    await paused(flight)
    await flight.commands.act(Action.LAND, (number,))
    await flight.until(lambda: flight.task(number) is Task.LANDED)
    vehicle = flight.fleet.members[number]
    vehicle.start_enu_m = vehicle.goal_enu_m = np.array(place_enu_m)
    await flight.clock.sleep(1.0)
    return vehicle


async def join(flight: Flight, number: int) -> str:
    """Have a vehicle join, wait for its motors, and return what the mission answers."""
    (result,) = await flight.commands.act(Action.JOIN, (number,))
    await flight.clock.sleep(5.0)
    return result.text


def started(vehicle: FakeVehicle) -> list[type]:
    """Return the commands since a vehicle has landed by which its motors start and stop."""
    return [type(one) for one in vehicle.commands[3:] if isinstance(one, (Arm, Disarm, Takeoff))]


def by_satellites(vehicle: FakeVehicle) -> None:
    """Let the corrections of a vehicle's receiver fail."""
    vehicle.gps_fix = 3


async def test_where_rtk_has_measured_the_ground_its_layer_counts_from_there() -> None:
    flight = prepare(errors=EXACT, preflight=PreflightSettings(upload_fence=True, set_return_height=True))
    async with flying(flight) as run:
        vehicle = await down_at(flight, 2, FAR)
        assert await join(flight, 2) == "takes off and flies to the swarm"
        (climb,) = [one for one in vehicle.commands[3:] if isinstance(one, Takeoff)]
        layer_m = flight.view.snapshot().vehicles[1].layer_height_m
        assert layer_m is not None
        assert climb.height_above_home_m == pytest.approx(layer_m + 3.0, abs=0.05)
        assert vehicle.return_height_m == pytest.approx(layer_m + 3.0, abs=0.1)
        await flight.until(lambda: flight.task(2) is Task.SWARM)
        assert vehicle.position_enu_m()[2] == pytest.approx(layer_m, abs=0.05)
        assert flight.view.snapshot().vehicles[1].altitude_offset_m == pytest.approx(0.0, abs=0.05)
        await flight.commands.act(Action.ABORT, None)
        await run
    assert vehicle.position_enu_m() == pytest.approx(FAR, abs=0.6), "it returns to where its autopilot would"


async def test_lower_ground_where_it_lands_is_no_error_of_its_altitude() -> None:
    flight = prepare(errors=EXACT)
    async with flying(flight) as run:
        await paused(flight)
        await flight.commands.act(Action.LAND, (2,))
        vehicle = flight.fleet.members[2]
        vehicle.fly_to(np.array([*vehicle.position_enu_m()[:2], -3.0]))
        await flight.until(lambda: flight.task(2) is Task.LANDED)
        snapshot = flight.view.snapshot().vehicles[1]
        assert snapshot.altitude_offset_m == pytest.approx(0.0, abs=0.1)
        assert snapshot.position_enu_m is not None
        assert snapshot.position_enu_m[2] == pytest.approx(-3.0, abs=0.1)
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_where_it_lands_beside_its_launch_point_that_stays_as_it_is() -> None:
    flight = prepare(errors=EXACT)
    async with flying(flight) as run:
        home_enu_m = flight.fleet.members[2].home_enu_m
        vehicle = await down_at(flight, 2, (float(home_enu_m[0]) + 0.6, float(home_enu_m[1]), 0.0))
        assert await join(flight, 2) == "takes off and flies to the swarm"
        assert vehicle.home_enu_m[0] == pytest.approx(home_enu_m[0] + 0.6)
        assert flight.view.snapshot().vehicles[1].home_enu_m == pytest.approx(home_enu_m, abs=0.1)
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_on_ground_of_unknown_height_its_motors_do_not_start_until_it_is_carried_back() -> None:
    flight = prepare(errors=EXACT)
    async with flying(flight) as run:
        vehicle = await down_at(flight, 2, (0.0, -30.0, 0.0))
        by_satellites(vehicle)
        text = await join(flight, 2)
        assert text.startswith("stands 30 m from its launch point, and the height of the ground there is not known")
        assert "carry it back" in text
        assert (started(vehicle), flight.task(2)) == ([], Task.LANDED)
        vehicle.start_enu_m = vehicle.goal_enu_m = vehicle.home_enu_m
        vehicle.gps_fix = 6
        assert await join(flight, 2) == "takes off and flies to the swarm"
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_one_that_was_restarted_where_it_stands_joins_on_level_ground_only() -> None:
    flight = prepare(errors=EXACT)
    async with flying(flight) as run:
        vehicle = await down_at(flight, 2, FAR)
        vehicle.home_enu_m = np.array(FAR)
        roster = flight.mission.sortie.context.roster
        assert roster.ground is not None
        roster.ground = replace(roster.ground, measured_level_amsl_m=None)
        assert "home altitude: 3.0 m below the median of all" in await join(flight, 2)
        assert started(vehicle) == []
        vehicle.home_enu_m = vehicle.start_enu_m = vehicle.goal_enu_m = np.array([0.0, -30.0, 0.0])
        assert await join(flight, 2) == "takes off and flies to the swarm"
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_an_elevation_model_says_how_high_the_ground_is_where_nothing_was_measured(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    flight = prepare(errors=EXACT)
    async with flying(flight) as run:
        vehicle = await down_at(flight, 2, FAR)
        roster = flight.mission.sortie.context.roster
        assert roster.ground is not None
        roster.ground = replace(roster.ground, measured_level_amsl_m=None)
        assert (await join(flight, 2)).startswith("stands 3")
        monkeypatch.setattr(launch_place, "_rise_m", lambda _context, _known_enu_m, here_enu_m: here_enu_m[1] / 10.0)
        assert await join(flight, 2) == "takes off and flies to the swarm"
        (climb,) = [one for one in vehicle.commands[3:] if isinstance(one, Takeoff)]
        layer_m = flight.view.snapshot().vehicles[1].layer_height_m
        assert layer_m is not None
        assert climb.height_above_home_m == pytest.approx(layer_m + 3.0, abs=0.05)
        await flight.commands.act(Action.ABORT, None)
        await run


@pytest.mark.parametrize(
    ("moved_m", "reason"),
    [((0.0, 0.0, -0.5), "moved its home by -0.5 m in height"), ((0.0, 12.0, 0.0), "its home 12.0 m from where it")],
)
async def test_a_home_that_is_not_where_it_was_assumed_after_arming_stops_the_motors(
    monkeypatch: pytest.MonkeyPatch, moved_m: tuple[float, float, float], reason: str
) -> None:
    flight = prepare(errors=EXACT)
    obey = FakeVehicle._obey

    def arm_elsewhere(vehicle: FakeVehicle, command: object) -> None:
        obey(vehicle, command)  # type: ignore[arg-type]
        if isinstance(command, Arm) and vehicle.vehicle_id == 2:
            vehicle.home_enu_m = vehicle.home_enu_m + moved_m
            if moved_m[2]:
                vehicle.start_enu_m = vehicle.goal_enu_m = vehicle.home_enu_m

    async with flying(flight) as run:
        vehicle = await down_at(flight, 2, (0.0, -30.0, 0.0))
        monkeypatch.setattr(FakeVehicle, "_obey", arm_elsewhere)
        await join(flight, 2)
        assert started(vehicle) == [Arm, Disarm]
        assert any(f"stays on the ground: its autopilot has {reason}" in text for text in flight.texts())
        assert (vehicle.armed, flight.task(2)) == (False, Task.IDLE)
        monkeypatch.setattr(FakeVehicle, "_obey", obey)
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_vehicle_above_the_place_where_it_stands_keeps_it_down_after_its_motors_have_started() -> None:
    flight = prepare(errors=EXACT)
    async with flying(flight) as run:
        vehicle, other = await down_at(flight, 2, (0.0, -30.0, 0.0)), flight.fleet.members[1]
        away_enu_m = other.goal_enu_m
        execute = vehicle.execute

        async def arm_late(command: object, deadline_s: float) -> None:
            await execute(command, deadline_s)  # type: ignore[arg-type]
            if isinstance(command, Arm):
                other.start_enu_m = other.goal_enu_m = np.array([0.3, -30.0, away_enu_m[2]])

        vehicle.execute = arm_late  # type: ignore[method-assign]
        assert await join(flight, 2) == "takes off and flies to the swarm"
        assert started(vehicle) == [Arm, Disarm]
        text = "stays on the ground: vehicle 1 is or may come above its launch point: try again when it has passed"
        assert text in flight.texts()
        other.start_enu_m = other.goal_enu_m = away_enu_m
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_nobody_takes_off_beside_the_launch_point_of_another_that_may_land_there() -> None:
    flight = prepare(errors=EXACT)
    async with flying(flight) as run:
        home_enu_m = FRAME.to_enu(flight.fleet.members[3].state.home)  # type: ignore[arg-type]
        vehicle = await down_at(flight, 2, (float(home_enu_m[0]), float(home_enu_m[1]) - 1.0, 0.0))
        text = await join(flight, 2)
        assert text.startswith("stands 1.0 m from the launch point of vehicle 3, which may land there: carry it")
        assert started(vehicle) == []
        await flight.commands.act(Action.ABORT, None)
        await run
