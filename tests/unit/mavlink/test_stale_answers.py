"""An acknowledgement names its command and not its copy: the answer to an older command may meet a newer one."""

from __future__ import annotations

import asyncio

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.ports import Command, Goto, Hold, Land, ReturnToLaunch
from tests.fakes.mavlink_fleet import Network, open_network
from tests.fakes.mavlink_vehicle import FakeVehicle

pytestmark = pytest.mark.looptime

SET_MODE = mavlink.MAV_CMD_DO_SET_MODE
REPOSITION = mavlink.MAV_CMD_DO_REPOSITION
PX4_HOLD = 4 << 16 | 3 << 24
FAR = Goto(GeodeticPosition(48.0005, 14.0005, 335.0), 5.0)


def flying(autopilot: int) -> FakeVehicle:
    vehicle = FakeVehicle(1, autopilot=autopilot)
    vehicle.armed, vehicle.landed, vehicle.height_m = True, 2, 30.0
    vehicle.custom_mode = PX4_HOLD if autopilot == mavlink.MAV_AUTOPILOT_PX4 else 4
    return vehicle


async def answer_late(network: Network, vehicle: FakeVehicle, command: int) -> None:
    """Deliver the acknowledgement of an older command a moment after the newer one was sent."""
    await network.clock.sleep(0.1)
    network.deliver(vehicle.ack(command, mavlink.MAV_RESULT_ACCEPTED), next(iter(network.vehicles)))


@pytest.mark.parametrize("command", [Hold(), ReturnToLaunch(), Land()])
@pytest.mark.parametrize("autopilot", [mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, mavlink.MAV_AUTOPILOT_PX4])
async def test_a_lost_command_is_repeated_although_an_older_answer_arrives(command: Command, autopilot: int) -> None:
    vehicle = flying(autopilot)
    is_hold_of_px4 = isinstance(command, Hold) and autopilot == mavlink.MAV_AUTOPILOT_PX4
    wanted = REPOSITION if is_hold_of_px4 else SET_MODE
    lost = [True]
    vehicle.obeys = lambda message: None if message.command == wanted and lost and lost.pop() else True
    if is_hold_of_px4:
        # It has just been sent away, and begins to move after the hold was lost.
        vehicle.velocity_ned_cmps = (0, 0, 0)
    async with open_network(vehicle) as network:
        doing = asyncio.create_task(network.vehicle().execute(command, 10.0))
        await answer_late(network, vehicle, wanted)
        if is_hold_of_px4:
            await network.clock.sleep(0.2)
            vehicle.velocity_ned_cmps = (300, 0, 0)
        await doing
    assert len(vehicle.sent(wanted)) >= 2
    assert not is_hold_of_px4 or vehicle.velocity_ned_cmps == (0, 0, 0)
