"""Choice of the autopilot's class by its heartbeat."""

from __future__ import annotations

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.autopilots.arducopter import ArduCopterDialect
from aos_drivers.vehicle.autopilots.base import AutopilotDialect
from aos_drivers.vehicle.autopilots.px4 import Px4Dialect
from aos_drivers.vehicle.autopilots.unknown import UnknownDialect

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
_DIALECTS: dict[int, AutopilotDialect] = {
    mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA: ArduCopterDialect(),
    mavlink.MAV_AUTOPILOT_PX4: Px4Dialect(),
}
_UNKNOWN = UnknownDialect()


def dialect_of(heartbeat: mavlink.MAVLink_heartbeat_message) -> AutopilotDialect:
    """Return the autopilot of a multicopter; everything else is observed and never commanded."""
    if heartbeat.type not in _MULTICOPTERS:
        return _UNKNOWN
    return _DIALECTS.get(heartbeat.autopilot, _UNKNOWN)
