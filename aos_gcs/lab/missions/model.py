"""Missions of a study, and what each of them has come to."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import product

from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.model import SurfaceKind
from aos_gcs.lab.flights import LEVEL_GROUND
from aos_gcs.lab.spacing import Spacing, spacing_for
from aos_gcs.planning.search_settings import GREATEST_POD, LEAST_POD, LookOrder, SearchMode
from aos_gcs.swarm.registry import make_strategy

HERE_M = 3.0
"""A claim farther from every person than this is a false one."""


class LegChoice(StrEnum):
    """Legs that missions fly for a wanted probability of detection."""

    PLANNED = "planned"
    """Parallel ones, to and fro, as missions plan them."""
    CHOSEN = "chosen"
    """One after the other, each where the line expects to gain most probability of detection per second."""


@dataclass(frozen=True, slots=True)
class MissionsSettings:
    """Settings that all missions of a study have in common.

    Raises:
        ConfigurationError: a value is out of its range; the text names it.
    """

    strategy: str = "aos-apso"
    vehicles: int = 10
    side_m: float = 60.0
    """Side of the forest, which is the search area."""
    image_size_px: int = 512
    version: str = ""
    """Version of the program: results of another one belong to another study."""
    terrain: str = LEVEL_GROUND
    """Shape of the ground, in the simulator's words."""
    layer_spacing_m: float | None = None
    """Vertical distance of two altitude layers; None: what the errors of a mission's vehicles need."""
    launch_spacing_m: float | None = None
    """The same for the distance of two launch points."""
    follow_ground: bool = False
    """Whether the altitude layers follow the ground; else they are level."""
    search_mode: str = ""
    """Flight along the legs, ``continuous``, with ``stops``, or ``split``; empty: as missions do by default."""

    surface: str = ""
    """Surface that the focal plane follows over relief, ``terrain`` or ``level``; empty: as missions do by default."""
    looks: str = ""
    """Time of close looks, ``first`` or ``gain``; empty: as missions do by default."""
    pod: float | None = None
    """Probability of detection of a standing person for which spacings and speed are planned, as for the forest's
    density; the legs are flown once. None: spacings and speed are those by default."""
    legs: str = LegChoice.PLANNED
    """Legs, ``planned`` or ``chosen``; chosen ones need a wanted probability of detection."""

    @property
    def name(self) -> str:
        """Strategy, search mode, focal surface, order of looks and chosen legs, for comparisons."""
        surface = f"focal surface {self.surface}" if self.surface else ""
        looks = f"looks {self.looks}" if self.looks else ""
        legs = "chosen legs" if self.legs == LegChoice.CHOSEN else ""
        return ", ".join(part for part in (self.strategy, self.search_mode, surface, looks, legs) if part)

    def __post_init__(self) -> None:
        if self.follow_ground and self.terrain == LEVEL_GROUND:
            raise ConfigurationError("--follow-ground needs a --terrain to follow.")
        if self.surface and self.terrain == LEVEL_GROUND:
            raise ConfigurationError("--surface needs a --terrain: over level ground there is one surface.")
        if self.surface not in {"", *SurfaceKind}:
            raise ConfigurationError(f"--surface must be terrain or level, got {self.surface!r}.")
        if self.looks not in {"", *LookOrder}:
            raise ConfigurationError(f"--looks must be first or gain, got {self.looks!r}.")
        if self.legs not in set(LegChoice):
            raise ConfigurationError(f"--legs must be planned or chosen, got {self.legs!r}.")
        if self.legs == LegChoice.CHOSEN and self.pod is None:
            raise ConfigurationError("--legs chosen needs --pod: legs are chosen until it is expected to be reached.")
        if self.pod is not None:
            if not LEAST_POD <= self.pod <= GREATEST_POD:
                raise ConfigurationError(f"--pod must lie within {LEAST_POD:g} and {GREATEST_POD:g}, got {self.pod:g}.")
            if self.terrain != LEVEL_GROUND or self.search_mode == SearchMode.STOPS:
                raise ConfigurationError("--pod needs level ground, and no --search stops: neither has a prediction.")
        for name, low, high in (("vehicles", 1, 100), ("side_m", 20, 300), ("image_size_px", 64, 4096)):
            if not low <= getattr(self, name) <= high:
                raise ConfigurationError(f"{name} must lie within {low} and {high}, but is {getattr(self, name):g}.")
        self.spacing("")

    def check_strategy(self) -> None:
        """Refuse a strategy that is not installed.

        Raises:
            ConfigurationError: there is none of this name.
        """
        make_strategy(self.strategy, {})

    def spacing(self, errors: str) -> Spacing:
        """Return how far apart vehicles stand and fly that have errors of this grade."""
        return spacing_for(errors, self.layer_spacing_m, self.launch_spacing_m)


