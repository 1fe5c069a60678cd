"""Settings, searches and results of the study of searches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import numpy as np

from aos_gcs.errors import ConfigurationError
from aos_gcs.groundmap.detection import Posture
from aos_gcs.imaging.step.settings import MAX_RATE_HZ, ImagingSettings
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.search_settings import GREATEST_POD, LEAST_POD
from aos_gcs.planning.settings import ForestSettings

CANOPY_HEIGHT_M: Final = 18.0
CROWN_BASE_M: Final = 4.4
_OCCLUSION: Final = ((0.0, 0.0), (150.0, 0.53), (300.0, 0.84), (500.0, 0.96), (1000.0, 0.99))
"""Trees per hectare, and share of the ground that one image does not see (docs/ground-map.md), with ends that are
guessed."""
_MOST_HECTARES: Final = 50.0
_MOST_VEHICLES: Final = 50


class Method(StrEnum):
    """Flight by which an area is searched."""

    PLANNED = "planned"
    """Line and legs planned for the wanted probability of detection, in flight; all views count together."""
    TWICE = "twice"
    """The same with two passes over all legs, at a greater speed."""
    PRIOR = "prior"
    """The planned flight with its legs in the order of the prior by which persons are drawn."""
    LINE = "line"
    """The line of close looks along legs one swath apart, 5 m/s; all views count together."""
    CHOSEN = "chosen"
    """Every vehicle flies on to where it expects to see most of the ground anew per second."""
    CHOSEN_LEGS = "chosen_legs"
    """The line as a whole flies on to where it expects to see most of the ground anew per second, leg after leg."""
    STOPS = "stops"
    """The line of close looks, which stops every two metres."""
    SINGLE = "single"
    """One vehicle along legs one footprint apart, 4 m/s; all views count together."""
    LAWNMOWER = "lawnmower"
    """All vehicles abreast, 30 % of their footprints overlapping, 5 m/s; every frame is judged by itself."""


@dataclass(frozen=True, slots=True)
class SearchStudySettings:
    """Settings that all searches of a study have in common.

    Raises:
        ConfigurationError: a value is out of its range; the text names it.
    """

    hectares: tuple[float, ...] = (4.0,)
    """Sizes of the square areas."""
    vehicles: tuple[int, ...] = (1, 3, 10)
    methods: tuple[Method, ...] = tuple(Method)
    posture: Posture = Posture.STANDING
    pod: float = 0.9
    """Wanted probability of detection of a standing person."""
    rate_hz: float = ImagingSettings().rate_hz
    """Frames per second of each camera."""
    passes: int = 8
    """Flights over the area at most, one after the other, until the person is noticed."""
    close_look_s: float = 20.0
    """Time of the close look after which a person who was noticed is claimed; a single frame is claimed at once."""
    spread: float | None = None
    """Distance within which half of the persons are from a last known point, as a share of the area's side; None:
    persons are anywhere in the area."""
    images: int = 0
    """Persons of each density, the first ones of every thousand seeds, whose planned flights are rendered, too."""
    version: str = ""
    """Version of the program: results of another one belong to another study."""

    def __post_init__(self) -> None:
        for name, values, low, high in (
            ("hectares", self.hectares, 0.1, _MOST_HECTARES),
            ("vehicles", self.vehicles, 1, _MOST_VEHICLES),
            ("pod", (self.pod,), LEAST_POD, GREATEST_POD),
            ("rate", (self.rate_hz,), 0.1, MAX_RATE_HZ),
            ("passes", (self.passes,), 1, 100),
            ("close_look_s", (self.close_look_s,), 0.0, 600.0),
        ):
            if not values or not all(low <= value <= high for value in values):
                text = ", ".join(f"{value:g}" for value in values)
                raise ConfigurationError(f"{name} must lie within {low:g} and {high:g}, but is {text or 'missing'}.")
        if self.spread is not None and not 0.01 <= self.spread <= 10.0:
            raise ConfigurationError(f"spread must lie within 0.01 and 10, but is {self.spread:g}.")
        if self.spread is None and Method.PRIOR in self.methods:
            raise ConfigurationError("the method prior needs --spread: without it persons are anywhere in the area.")
        if not self.methods or len(set(self.methods)) < len(self.methods):
            raise ConfigurationError(f"methods must name one or more of {', '.join(Method)}, each once.")
        if self.images < 0:
            raise ConfigurationError(f"images must be at least 0, but is {self.images}.")


@dataclass(frozen=True, slots=True, order=True)
class SearchKey:
    """A forest, in which one person is searched for by all methods, with all numbers of vehicles, in all areas."""

    trees_per_ha: float
    seed: int


@dataclass(frozen=True, slots=True)
class SearchOutcome:
    """What one search has come to."""

    method: Method
    vehicles: int
    hectares: float
    duration_s: float
    """Time of the first flight, from the first take-off to the last landing."""
    path_m: float
    """Length of the ways of all vehicles in it, together."""
    views: int
    """Independent views of the person's place after the first flight, as the map of searched ground counts them."""
    predicted: float
    """Probability of detection at that place, by the map, after the first flight."""
    noticed: bool
    """Whether the person was noticed in the first flight."""
    claimed_s: float | None
    """Time from the first take-off to the claim; None where no flight has noticed the person."""
    rendered: bool | None = None
    """Whether rendered frames of the first flight notice the person; None where none were rendered."""


@dataclass(frozen=True, slots=True)
class SearchResult:
    """All searches for one person."""

    key: SearchKey
    outcomes: tuple[SearchOutcome, ...]


def search_keys(densities: Sequence[float], searches: int, seed: int) -> tuple[SearchKey, ...]:
    """Return the forests of a study, so many of each density.

    Raises:
        ConfigurationError: there is none.
    """
    if searches < 1 or seed < 0:
        raise ConfigurationError(f"--searches must be at least 1 and --seed at least 0, but are {searches} and {seed}.")
    return tuple(SearchKey(density, seed + number) for number in range(searches) for density in densities)


def forest_of(trees_per_ha: float) -> ForestSettings:
    """Return the simulated forests of a density as a configuration describes them."""
    return ForestSettings(CANOPY_HEIGHT_M, CROWN_BASE_M, occlusion=occlusion_of(trees_per_ha))


def occlusion_of(trees_per_ha: float) -> float:
    """Return the share of the ground that one image does not see in the simulated forests of a density."""
    return float(np.interp(trees_per_ha, *np.array(_OCCLUSION).T))


@dataclass(frozen=True, slots=True)
class Conditions:
    """What a flight is planned for."""

    trees_per_ha: float
    vehicles: int
    hectares: float
    rate_hz: float = ImagingSettings().rate_hz


def plan_for(pod: float, conditions: Conditions) -> MissionPlan:
    """Return the plan of a square area about the origin, with the launch point at its south-western corner."""
    half_m = math.sqrt(conditions.hectares * 1e4) / 2.0
    return MissionPlan(
        vehicles=conditions.vehicles,
        area_enu_m=((-half_m, -half_m), (half_m, -half_m), (half_m, half_m), (-half_m, half_m)),
        launch_enu_m=(-half_m, -half_m),
        rate_hz=conditions.rate_hz,
        forest=forest_of(conditions.trees_per_ha),
        pod=pod,
    )
