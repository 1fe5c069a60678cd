"""What differs between autopilots: one class each, found by the vehicle's heartbeat."""

from __future__ import annotations

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.mavlink.autopilots.arducopter import ArduCopter
from aos_drivers.mavlink.autopilots.base import Autopilot, Step, Target
from aos_drivers.mavlink.autopilots.px4 import Px4
from aos_drivers.mavlink.autopilots.setup import Setup
from aos_drivers.mavlink.autopilots.unknown import UnknownAutopilot

__all__ = ["Autopilot", "Setup", "Step", "Target", "autopilot_of"]

_MULTICOPTERS = frozenset(
    {
        mavlink.MAV_TYPE_QUADROTOR,
        mavlink.MAV_TYPE_COAXIAL,
        mavlink.MAV_TYPE_HELICOPTER,
        mavlink.MAV_TYPE_HEXAROTOR,
        mavlink.MAV_TYPE_OCTOROTOR,
        mavlink.MAV_TYPE_TRICOPTER,
        mavlink.MAV_TYPE_DODECAROTOR,
        mavlink.MAV_TYPE_DECAROTOR,
    }
)
_AUTOPILOTS: dict[int, Autopilot] = {
    mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA: ArduCopter(),
    mavlink.MAV_AUTOPILOT_PX4: Px4(),
}
_UNKNOWN = UnknownAutopilot()


def autopilot_of(heartbeat: mavlink.MAVLink_heartbeat_message) -> Autopilot:
    """Return the autopilot of a multicopter; everything else is observed and never commanded."""
    if heartbeat.type not in _MULTICOPTERS:
        return _UNKNOWN
    return _AUTOPILOTS.get(heartbeat.autopilot, _UNKNOWN)
