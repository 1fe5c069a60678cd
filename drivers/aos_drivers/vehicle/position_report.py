"""Reports of position, read once for the two that take them in: telemetry and the track of poses."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.packet import LazyMessage
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AboveHomeM, AmslM

_UNKNOWN_UINT16 = 0xFFFF
_LOWEST_M, _HIGHEST_M = -1_000.0, 20_000.0
"""Altitudes above mean sea level beyond which no multicopter flies: INT32_MIN and INT32_MAX stand for unknown ones."""
_KEPT_AS = "position_report"
"""Attribute of the message that keeps what it was read as."""


@dataclass(slots=True)
class PositionReport:
    """Contents of a GLOBAL_POSITION_INT."""

    boot_ms: int
    position: GeodeticPosition | None
    velocity_enu_mps: tuple[float, float, float]
    relative_altitude_m: AboveHomeM
    heading_rad: float | None


def position_report(message: mavlink.MAVLink_global_position_int_message) -> PositionReport:
    """Return the contents of a message."""
    known: PositionReport | None = getattr(message, _KEPT_AS, None)
    if known is not None:
        return known
    if isinstance(message, LazyMessage):
        values = message.values()
    else:
        values = tuple(getattr(message, name) for name in message.ordered_fieldnames)
    boot_ms, latitude_e7, longitude_e7, altitude_mm, relative_mm, north_cmps, east_cmps, down_cmps, heading = values
    report = PositionReport(
        boot_ms,
        position_from_e7(latitude_e7, longitude_e7, AmslM(altitude_mm / 1000)),
        (east_cmps / 100, north_cmps / 100, -down_cmps / 100),
        AboveHomeM(relative_mm / 1000),
        math.radians(heading / 100 % 360.0) if heading != _UNKNOWN_UINT16 else None,
    )
    setattr(message, _KEPT_AS, report)
    return report


def position_from_e7(latitude_e7: int, longitude_e7: int, altitude_amsl_m: AmslM) -> GeodeticPosition | None:
    """Return the position of MAVLink's integers (1e-7 degrees), or None for what means "unknown" or is none."""
    if (latitude_e7 == 0 and longitude_e7 == 0) or not _LOWEST_M <= altitude_amsl_m <= _HIGHEST_M:
        return None
    if not (-90e7 <= latitude_e7 <= 90e7 and -180e7 <= longitude_e7 <= 180e7):
        return None
    return GeodeticPosition(latitude_e7 / 1e7, longitude_e7 / 1e7, altitude_amsl_m)
