"""Commands to vehicles, and when each counts as done."""

from __future__ import annotations

from dataclasses import dataclass

from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AboveHomeM


@dataclass(frozen=True, slots=True)
class Arm:
    """Arm the motors; done when the vehicle reports them armed."""


@dataclass(frozen=True, slots=True)
class Disarm:
    """Disarm on the ground. Refused by the driver while the vehicle is, or may be, in the air."""


@dataclass(frozen=True, slots=True)
class Takeoff:
    """Climb straight up; done when the height is within 1 m."""

    height_above_home_m: AboveHomeM


@dataclass(frozen=True, slots=True)
class Goto:
    """Fly straight to a position; done when telemetry shows that the vehicle has taken it over, not on arrival."""

    position: GeodeticPosition
    speed_mps: float
    heading_rad: float | None = None
    """Heading to turn to, clockwise from north; None: the autopilot's own rule. Nothing proves that it has turned."""


@dataclass(frozen=True, slots=True)
class Hold:
    """Stop and hold the position; done when the mode shows it."""


@dataclass(frozen=True, slots=True)
class ReturnToLaunch:
    """Hand over to the autopilot's own return; done when the mode shows it."""


@dataclass(frozen=True, slots=True)
class Land:
    """Land here; done when the mode shows it."""


Command = Arm | Disarm | Takeoff | Goto | Hold | ReturnToLaunch | Land
