"""Vehicles of both autopilots that are sent commands, and what they are sent."""

from __future__ import annotations

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.ports import Goto
from tests.fakes.mavlink_vehicle import FakeVehicle

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
