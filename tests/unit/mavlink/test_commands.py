"""Commands as vehicles receive them, and what several of them do to one another."""

from __future__ import annotations

import asyncio
import math
from dataclasses import replace

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.errors import CommandRefusedError, CommandTimeoutError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.ports import (
    Arm,
    Command,
    Disarm,
    FlightMode,
    Geofence,
    Goto,
    Hold,
    Land,
    ReturnToLaunch,
    Severity,
    Takeoff,
)
from tests.fakes.commanded import ARM, GOTO, REPOSITION, SET_MODE, TAKEOFF, copter, px4
from tests.fakes.mavlink_fleet import open_network
from tests.fakes.mavlink_vehicle import HOME, FakeVehicle

pytestmark = pytest.mark.looptime

TURN = mavlink.MAV_CMD_CONDITION_YAW


# --- what is sent ---------------------------------------------------------------------------------------------------


async def test_arducopter_is_armed_in_guided_and_takes_off_to_a_relative_height() -> None:
    vehicle = copter()
    async with open_network(vehicle) as network:
        await network.vehicle().execute(Arm(), 10.0)
        assert network.vehicle().state.armed
        await network.vehicle().execute(Takeoff(20.0), 20.0)
    assert [message.command for message in vehicle.commands if message.command in (SET_MODE, ARM, TAKEOFF)] == [
        SET_MODE,
        ARM,
        TAKEOFF,
    ]
    assert vehicle.sent(SET_MODE)[0].param2 == 4
    assert vehicle.sent(TAKEOFF)[0].param7 == 20.0


async def test_px4_is_armed_in_hold_and_takes_off_to_an_altitude_above_sea_level() -> None:
    vehicle = px4()
    async with open_network(vehicle) as network:
        await network.vehicle().execute(Arm(), 10.0)
        await network.vehicle().execute(Takeoff(20.0), 20.0)
    assert (vehicle.sent(SET_MODE)[0].param2, vehicle.sent(SET_MODE)[0].param3) == (4, 3)
    assert vehicle.sent(TAKEOFF)[0].param7 == HOME.altitude_amsl_m + 20.0


@pytest.mark.parametrize("make", [copter, px4])
async def test_goto_is_a_reposition_by_command_int_above_sea_level(make: type) -> None:
    vehicle = make(flying=True)
    async with open_network(vehicle) as network:
        await network.vehicle().execute(GOTO, 10.0)
    (message,) = vehicle.sent(REPOSITION)
    assert message.get_type() == "COMMAND_INT"
    assert message.frame == mavlink.MAV_FRAME_GLOBAL_INT
    assert (message.param1, message.param2) == (5.0, 0.0), "without a change of mode"
    assert (message.x, message.y, message.z) == (480005000, 140005000, 335.0)


async def test_px4_turns_by_the_reposition_and_arducopter_by_a_command_of_its_own() -> None:
    goto = replace(GOTO, heading_rad=math.pi)
    vehicle = px4(flying=True)
    async with open_network(vehicle) as network:
        await network.vehicle().execute(GOTO, 10.0)
        await network.vehicle().execute(goto, 10.0)
    kept, turned = (message.param4 for message in vehicle.sent(REPOSITION))
    assert math.isnan(kept)
    assert turned == pytest.approx(math.pi)
    vehicle = copter(flying=True)
    async with open_network(vehicle) as network:
        await network.vehicle().execute(goto, 10.0)
    (turn,) = vehicle.sent(TURN)
    assert (turn.param1, turn.param3, turn.param4) == (pytest.approx(180.0), 0.0, 0.0)
    assert vehicle.commands.index(turn) > vehicle.commands.index(vehicle.sent(REPOSITION)[0])


@pytest.mark.parametrize("answer", [mavlink.MAV_RESULT_UNSUPPORTED, None])
async def test_a_copter_that_does_not_turn_goes_there_all_the_same(answer: int | None) -> None:
    vehicle = copter(flying=True)
    vehicle.obeys = lambda message: answer if message.command == TURN else True
    async with open_network(vehicle) as network:
        await network.vehicle().execute(replace(GOTO, heading_rad=0.0), 10.0)
    assert vehicle.sent(REPOSITION)


