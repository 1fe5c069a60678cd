"""Parameters of an autopilot and the two ways in which MAVLink carries them."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.errors import ConfigurationError


class ParameterType(Enum):
    """Types in use, by MAVLink's number."""

    INT8 = mavlink.MAV_PARAM_TYPE_INT8
    INT16 = mavlink.MAV_PARAM_TYPE_INT16
    INT32 = mavlink.MAV_PARAM_TYPE_INT32
    REAL32 = mavlink.MAV_PARAM_TYPE_REAL32


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter with its value after the factory setting."""

    name: str
    default: float
    type: ParameterType = ParameterType.REAL32


class ParameterEncoding(Enum):
    """Encoding of an integer in the float field of PARAM_VALUE and PARAM_SET."""

    CAST = "cast"
    """The float of the same value (ArduPilot)."""
    BYTEWISE = "bytewise"
    """Bytes of the integer, put where the float's would be (PX4)."""

    def encode(self, value: float, kind: ParameterType) -> float:
        """Return what to put into the float field."""
        if self is ParameterEncoding.CAST or kind is ParameterType.REAL32:
            return value
        return float(struct.unpack("<f", struct.pack("<i", int(value)))[0])

    def decode(self, field: float, kind: ParameterType) -> float:
        """Return the value in the float field."""
        if self is ParameterEncoding.CAST or kind is ParameterType.REAL32:
            return field
        return float(struct.unpack("<i", struct.pack("<f", field))[0])


class ParameterTable:
    """The parameters of one vehicle, in a fixed order."""

    def __init__(self, parameters: Iterable[Parameter]) -> None:
        self._parameters = {parameter.name: parameter for parameter in parameters}
        self._values = {name: parameter.default for name, parameter in self._parameters.items()}
        self._names = tuple(self._parameters)

    def __len__(self) -> int:
        return len(self._names)

    def __contains__(self, name: str) -> bool:
        return name in self._parameters

    def __getitem__(self, name: str) -> float:
        return self._values[name]

    def __setitem__(self, name: str, value: float) -> None:
        whole = self._parameters[name].type is not ParameterType.REAL32
        self._values[name] = float(round(value)) if whole else float(value)

    def override(self, values: Mapping[str, float]) -> None:
        """Set several parameters.

        Raises:
            ConfigurationError: one of them does not exist.
        """
        for name, value in values.items():
            if name not in self:
                raise ConfigurationError(f"The simulated autopilot has no parameter {name}; use one of its own names.")
            self[name] = value

    def kind(self, name: str) -> ParameterType:
        """Return the type of a parameter."""
        return self._parameters[name].type

    def index(self, name: str) -> int:
        """Return the place of a parameter in the list."""
        return self._names.index(name)

    def name_at(self, index: int) -> str | None:
        """Return the name at a place in the list, if there is one."""
        return self._names[index] if 0 <= index < len(self._names) else None

    def names(self) -> tuple[str, ...]:
        """Return all names in order."""
        return self._names
