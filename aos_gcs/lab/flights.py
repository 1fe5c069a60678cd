"""Port of the laboratory to simulated flights, found through the entry points ``aos_gcs.flights``.

A flight is a forest with or without a person and with things that may be taken for one, and the vehicles of a swarm by
the port of drivers (:mod:`aos_gcs.ports`), all in this process: their time is that of a clock, which may be virtual.
Frame: ENU metres, the ground is the plane z = 0, or a relief with the height 0 at the origin, where the vehicles stand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.lab.simulator import simulator_part
from aos_gcs.ports import Clock, Fleet

GROUP = "aos_gcs.flights"
Place = tuple[float, float]
"""East and north."""
LEVEL_GROUND = "flat"


@dataclass(frozen=True, slots=True)
class FlightParameters:
    """Parameters of a simulated flight; equal ones give equal flights of equal missions."""

    seed: int
    vehicles: int
    trees_per_ha: float
    has_person: bool
    errors: str = "rtk"
    """Grade of the errors of vehicles and cameras: ``none``, ``rtk`` or ``gnss``."""
    conditions: str = "cool"
    """Weather and time of day, or a hardship for the decision, in the simulator's words."""
    side_m: float = 60.0
    """Side of the forest, which is a square and the search area."""
    image_size_px: int = 512
    terrain: str = LEVEL_GROUND
    """Shape of the ground: ``flat``, ``hills`` or ``slope:PERCENT``, rising to the north from the launch site on."""
    launch_spacing_m: float = 5.0
    """Distance of neighbouring launch points."""


class Flight(Protocol):
    """A simulated world with its swarm."""

    @property
    def origin(self) -> GeodeticPosition:
        """Origin of the frame."""
        ...

    @property
    def area_enu_m(self) -> tuple[Place, ...]:
        """Corners of the search area."""
        ...

    @property
    def persons_enu_m(self) -> Sequence[Place]:
        """Places of the persons at the beginning."""
        ...

    def persons_at(self, utc_s: float) -> Sequence[Place]:
        """Return the places of the persons at a time of the clock that the fleet was switched on with."""
        ...

    @property
    def postures(self) -> Sequence[str]:
        """Posture of each person, in the simulator's words."""
        ...

    @property
    def highest_ground_m(self) -> float:
        """Height of the highest place of the search area; 0 on level ground."""
        ...

    def write_ground(self, path: Path) -> bool:
        """Write the ground as an elevation model, a GeoTIFF of heights above the sea; False where it is level.

        Raises:
            ConfigurationError: a library is not installed, or the file cannot be written.
        """
        ...

    @property
    def min_height_above_ground_m(self) -> float | None:
        """Smallest true height of a vehicle above a relief so far, away from its launch point; None on level ground."""
        ...

    @property
    def min_separation_m(self) -> float | None:
        """Smallest true 3-D distance of two vehicles so far; None with a single one."""
        ...

    @property
    def landed(self) -> int:
        """Number of vehicles that stand on the ground, disarmed."""
        ...

    def fleet(self, clock: Clock) -> Fleet:
        """Switch the vehicles on and return them; once per flight."""
        ...


class FlightBuilder(Protocol):
    """Entry point of the group: it builds a flight."""

    def __call__(self, settings: FlightParameters) -> Flight:
        """Return the flight of these settings; takes seconds.

        Raises:
            ConfigurationError: a value is out of its range.
        """
        ...


def build_flight(settings: FlightParameters) -> Flight:
    """Return the flight that the installed simulator builds.

    Raises:
        ConfigurationError: no simulator is installed, or it refuses the settings.
    """
    build: FlightBuilder = simulator_part(GROUP, "fly a mission")
    return build(settings)
