"""Settings of the search along the legs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from aos_gcs.errors import ConfigurationError

MIN_SWARM = 2
"""Number of vehicles below which a swarm does not go on; a mission of one vehicle is no swarm."""
LEAST_POD: Final = 0.05
GREATEST_POD: Final = 0.99
"""Probability of detection beyond which no search is planned: the law that predicts it is not known so well."""
MAX_LINE_SPACING_M: Final = 1000.0
"""Greatest distance of vehicles in a line, or of legs: more is a slip of the pen."""
MAX_PASSES: Final = 3
"""Greatest number of times that the legs are flown."""
MAX_LOOKING: Final = 100
"""Greatest number of vehicles of a close look that is set."""
FEWEST_SCANNING: Final = 3
"""Number of vehicles that must be left to scan on where some look closely."""


class SearchMode(StrEnum):
    """Flight of the swarm along its legs while nothing is in view."""

    CONTINUOUS = "continuous"
    """Flight without stops: the swarm flies on at the search speed and takes frames on the way."""
    STOPS = "stops"
    """Stops for each frame, as the swarm always makes them where something is in view."""


class LookOrder(StrEnum):
    """Time of a close look at what comes into view on a leg."""

    FIRST = "first"
    """The look comes at once."""
    GAIN = "gain"
    """The look comes at once where it is expected to find a person sooner than the scan, else behind the last leg."""


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """Settings of the search.

    Raises:
        ConfigurationError: a number is out of its range; the text names it.
    """

    mode: SearchMode = SearchMode.CONTINUOUS
    pod: float | None = None
    """Wanted probability of detection of a standing person, a mean over the search area; None: the legs are flown
    once, whatever they show."""
    line_spacing_m: float | None = None
    """Distance of neighbouring vehicles along the legs; None: that of the strategy, c4."""
    leg_spacing_m: float | None = None
    """Greatest distance of neighbouring legs; None: as wide as the swarm's line sees."""
    passes: int = 1
    """Number of times that all legs are flown, to and fro."""
    prior: str | None = None
    """GeoTIFF or GeoJSON file that says where the person is likely to be; None: all places are as likely."""
    segments: str | None = None
    """GeoJSON file of named polygons whose figures are told one by one; None: none."""
    split: bool = False
    """Whether vehicles that are not needed for a close look scan on; in continuous searches only."""
    look_vehicles: int = 5
    """Number of vehicles that look closely then."""
    looks: LookOrder = LookOrder.GAIN
    """Time of close looks, in continuous searches."""
    forget_min: float | None = None
    """Minutes after which views of a place no longer count, as somebody may have walked there since; None: never."""

    @property
    def fewest_to_split(self) -> int | None:
        """Number of vehicles from which a close look leaves others to scan on; None where it never does."""
        return self.look_vehicles + FEWEST_SCANNING if self.split and self.mode is SearchMode.CONTINUOUS else None

    def views_since_s(self, utc_s: float) -> float | None:
        """Return the UTC time from which on views count at a time; None: all count."""
        return None if self.forget_min is None else utc_s - 60.0 * self.forget_min

    def __post_init__(self) -> None:
        if not MIN_SWARM <= self.look_vehicles <= MAX_LOOKING:
            raise ConfigurationError(
                f"look_vehicles must lie within {MIN_SWARM} and {MAX_LOOKING}, but is {self.look_vehicles}."
            )
        if self.pod is not None and not LEAST_POD <= self.pod <= GREATEST_POD:
            raise ConfigurationError(f"pod must lie within {LEAST_POD:g} and {GREATEST_POD:g}, but is {self.pod}.")
        if not 1 <= self.passes <= MAX_PASSES:
            raise ConfigurationError(f"passes must lie within 1 and {MAX_PASSES}, but is {self.passes}.")
        if self.forget_min is not None and not (math.isfinite(self.forget_min) and self.forget_min > 0.0):
            raise ConfigurationError(
                f"forget_min must be a finite number above 0, or be left out for never, but is {self.forget_min}."
            )
        for name in ("line_spacing_m", "leg_spacing_m"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and 0.0 < value <= MAX_LINE_SPACING_M):
                raise ConfigurationError(f"{name} must be above 0 and at most {MAX_LINE_SPACING_M:g}, but is {value}.")
