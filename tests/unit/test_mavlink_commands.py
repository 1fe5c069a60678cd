from __future__ import annotations

import asyncio
import math

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
from tests.fakes.mavlink_fleet import open_network
from tests.fakes.mavlink_vehicle import HOME, FakeVehicle

pytestmark = pytest.mark.looptime

SET_MODE = mavlink.MAV_CMD_DO_SET_MODE
ARM = mavlink.MAV_CMD_COMPONENT_ARM_DISARM
TAKEOFF = mavlink.MAV_CMD_NAV_TAKEOFF
REPOSITION = mavlink.MAV_CMD_DO_REPOSITION
CHANGE_SPEED = mavlink.MAV_CMD_DO_CHANGE_SPEED
THERE = GeodeticPosition(48.0005, 14.0005, 335.0)
GOTO = Goto(THERE, 5.0)
PX4_HOLD = 4 << 16 | 3 << 24


def copter(system_id: int = 1, *, flying: bool = False) -> FakeVehicle:
    vehicle = FakeVehicle(system_id)
    if flying:
        vehicle.armed, vehicle.landed, vehicle.height_m, vehicle.custom_mode = True, 2, 30.0, 4
    return vehicle


def px4(*, flying: bool = False) -> FakeVehicle:
    vehicle = copter(flying=flying)
    vehicle.autopilot = mavlink.MAV_AUTOPILOT_PX4
    vehicle.custom_mode = PX4_HOLD if flying else 0
    return vehicle


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
        vehicle.landed = 1
        await network.clock.sleep(2.0)
        await network.vehicle().execute(Disarm(), 10.0)
    assert not vehicle.armed


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


# --- answers --------------------------------------------------------------------------------------------------------


async def test_a_lost_command_is_repeated_with_a_higher_confirmation() -> None:
    vehicle = copter(flying=True)
    vehicle.obeys = lambda message: True if message.confirmation == 2 else None
    async with open_network(vehicle) as network:
        await network.vehicle().execute(Land(), 10.0)
    assert [message.confirmation for message in vehicle.sent(SET_MODE)] == [0, 1, 2]


async def test_no_answer_is_a_timeout_at_the_deadline() -> None:
    vehicle = copter()
    vehicle.obeys = lambda _message: None
    async with open_network(vehicle) as network:
        with pytest.raises(CommandTimeoutError, match="did not acknowledge"):
            await network.vehicle().execute(Arm(), 3.0)
        assert network.clock.now_s() == pytest.approx(3.0, abs=0.01)


async def test_an_acceptance_without_effect_is_a_timeout() -> None:
    vehicle = copter()
    vehicle.custom_mode = 4
    async with open_network(vehicle) as network:
        vehicle._act = lambda _message: None  # type: ignore[method-assign]
        with pytest.raises(CommandTimeoutError, match="telemetry does not show it"):
            await network.vehicle().execute(Arm(), 3.0)
    assert len(vehicle.sent(ARM)) == 1


async def test_a_refusal_carries_the_words_of_the_autopilot_that_follow_it() -> None:
    vehicle = copter()
    vehicle.obeys = lambda message: mavlink.MAV_RESULT_FAILED if message.command == ARM else True
    async with open_network(vehicle) as network:
        arming = asyncio.create_task(network.vehicle().execute(Arm(), 10.0))
        await network.clock.sleep(0.5)
        network.deliver(vehicle.status_text("Arm: Compass not healthy"), next(iter(network.vehicles)))
        with pytest.raises(CommandRefusedError, match="Compass not healthy"):
            await arming


async def test_a_refusal_without_words_names_the_result() -> None:
    vehicle = copter(flying=True)
    vehicle.obeys = lambda _message: mavlink.MAV_RESULT_DENIED
    async with open_network(vehicle) as network:
        with pytest.raises(CommandRefusedError, match="denied"):
            await network.vehicle().execute(Land(), 10.0)


async def test_answers_to_other_stations_commands_and_components_do_not_count() -> None:
    vehicle = copter()
    vehicle.custom_mode = 4
    vehicle.obeys = lambda _message: None
    async with open_network(vehicle) as network:
        peer = next(iter(network.vehicles))
        arming = asyncio.create_task(network.vehicle().execute(Arm(), 2.0))
        await network.clock.sleep(0.1)
        denied = mavlink.MAV_RESULT_DENIED
        network.deliver(vehicle.ack(ARM, denied, target_system=255), peer)
        network.deliver(vehicle.ack(TAKEOFF, denied), peer)
        network.deliver(vehicle.camera.pack(mavlink.MAVLink_command_ack_message(ARM, denied, 0, 0, 254, 190)), peer)
        with pytest.raises(CommandTimeoutError):
            await arming


async def test_a_busy_vehicle_is_asked_again() -> None:
    vehicle = copter(flying=True)
    answers = iter([mavlink.MAV_RESULT_TEMPORARILY_REJECTED, mavlink.MAV_RESULT_TEMPORARILY_REJECTED])
    vehicle.obeys = lambda message: next(answers, True) if message.command == SET_MODE else None
    async with open_network(vehicle) as network:
        await network.vehicle().execute(Land(), 10.0)
        assert network.clock.now_s() > 2.0


async def test_progress_keeps_a_command_from_being_sent_again() -> None:
    vehicle = copter(flying=True)
    vehicle.obeys = lambda _message: mavlink.MAV_RESULT_IN_PROGRESS
    async with open_network(vehicle) as network:
        peer = next(iter(network.vehicles))
        landing = asyncio.create_task(network.vehicle().execute(Land(), 10.0))
        await network.clock.sleep(3.0)
        assert len(vehicle.sent(SET_MODE)) == 1
        vehicle.custom_mode = 9
        network.deliver(vehicle.ack(SET_MODE, mavlink.MAV_RESULT_ACCEPTED), peer)
        await landing


