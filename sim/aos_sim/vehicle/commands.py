"""COMMAND_LONG and COMMAND_INT in one form, and refusals of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AmslM

AMSL_FRAMES = (mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_FRAME_GLOBAL_INT)
RELATIVE_FRAMES = (mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT)
KEEP_DEG = (2**31 - 1) / 1e7
"""The coordinate of a COMMAND_INT that stands for "keep"."""

TERRAIN_FRAMES = (mavlink.MAV_FRAME_GLOBAL_TERRAIN_ALT, mavlink.MAV_FRAME_GLOBAL_TERRAIN_ALT_INT)


@dataclass(frozen=True, slots=True)
class Refusal:
    """Reason why something that was asked of the vehicle is not done."""

    text: str
    """Status text that tells it."""


@dataclass(frozen=True, slots=True)
class CommandRequest:
    """A command addressed to us."""

    command: int
    params: tuple[float, ...]
    """Parameters 1 to 7; 5 and 6 are degrees where the command has a place."""
    frame: int | None
    """Frame of a COMMAND_INT; None for a COMMAND_LONG."""
    source_system: int
    source_component: int

    @classmethod
    def of(cls, message: mavlink.MAVLink_message) -> CommandRequest:
        """Read a COMMAND_LONG or COMMAND_INT."""
        source = (message.get_srcSystem(), message.get_srcComponent())
        first_four = (message.param1, message.param2, message.param3, message.param4)
        if message.get_type() == "COMMAND_INT":
            params = (*first_four, message.x / 1e7, message.y / 1e7, message.z)
            return cls(message.command, params, message.frame, *source)
        params = (*first_four, message.param5, message.param6, message.param7)
        return cls(message.command, params, None, *source)

    def param(self, number: int) -> float:
        """Return parameter 1 to 7."""
        return self.params[number - 1]

    def finite_or_none(self, number: int) -> float | None:
        """Return a parameter, None where it is NaN ("keep as it is")."""
        value = self.param(number)
        return value if math.isfinite(value) else None

    def place_valid(self) -> bool:
        """Whether parameters 5 and 6 are a latitude and a longitude other than 0, 0."""
        latitude_deg, longitude_deg = self.param(5), self.param(6)
        return (
            math.isfinite(latitude_deg)
            and math.isfinite(longitude_deg)
            and abs(latitude_deg) <= 90.0
            and abs(longitude_deg) <= 180.0
            and (latitude_deg, longitude_deg) != (0.0, 0.0)
        )

    def keeps_place(self) -> bool:
        """Whether parameters 5 and 6 say "where you are": NaN, or the greatest integer in a COMMAND_INT."""
        return all(math.isnan(self.param(number)) or self.param(number) == KEEP_DEG for number in (5, 6))

    def geodetic(self, altitude_amsl_m: AmslM) -> GeodeticPosition:
        """Return the place of parameters 5 and 6 at an altitude."""
        return GeodeticPosition(self.param(5), self.param(6), altitude_amsl_m)


def is_addressed_to(message: mavlink.MAVLink_message, system_id: int, accepts_broadcast: bool) -> bool:
    """Whether a message is meant for a system; messages without a target are meant for all."""
    target = getattr(message, "target_system", None)
    return target is None or target == system_id or (target == 0 and accepts_broadcast)