@pytest.mark.parametrize(("command", "copter_mode", "px4_sub_mode"), [(ReturnToLaunch(), 6, 5), (Land(), 9, 6)])
async def test_modes_of_return_and_land(command: Command, copter_mode: int, px4_sub_mode: int) -> None:
    for vehicle in (copter(flying=True), px4(flying=True)):
        async with open_network(vehicle) as network:
            await network.vehicle().execute(command, 10.0)
        message = vehicle.sent(SET_MODE)[0]
        if vehicle.autopilot == mavlink.MAV_AUTOPILOT_PX4:
            assert (message.param2, message.param3) == (4, px4_sub_mode)
        else:
            assert message.param2 == copter_mode


async def test_hold_brakes_arducopter_and_repositions_px4_to_where_it_is() -> None:
    arducopter, px4_vehicle = copter(flying=True), px4(flying=True)
    for vehicle in (arducopter, px4_vehicle):
        async with open_network(vehicle) as network:
            await network.vehicle().execute(Hold(), 10.0)
            assert network.vehicle().state.mode is FlightMode.HOLD
    assert arducopter.sent(SET_MODE)[0].param2 == 17
    (message,) = px4_vehicle.sent(REPOSITION)
    assert message.param2 == 1.0
    assert all(math.isnan(value) for value in (message.param4, message.param5, message.param6, message.param7))


async def test_disarming_is_sent_only_on_the_ground() -> None:
    vehicle = copter(flying=True)
    async with open_network(vehicle) as network:
        for landed in (0, 2, 3, 4):
            vehicle.landed = landed
            await network.clock.sleep(0.5)
            with pytest.raises(CommandRefusedError, match="on the ground"):
                await network.vehicle().execute(Disarm(), 10.0)
        assert vehicle.sent(ARM) == []
        vehicle.landed, vehicle.height_m = 1, 4.0
        await network.clock.sleep(2.0)
        await network.vehicle().execute(Disarm(), 10.0)
    assert not vehicle.armed


async def test_a_vehicle_that_reports_a_landing_far_above_its_home_is_not_disarmed() -> None:
    vehicle = copter(flying=True)
    vehicle.landed = 1  # as when it was armed there
    async with open_network(vehicle) as network:
        await network.clock.sleep(2.0)
        network.vehicle()._commands._steps(Disarm())
        for vehicle.landed in (2, 1):
            await network.clock.sleep(2.0)
        with pytest.raises(CommandRefusedError, match="30 m above its home"):
            await network.vehicle().execute(Disarm(), 10.0)
    assert vehicle.sent(ARM) == []


async def test_a_ceiling_below_home_is_refused_before_anything_is_written() -> None:
    vehicle = copter()
    async with open_network(vehicle) as network:
        before = len(vehicle.commands)
        fence = Geofence(((48.0, 14.0), (48.0, 14.1), (48.1, 14.1)), ceiling_above_home_m=-3.0)
        with pytest.raises(CommandRefusedError, match="3 m below the home of vehicle 1: nothing was written"):
            await network.vehicle().upload_fence(fence, 10.0)
        assert len(vehicle.commands) == before


@pytest.mark.parametrize(
    "position",
    [
        GeodeticPosition(0.0, 0.0, 300.0),
        GeodeticPosition(48.0, 14.0, math.nan),
        GeodeticPosition(91.0, 14.0, 300.0),
    ],
)
async def test_impossible_positions_are_never_sent(position: GeodeticPosition) -> None:
    vehicle = copter(flying=True)
    async with open_network(vehicle) as network:
        with pytest.raises(CommandRefusedError):
            await network.vehicle().execute(Goto(position, 5.0), 10.0)
    assert vehicle.sent(REPOSITION) == []


async def test_goto_and_takeoff_on_the_ground_are_refused() -> None:
    async with open_network(copter()) as network:
        with pytest.raises(CommandRefusedError, match="take off first"):
            await network.vehicle().execute(GOTO, 10.0)
        with pytest.raises(CommandRefusedError, match="arm it"):
            await network.vehicle().execute(Takeoff(10.0), 10.0)


async def test_an_unknown_autopilot_is_never_commanded() -> None:
    vehicle = FakeVehicle(autopilot=mavlink.MAV_AUTOPILOT_GENERIC)
    async with open_network(vehicle) as network:
        assert network.vehicle().state.autopilot == "unknown"
        for command in (Arm(), Disarm(), Takeoff(5.0), GOTO, Hold(), ReturnToLaunch(), Land()):
            with pytest.raises(CommandRefusedError, match="not a PX4 or ArduPilot"):
                await network.vehicle().execute(command, 10.0)


# --- several commands and vehicles ----------------------------------------------------------------------------------


