"""Answers to commands: when one counts as done, refused, or lost."""

from __future__ import annotations

import asyncio

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.errors import CommandRefusedError, CommandTimeoutError
from aos_gcs.ports import (
    Arm,
    Land,
    Takeoff,
)
from tests.fakes.commanded import ARM, CHANGE_SPEED, GOTO, REPOSITION, SET_MODE, TAKEOFF, THERE, copter, px4
from tests.fakes.mavlink_fleet import open_network

pytestmark = pytest.mark.looptime


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


@pytest.mark.parametrize("answer", [True, mavlink.MAV_RESULT_UNSUPPORTED])
async def test_a_goto_close_to_the_former_one_is_done_once_it_was_heard(answer: bool | int) -> None:
    vehicle = px4(flying=True)
    vehicle.obeys = lambda _message: None if len(vehicle.sent(REPOSITION)) < 3 else answer
    vehicle.target = (round(THERE.latitude_deg * 1e7), round(THERE.longitude_deg * 1e7), THERE.altitude_amsl_m + 1.5)
    async with open_network(vehicle) as network:
        await network.clock.sleep(1.0)
        await network.vehicle().execute(GOTO, 10.0)
    assert len(vehicle.sent(REPOSITION)) == 3


async def test_a_refused_goto_close_to_the_former_one_is_not_done() -> None:
    vehicle = px4(flying=True)
    vehicle.obeys = lambda _message: int(mavlink.MAV_RESULT_DENIED)
    vehicle.target = (round(THERE.latitude_deg * 1e7), round(THERE.longitude_deg * 1e7), THERE.altitude_amsl_m + 1.5)
    async with open_network(vehicle) as network:
        await network.clock.sleep(1.0)
        with pytest.raises(CommandRefusedError, match="denied"):
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
