"""Heartbeats: ours, and those that introduce a vehicle."""

from __future__ import annotations

from pymavlink.dialects.v20 import ardupilotmega as mavlink

OUR_COMPONENT_ID: int = mavlink.MAV_COMP_ID_MISSIONPLANNER
HEARTBEAT_PERIOD_S = 1.0
_NO_VEHICLES = frozenset(
    {
        mavlink.MAV_TYPE_GCS,
        mavlink.MAV_TYPE_ANTENNA_TRACKER,
        mavlink.MAV_TYPE_ONBOARD_CONTROLLER,
        mavlink.MAV_TYPE_GIMBAL,
        mavlink.MAV_TYPE_ADSB,
        mavlink.MAV_TYPE_CAMERA,
    }
)


def our_heartbeat() -> mavlink.MAVLink_heartbeat_message:
    """Return the heartbeat of a ground station."""
    return mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE, 3
    )


def is_autopilot_heartbeat(message: mavlink.MAVLink_message) -> bool:
    """Return whether the message is the heartbeat of a vehicle's autopilot.

    Programs on companion computers often leave the fields at zero, which means a generic autopilot of a generic type.
    """
    if (
        message.get_msgId() != mavlink.MAVLINK_MSG_ID_HEARTBEAT
        or message.autopilot == mavlink.MAV_AUTOPILOT_INVALID
        or message.type in _NO_VEHICLES
    ):
        return False
    is_generic = message.autopilot == mavlink.MAV_AUTOPILOT_GENERIC or message.type == mavlink.MAV_TYPE_GENERIC
    return not is_generic or bool(message.get_srcComponent() == mavlink.MAV_COMP_ID_AUTOPILOT1)