@dataclass(frozen=True, slots=True, order=True)
class MissionKey:
    """One mission."""

    trees_per_ha: float
    conditions: str
    """Weather and time of day, or a hardship for the decision."""
    errors: str
    """Grade of the errors of vehicles and cameras."""
    has_person: bool
    seed: int


@dataclass(frozen=True, slots=True)
class MissionResult:
    """What a mission has claimed and cost, judged by the truth."""

    key: MissionKey
    persons: int
    """Persons in the forest."""
    claims: int
    """Findings that were announced as possible persons."""
    true_claims: int
    """Claims that lie within 3 m of a person."""
    persons_found: int
    """Persons with such a claim."""
    errors_m: tuple[float, ...]
    """Horizontal distance of each person found from the nearest claim."""
    claimed_after_s: tuple[float, ...]
    """Time from the start to the claim of each person found."""
    coverage: float
    """Share of the search area that was in a frame."""
    area_ha: float
    """Search area."""
    false_convergences: int
    """Times that the swarm converged on something more than 3 m from every person."""
    false_convergence_s: float
    """Time that this took."""
    min_separation_m: float | None
    """Smallest true 3-D distance of two vehicles."""
    landed: int
    """Vehicles that stand on the ground, disarmed, at the end."""
    outcome: str
    duration_s: float
    """Time from the start to the end, in the mission's own time."""
    steps: int
    processor_s: float
    """Processor time of the flight, without its forest."""
    min_height_above_ground_m: float | None = None
    """Smallest true height of a vehicle above a relief, away from its launch point; None on level ground."""
    probabilities: tuple[float, ...] = ()
    """Probability that each finding is a person, as stated at the end; also of what was not announced."""
    is_person: tuple[bool, ...] = ()
    """Whether a person is within 3 m of each of these findings."""
    predicted: tuple[float, ...] = ()
    """Probability of detection of each person, by the views that the planned legs give the place; empty without a
    wanted one."""
    persons_noticed: int = 0
    """Persons within 3 m of whom something was looked at closely or announced."""


def mission_keys(
    densities: Sequence[float],
    conditions: Sequence[str],
    errors: Sequence[str],
    seed: int,
    *,
    with_person: int,
    without_person: int,
) -> tuple[MissionKey, ...]:
    """Return the missions of a study: so many of both kinds for each density, condition and grade of errors.

    Raises:
        ConfigurationError: there is none, or one is named twice.
    """
    if seed < 0 or min(with_person, without_person) < 0 or with_person + without_person < 1:
        raise ConfigurationError(
            f"--seed, --missions and --no-person must be at least 0, one of the latter at least 1, but are {seed}, "
            f"{with_person} and {without_person}."
        )
    for name, values in (("--conditions", conditions), ("--errors", errors)):
        if len(set(values)) < len(values):
            raise ConfigurationError(f"{name} must name each one once, but is {','.join(values)}.")
    kinds = ((True, with_person), (False, without_person))
    return tuple(
        MissionKey(trees_per_ha, condition, grade, has_person, seed + number)
        for trees_per_ha, condition, grade, (has_person, count) in product(densities, conditions, errors, kinds)
        for number in range(count)
    )


def missing(keys: Iterable[MissionKey], results: Iterable[MissionResult]) -> tuple[MissionKey, ...]:
    """Return the missions that are still to be flown."""
    done = {result.key for result in results}
    return tuple(key for key in keys if key not in done)