async def test_a_newer_command_supersedes_the_one_that_waits() -> None:
    vehicle = copter(flying=True)
    vehicle.obeys = lambda message: None if message.command == REPOSITION else True
    async with open_network(vehicle) as network:
        going = asyncio.create_task(network.vehicle().execute(GOTO, 30.0))
        await network.clock.sleep(1.0)
        await network.vehicle().execute(Hold(), 10.0)
        with pytest.raises(CommandRefusedError, match="superseded"):
            await going
        sent = len(vehicle.sent(REPOSITION))
        await network.clock.sleep(5.0)
        assert len(vehicle.sent(REPOSITION)) == sent


@pytest.mark.parametrize("make", [copter, px4])
async def test_a_waypoint_that_follows_a_landing_at_once_ends_it(make: type) -> None:
    """The heartbeat before it tells the mode before the landing, in which a waypoint would need no change of mode."""
    vehicle = make(flying=True)
    async with open_network(vehicle) as network:
        landing = asyncio.create_task(network.vehicle().execute(Land(), 10.0))
        await network.clock.sleep(0.02)
        assert vehicle.sent(SET_MODE)
        assert network.vehicle().state.mode is not FlightMode.LAND
        await network.vehicle().execute(GOTO, 10.0)
        with pytest.raises(CommandRefusedError, match="superseded"):
            await landing
    assert [message.param2 for message in vehicle.sent(REPOSITION)] == [1.0], "with a change of mode"


async def test_a_newer_command_of_the_same_value_supersedes_too() -> None:
    vehicle = copter(flying=True)
    vehicle.obeys = lambda _message: None
    async with open_network(vehicle) as network:
        first = asyncio.create_task(network.vehicle().execute(GOTO, 5.0))
        await network.clock.sleep(1.0)
        second = asyncio.create_task(network.vehicle().execute(GOTO, 5.0))
        results = await asyncio.gather(first, second, return_exceptions=True)
    assert [type(result) for result in results] == [CommandRefusedError, CommandTimeoutError]


async def test_a_refused_command_does_not_supersede_a_running_one() -> None:
    vehicle = copter(flying=True)
    vehicle.obeys = lambda _message: True if len(vehicle.commands) > 2 else None
    async with open_network(vehicle) as network:
        going = asyncio.create_task(network.vehicle().execute(GOTO, 10.0))
        await network.clock.sleep(0.1)
        with pytest.raises(CommandRefusedError):
            await network.vehicle().execute(Disarm(), 10.0)
        await going


async def test_a_silent_vehicle_delays_no_other() -> None:
    mute, healthy = copter(1), copter(2)
    mute.obeys = lambda _message: None
    async with open_network(mute, healthy) as network:
        waiting = asyncio.create_task(network.vehicle(1).execute(Arm(), 5.0))
        await network.vehicle(2).execute(Arm(), 5.0)
        assert network.clock.now_s() < 1.0
        with pytest.raises(CommandTimeoutError):
            await waiting
    assert not any(message.target_system != 1 for message in mute.commands)
    assert not any(message.target_system != 2 for message in healthy.commands)


async def test_a_vehicle_that_fell_silent_is_sent_home_but_nowhere_else() -> None:
    vehicle = copter(flying=True)
    vehicle.obeys = lambda message: True if message.command == SET_MODE else None
    async with open_network(vehicle) as network:
        network.silent.add(1)
        await network.clock.sleep(7.0)
        with pytest.raises(CommandRefusedError, match="silent"):
            await network.vehicle().execute(GOTO, 20.0)
        with pytest.raises(CommandTimeoutError):
            await network.vehicle().execute(ReturnToLaunch(), 12.0)
    assert vehicle.custom_mode == 6


async def test_a_system_id_used_twice_is_not_commanded() -> None:
    first, second = copter(1), copter(1)
    async with open_network(first, second) as network:
        await network.clock.sleep(2.0)
        with pytest.raises(CommandRefusedError, match="two vehicles use system id 1"):
            await network.vehicle().execute(Arm(), 10.0)
        assert [notice.severity for notice in network.notices].count(Severity.CRITICAL) == 1
    assert first.sent(ARM) == second.sent(ARM) == []


async def test_an_unhealthy_service_sends_no_heartbeats() -> None:
    vehicle = copter()
    async with open_network(vehicle) as network:
        await network.clock.sleep(5.05)
        assert vehicle.heard_heartbeats in (5, 6)
        network.is_healthy = False
        before = vehicle.heard_heartbeats
        await network.clock.sleep(5.0)
        assert vehicle.heard_heartbeats == before
