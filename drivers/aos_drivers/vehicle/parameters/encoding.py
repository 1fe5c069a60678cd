"""Parameters of an autopilot, and the two ways in which MAVLink carries them."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import Enum, auto

from pymavlink.dialects.v20 import ardupilotmega as mavlink

_FLOATS = frozenset({mavlink.MAV_PARAM_TYPE_REAL32, mavlink.MAV_PARAM_TYPE_REAL64})


class ParameterEncoding(Enum):
    """Encoding of integers in the float of PARAM_VALUE and PARAM_SET."""

    CAST = auto()
    """Float of the same value: ArduPilot."""
    BYTEWISE = auto()
    """Float that has the integer's bytes: PX4."""

    def decode(self, value: float, kind: int) -> float:
        """Return the value that a message carries; ``kind`` is its MAV_PARAM_TYPE."""
        if self is ParameterEncoding.CAST or kind in _FLOATS:
            return value
        (number,) = struct.unpack("<i", struct.pack("<f", value))
        return float(number)

    def encode(self, value: float, kind: int) -> float:
        """Return the value that a message has to carry."""
        if self is ParameterEncoding.CAST or kind in _FLOATS:
            return value
        (carrier,) = struct.unpack("<f", struct.pack("<i", round(value)))
        return float(carrier)


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter as reported by the vehicle."""

    value: float
    kind: int
    """MAV_PARAM_TYPE, which a write has to repeat."""
