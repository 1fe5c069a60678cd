"""The state of the strategies that line up and follow a leader: plain data that can be saved and replayed."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from aos_gcs.swarm.evolution import EvolutionaryState, FractionalFactors

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
class Situation:
    """What the latest observation has come to."""

    vehicle_ids: tuple[int, ...]
    positions_enu_m: tuple[Point, ...]
    """In the order of ``vehicle_ids``, which is that of the observation."""
    leader_id: int | None
    """None in the default branch."""


@dataclass(frozen=True, slots=True)
class Adaptation:
    """AOS-APSO's own state."""

    factors: FractionalFactors
    state: EvolutionaryState
    e_f: float | None
    """Evolutionary factor; None in the default branch."""


@dataclass(frozen=True, slots=True)
class SwarmState:
    """Everything a strategy carries from step to step."""

    scan_direction_enu: Point
    """SD, of length 1."""
    track: TargetTrack | None = None
    """The latest track; None before the first sighting."""
    situation: Situation | None = None
    awaits_ask: bool = False
    """Something was told that no positions have been asked for."""
    adaptation: Adaptation | None = None
    """None for strategies that do not adapt."""


def dump_state(state: SwarmState) -> dict[str, Any]:
    """Return the state as data that JSON holds bit for bit."""
    return dataclasses.asdict(state)


def load_state(data: Mapping[str, Any]) -> SwarmState:
    """Return the state of which :func:`dump_state` made ``data``, also after a way through JSON.

    Raises:
        ValueError: fields are missing or unknown.
    """
    try:
        return SwarmState(
            scan_direction_enu=_point(data["scan_direction_enu"]),
            track=_track(data["track"]) if data["track"] is not None else None,
            situation=_situation(data["situation"]) if data["situation"] is not None else None,
            awaits_ask=data["awaits_ask"],
            adaptation=_adaptation(data["adaptation"]) if data["adaptation"] is not None else None,
        )
    except (KeyError, TypeError) as error:
        raise ValueError(f"this is not the state of a swarm strategy: {error}") from error


def dump_rng(rng: np.random.Generator) -> dict[str, Any]:
    """Return the generator's state as data that JSON holds.

    Raises:
        ValueError: the generator is not numpy's default one (PCG64), whose state is plain numbers.
    """
    if not isinstance(rng.bit_generator, np.random.PCG64):
        raise ValueError(f"only numpy.random.PCG64 can be saved, not {type(rng.bit_generator).__name__}")
    return dict(rng.bit_generator.state)


def load_rng(data: Mapping[str, Any]) -> np.random.Generator:
    """Return a generator that continues where the saved one stood.

    Raises:
        ValueError: ``data`` is not the state of a PCG64 generator.
    """
    bit_generator = np.random.PCG64(0)
    try:
        bit_generator.state = cast("Any", dict(data))
    except (KeyError, TypeError) as error:
        raise ValueError(f"this is not the state of a PCG64 generator: {error}") from error
    return np.random.Generator(bit_generator)


def _point(data: Any) -> Point:
    east_m, north_m = data
    return (float(east_m), float(north_m))


def _track(data: Mapping[str, Any]) -> TargetTrack:
    return TargetTrack(
        _point(data["first_enu_m"]), _point(data["last_enu_m"]), int(data["sightings"]), bool(data["in_view"])
    )


def _situation(data: Mapping[str, Any]) -> Situation:
    return Situation(tuple(data["vehicle_ids"]), tuple(map(_point, data["positions_enu_m"])), data["leader_id"])


def _adaptation(data: Mapping[str, Any]) -> Adaptation:
    return Adaptation(FractionalFactors(**data["factors"]), EvolutionaryState(data["state"]), data["e_f"])
