"""Meaning of an autopilot's parameters for its failsafes, its fence and its return."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

from aos_drivers.vehicle.parameters.encoding import Parameter, ParameterEncoding
from aos_gcs.ports import Safeguard

Found = Mapping[str, Parameter]
"""The parameters that were read, by name."""


class Setup(ABC):
    """Names and meaning of one autopilot's parameters. Holds no state: one instance serves all its vehicles."""

    encoding: ClassVar[ParameterEncoding]
    required: ClassVar[tuple[tuple[str, ...], ...]]
    """Parameters of every version; a tuple holds the older and newer names of the same parameter."""
    optional: ClassVar[tuple[str, ...]] = ()
    """Parameters that some vehicles lack."""

    @abstractmethod
    def link_loss(self, found: Found, our_system_id: int) -> Safeguard:
        """Return the failsafe for the loss of our heartbeats."""

    @abstractmethod
    def low_battery(self, found: Found) -> Safeguard:
        """Return the failsafe for a low battery."""

    @abstractmethod
    def at_fence(self, found: Found) -> Safeguard:
        """Return the action at a polygon of the fence."""

    @abstractmethod
    def ceiling_m(self, found: Found) -> float | None:
        """Return the greatest height above home, None without a limit."""

    @abstractmethod
    def radius_m(self, found: Found) -> float | None:
        """Return the greatest distance from home, None without a limit."""

    @abstractmethod
    def return_height_m(self, found: Found) -> float:
        """Return the height above home to which it climbs, if it is lower, before it returns."""

    @abstractmethod
    def return_climb_m(self, found: Found) -> float:
        """Return how far it climbs before it returns, however high it is."""

    @abstractmethod
    def return_parameters(self, found: Found, height_m: float) -> dict[str, float]:
        """Return the values with which it climbs to this height above home, and no higher, before it returns."""

    @abstractmethod
    def fence_parameters(self, found: Found, ceiling_m: float | None) -> dict[str, float]:
        """Return the values with which the polygons and the ceiling are kept, and nothing else limits the flight.

        An action that the owner has chosen for the fence is kept, unless it is to do nothing.
        """


def setting(found: Found, name: str) -> str:
    """Return a parameter in words: ``FS_GCS_ENABLE = 1``."""
    return f"{name} = {found[name].value:g}"


def first_of(found: Found, *names: str) -> str:
    """Return the first of several names that the vehicle knows."""
    return next(name for name in names if name in found)