async def test_the_second_of_two_answers_counts() -> None:
    vehicle = px4(flying=True)
    vehicle.obeys = lambda _message: mavlink.MAV_RESULT_UNSUPPORTED
    async with open_network(vehicle) as network:
        peer = next(iter(network.vehicles))
        landing = asyncio.create_task(network.vehicle().execute(Land(), 10.0))
        await network.clock.sleep(0.2)
        network.deliver(vehicle.ack(SET_MODE, mavlink.MAV_RESULT_ACCEPTED), peer)
        await network.clock.sleep(1.0)
        vehicle.custom_mode = 4 << 16 | 6 << 24
        await landing


async def test_a_late_second_answer_can_refuse_what_the_first_accepted() -> None:
    vehicle = px4(flying=True)
    vehicle._act = lambda _message: None  # type: ignore[method-assign]
    async with open_network(vehicle) as network:
        landing = asyncio.create_task(network.vehicle().execute(Land(), 10.0))
        await network.clock.sleep(0.3)
        network.deliver(vehicle.ack(SET_MODE, mavlink.MAV_RESULT_DENIED), next(iter(network.vehicles)))
        with pytest.raises(CommandRefusedError, match="denied"):
            await landing


async def test_a_refused_repetition_does_not_undo_what_was_accepted() -> None:
    vehicle = copter()
    vehicle.armed, vehicle.custom_mode = True, 4
    vehicle.obeys = lambda _message: None  # slow to answer, like a long link
    async with open_network(vehicle) as network:
        peer = next(iter(network.vehicles))
        climbing = asyncio.create_task(network.vehicle().execute(Takeoff(20.0), 20.0))
        await network.clock.sleep(1.0)
        assert len(vehicle.sent(TAKEOFF)) == 2
        network.deliver(vehicle.ack(TAKEOFF, mavlink.MAV_RESULT_ACCEPTED), peer)
        network.deliver(vehicle.ack(TAKEOFF, mavlink.MAV_RESULT_FAILED), peer)
        await network.clock.sleep(5.0)
        vehicle.landed, vehicle.height_m = mavlink.MAV_LANDED_STATE_IN_AIR, 20.0
        await climbing
    assert len(vehicle.sent(TAKEOFF)) == 2


# --- goto and telemetry ---------------------------------------------------------------------------------------------


async def test_a_refused_goto_that_the_vehicle_flies_anyway_is_done() -> None:
    vehicle = px4(flying=True)

    def obey(message: mavlink.MAVLink_message) -> int:
        if message.command == REPOSITION:
            vehicle.target = (message.x, message.y, message.z)
        return int(mavlink.MAV_RESULT_UNSUPPORTED)

    vehicle.obeys = obey
    async with open_network(vehicle) as network:
        await network.vehicle().execute(GOTO, 10.0)


async def test_a_goto_that_is_accepted_and_ignored_times_out_and_was_repeated() -> None:
    vehicle = px4(flying=True)
    vehicle.target = (480001000, 140001000, 330.0)
    vehicle._act = lambda _message: None  # type: ignore[method-assign]
    async with open_network(vehicle) as network:
        peer = next(iter(network.vehicles))
        going = asyncio.create_task(network.vehicle().execute(GOTO, 5.0))
        await network.clock.sleep(1.0)
        network.deliver(vehicle.status_text("Reposition is outside geofence"), peer)
        with pytest.raises(CommandTimeoutError, match="outside geofence"):
            await going
    assert len(vehicle.sent(REPOSITION)) == 3


async def test_without_an_echo_the_vehicle_has_to_come_closer() -> None:
    vehicle = copter(flying=True)
    vehicle._act = lambda _message: None  # type: ignore[method-assign]
    async with open_network(vehicle) as network:
        going = asyncio.create_task(network.vehicle().execute(GOTO, 20.0))
        await network.clock.sleep(5.0)
        assert not going.done()
        vehicle.latitude_deg += 0.00005
        vehicle.longitude_deg += 0.00005
        await network.clock.sleep(1.0)
        assert going.done()
        await going


async def test_a_wrong_echo_of_arducopter_is_no_proof_against_it_and_its_acceptance_is_needed() -> None:
    vehicle = copter(flying=True)
    vehicle._act = lambda _message: None  # type: ignore[method-assign]
    vehicle.target = (480000050, 140000050, 300.35)
    vehicle.obeys = lambda _message: None
    async with open_network(vehicle) as network:
        going = asyncio.create_task(network.vehicle().execute(GOTO, 20.0))
        await network.clock.sleep(1.0)
        vehicle.latitude_deg -= 0.00005
        await network.clock.sleep(1.0)
        vehicle.latitude_deg += 0.00004
        await network.clock.sleep(1.0)
        assert not going.done()
        vehicle.obeys = lambda _message: True
        await network.clock.sleep(1.0)
        assert going.done()
        await going


async def test_arducopter_is_told_its_speed_after_it_has_taken_a_goto_over() -> None:
    vehicle = copter(flying=True)
    async with open_network(vehicle) as network:
        await network.vehicle().execute(GOTO, 10.0)
    sent = [message for message in vehicle.commands if message.command in (REPOSITION, CHANGE_SPEED)]
    assert [message.command for message in sent] == [REPOSITION, CHANGE_SPEED]
    assert (sent[-1].param1, sent[-1].param2) == (mavlink.SPEED_TYPE_GROUNDSPEED, GOTO.speed_mps)


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
