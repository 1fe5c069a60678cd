"""Choice of the autopilot's class by its heartbeat."""

from __future__ import annotations

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.autopilots.arducopter import ArduCopter
from aos_drivers.vehicle.autopilots.base import Autopilot
from aos_drivers.vehicle.autopilots.px4 import Px4
from aos_drivers.vehicle.autopilots.unknown import UnknownAutopilot

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
