"""The state of the strategies that line up and follow a leader: plain data that can be saved and replayed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from aos_gcs.optimisers.evolution import EvolutionaryState

Point = tuple[float, float]
"""Horizontal ENU metres."""


@dataclass(frozen=True, slots=True)
class TargetTrack:
    """Sightings of the target in consecutive steps."""

    first_enu_m: Point
    last_enu_m: Point
    sightings: int
    in_view: bool
    """False once the target was lost; the next sighting then starts a new track."""

    @property
    def step_m(self) -> float:
        """Mean way of the target per step, metres; 0 for a single sighting."""
        if self.sightings < 2:
            return 0.0
        east_m, north_m = np.subtract(self.last_enu_m, self.first_enu_m)
        return float(np.hypot(east_m, north_m)) / (self.sightings - 1)


@dataclass(frozen=True, slots=True)
class LatestObservation:
    """Memory of the latest observation."""

    vehicle_ids: tuple[int, ...]
    positions_enu_m: tuple[Point, ...]
    """Positions in the order of ``vehicle_ids``, which is that of the observation."""
    leader_id: int | None
    """None in the default branch."""


@dataclass(frozen=True, slots=True)
class Adaptation:
    """The factors and what they follow."""

    social: float
    """Social factor in the unit of the strategy's rule: metres, or a fraction of c4."""
    cognitive: float
    """Cognitive factor in the unit of the strategy's rule: metres, or a fraction of the social one."""
    state: EvolutionaryState | None = None
    """None for a rule that knows no states."""
    e_f: float | None = None
    """Evolutionary factor; None in the default branch."""


@dataclass(frozen=True, slots=True)
class PersonalBest:
    """Place from which a vehicle has seen most of the target since it came into view."""

    vehicle_id: int
    position_enu_m: Point
    fitness: float


@dataclass(frozen=True, slots=True)
class SwarmState:
    """Everything a strategy carries from step to step."""

    scan_direction_enu: Point
    """SD, of length 1."""
    track: TargetTrack | None = None
    """The latest track; None before the first sighting."""
    situation: LatestObservation | None = None
    awaits_ask: bool = False
    """Something was told that no positions have been asked for."""
    adaptation: Adaptation | None = None
    """Factors of the latest step; None for strategies that follow no leader."""
    personal_bests: tuple[PersonalBest, ...] = ()
    """One per vehicle at most, sorted by vehicle; empty where that memory is off."""
    sampled_enu_m: tuple[Point, ...] = ()
    """Places from which frames of this sighting were taken, latest last; empty where that memory is off."""


def dump_rng(rng: np.random.Generator) -> dict[str, Any]:
    """Return the generator's state as data that JSON holds.

    Raises:
        ValueError: the generator is not numpy's default one (PCG64), whose state is plain numbers.
    """
    if not isinstance(rng.bit_generator, np.random.PCG64):
        raise ValueError(f"only numpy.random.PCG64 can be saved, not {type(rng.bit_generator).__name__}")
    return dict(rng.bit_generator.state)
