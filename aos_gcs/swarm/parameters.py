"""Parameters of the swarm strategies, with their constraints.

Sources: [N] Nathan, Kurmi and Bimber, Communications Engineering 2:55 (2023); the AOS-APSO paper; algorithms.md
sections 3c to 3f.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import Field, dataclass, fields
from typing import Any, TypeVar

from aos_gcs.errors import ConfigurationError

ABOVE_ZERO = {"c3_m", "c4_m", "c_c_m", "repulsion_cutoff_m", "revisit_radius_m"}
"""Parameters that must be above 0, where a strategy has them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StrategyParameters:
    """What every strategy has."""

    c4_m: float = 4.2
    """Spacing of the samples: of the line, and the charge in scattering; metres [N]."""

    def __post_init__(self) -> None:
        check_common(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class SequentialParameters(StrategyParameters):
    """Parameters of sequential blind sampling."""

    width_m: float = 30.0
    """Length of the grid's rows, metres; 0 for a line of waypoints along the scanning direction."""

    def __post_init__(self) -> None:
        check_common(self)
        _require(self.width_m >= 0.0, f"width_m must be at least 0, but is {self.width_m:g}.")


@dataclass(frozen=True, slots=True, kw_only=True)
class LineParameters(StrategyParameters):
    """What strategies that scan in line have, and all of parallel blind sampling."""

    c3_m: float = 2.0
    """Scanning step per mission step in the default branch, metres [N]."""
    c5: float = 0.3
    """Share of the way to its line place that a drone returns per step, in (0, 1] [N]."""
    projection_line: bool = False
    """Drones take line places in the order of their projections, not of their ids (section 3d)."""

    def __post_init__(self) -> None:
        check_common(self)
        _require(0.0 < self.c5 <= 1.0, f"c5 must be above 0 and at most 1, but is {self.c5:g}.")


@dataclass(frozen=True, slots=True, kw_only=True)
class SwarmParameters(LineParameters):
    """What all strategies that line up and follow a leader have in common."""

    leader_stabilised: bool = False
    """The leader feels no repulsion and exerts a doubled one (section 3d)."""
    repulsion_cutoff_m: float | None = None
    """Distance beyond which drones do not repel each other, metres; off by default (section 3f)."""
    follow_target_speed: bool = True
    """After a target was tracked for two or more steps, scan as fast as it moved [N], between c3 and c4 per step."""
    personal_best_memory: bool = False
    """The cognitive term points to a random point around where the drone has seen most (section 3f)."""
    revisit_radius_m: float | None = None
    """Distance to any spot sampled in this sighting that a waypoint keeps, metres; off by default (section 3f)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AosPsoParameters(SwarmParameters):
    """Parameters of AOS-PSO as published [N]."""

    c_c_m: float = 1.0
    """Cognitive (random) factor, metres."""
    c_s_m: float = 2.0
    """Social factor (towards the leader), metres."""

    def __post_init__(self) -> None:
        LineParameters.__post_init__(self)
        # The paper's eq:aos-pso-parameter-constraint-1 and, below, -2.
        _require(
            self.c_s_m > self.c_c_m,
            f"c_s_m must be above c_c_m (c_s > c_c), but c_s_m is {self.c_s_m:g} and c_c_m {self.c_c_m:g}.",
        )
        _require(
            self.c_s_m + self.c_c_m <= self.c4_m,
            f"c_s_m + c_c_m must be at most c4_m (c_s + c_c <= c4), "
            f"but {self.c_s_m:g} + {self.c_c_m:g} is above {self.c4_m:g}.",
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class AosPsoStabilisedParameters(AosPsoParameters):
    """Parameters of AOS-PSO with the paper's two modifications (section 3d)."""

    leader_stabilised: bool = True
    projection_line: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class AosApsoUntunedParameters(SwarmParameters):
    """Parameters of untuned AOS-APSO; APSO's adaptation has none."""

    leader_stabilised: bool = True
    projection_line: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class AosApsoParameters(SwarmParameters):
    """Parameters of AOS-APSO."""

    leader_stabilised: bool = True
    projection_line: bool = True
    gamma: float = 0.9
    """Deceleration factor of the adaptation, in (0, 1); the paper gives none, 0.9 matches APSO's rate of 0.1."""
    initial_c_s_hat: float = 0.5
    """Fractional social factor at the start and after the default branch, in (0, 1) (``eq:aso-apso-reset``)."""
    initial_c_c_hat: float = 0.5
    """Fractional cognitive factor at the start and after the default branch, in (0, 1)."""
    min_factor: float = 0.0
    """Lower bound of both fractional factors; 0 is off. Narrower bounds are the paper's cure for the explosion."""
    max_factor: float = 1.0
    """Upper bound of both fractional factors; 1 is off."""

    def __post_init__(self) -> None:
        LineParameters.__post_init__(self)
        _require(0.0 < self.gamma < 1.0, f"gamma must lie between 0 and 1, but is {self.gamma:g}.")
        _require(
            0.0 <= self.min_factor < self.max_factor <= 1.0,
            f"min_factor and max_factor must satisfy 0 <= min_factor < max_factor <= 1, "
            f"but are {self.min_factor:g} and {self.max_factor:g}.",
        )
        _require(
            self.min_factor * (1.0 + self.min_factor) < 1.0,
            f"min_factor must leave room for c_s + c_c <= c4: below 0.618, but is {self.min_factor:g}.",
        )
        for name, value in (("initial_c_s_hat", self.initial_c_s_hat), ("initial_c_c_hat", self.initial_c_c_hat)):
            _require(
                0.0 < value < 1.0 and self.min_factor <= value <= self.max_factor,
                f"{name} must lie between 0 and 1, and between min_factor and max_factor, but is {value:g}.",
            )
        _require(
            self.initial_c_s_hat * (1.0 + self.initial_c_c_hat) <= 1.0,
            "initial_c_s_hat * (1 + initial_c_c_hat) must be at most 1 (c_s + c_c <= c4), "
            f"but is {self.initial_c_s_hat * (1.0 + self.initial_c_c_hat):g}.",
        )


def check_common(parameters: StrategyParameters) -> None:
    """Check what needs no knowledge of the strategy: numbers are finite, and above 0 where they must be.

    Raises:
        ConfigurationError: one of them is not; the text names it.
    """
    for item in fields(parameters):
        value = getattr(parameters, item.name)
        if value is None:
            continue
        _require(math.isfinite(value), f"{item.name} must be a finite number, but is {value}.")
        _require(item.name not in ABOVE_ZERO or value > 0.0, f"{item.name} must be above 0, but is {value:g}.")


ParametersT = TypeVar("ParametersT", bound=StrategyParameters)


def parse_parameters(kind: type[ParametersT], values: Mapping[str, object], strategy: str) -> ParametersT:
    """Return ``kind`` made of a user's values; absent ones take their defaults.

    Raises:
        ConfigurationError: a name is unknown, a value has the wrong type, or a constraint is violated.
    """
    known = {item.name: item for item in fields(kind)}
    for name in values:
        _require(name in known, f"{strategy} has no parameter {name}; it has {', '.join(sorted(known))}.")
    converted: dict[str, Any] = {name: _converted(strategy, known[name], value) for name, value in values.items()}
    return kind(**converted)


def _converted(strategy: str, item: Field[Any], value: object) -> object:
    if item.type == "bool":
        _require(isinstance(value, bool), f"{item.name} of {strategy} must be true or false, but is {value!r}.")
        return value
    if value is None and item.type == "float | None":
        return None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigurationError(f"{item.name} of {strategy} must be a number, but is {value!r}.")
    return float(value)


def _require(holds: bool, text: str) -> None:
    if not holds:
        raise ConfigurationError(text)
