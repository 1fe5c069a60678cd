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

    def further(self, found: Found) -> tuple[tuple[str, ...], ...]:
        """Return parameters that every vehicle with these ``found`` ones has, in the form of ``required``."""
        del found
        return ()

    @abstractmethod
    def arming_checks(self, found: Found) -> Safeguard:
        """Return whether the autopilot checks itself before it arms."""

    @abstractmethod
    def other_failsafes(self, found: Found) -> Safeguard:
        """Return the failsafes for a lost position estimate and a lost remote control."""

    @abstractmethod
    def return_place(self, found: Found, rally_points: int) -> Safeguard:
        """Return whether the return ends at the launch point; ``rally_points`` are stored on the vehicle."""

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


MAX_LINK_LOSS_S = 60.0
"""Longest time without our heartbeats after which a failsafe may act."""


def after_silence(action: str, found: Found, names: tuple[str, str], default_s: float) -> Safeguard:
    """Return the link-loss failsafe that takes an action after the seconds of a parameter.

    Args:
        action: what the vehicle does.
        found: the parameters that were read.
        names: names of the parameters for the action and for the seconds.
        default_s: seconds of versions without that parameter.
    """
    action_name, timeout_name = names
    timeout_s = found[timeout_name].value if timeout_name in found else default_s
    text = f"{action} after {timeout_s:g} s ({setting(found, action_name)})"
    if timeout_s > MAX_LINK_LOSS_S:
        return Safeguard(False, text, f"set {timeout_name} to {MAX_LINK_LOSS_S:g} or less")
    return Safeguard(True, text)


def rally_safeguard(rally_points: int) -> Safeguard | None:
    """Return why rally points are no place to return to; None without any."""
    if not rally_points:
        return None
    points = "a rally point" if rally_points == 1 else f"one of {rally_points} rally points"
    remedy = "delete them with another ground station: two vehicles with the same one land beside each other"
    return Safeguard(False, points, remedy)


def setting(found: Found, name: str) -> str:
    """Return a parameter in words: ``FS_GCS_ENABLE = 1``."""
    return f"{name} = {found[name].value:g}"


def first_of(found: Found, *names: str) -> str:
    """Return the first of several names that the vehicle knows."""
    return next(name for name in names if name in found)
