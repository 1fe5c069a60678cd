"""Parameters of the swarm strategies, with their constraints.

Sources: [N] Nathan, Kurmi and Bimber, Communications Engineering 2:55 (2023); the AOS-APSO paper.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from aos_gcs.errors import ParameterError
from aos_gcs.swarm.declaration import declared, parameters_of


@dataclass(frozen=True, slots=True, kw_only=True)
class StrategyParameters:
    """Parameters of every strategy.

    Raises:
        ParameterError: a value is out of its bounds, or does not fit to another one; the text names it.
    """

    c4_m: float = declared(4.2, "Spacing of the samples: spacing in line, and charge in scattering.", above=0.0)  # [N]

    def __post_init__(self) -> None:
        for parameter in parameters_of(type(self)):
            parameter.converted(getattr(self, parameter.name))


@dataclass(frozen=True, slots=True, kw_only=True)
class SequentialParameters(StrategyParameters):
    """Parameters of sequential blind sampling."""

    width_m: float = declared(
        30.0, "Length of the grid's rows; 0 for a line of waypoints along the scanning direction.", at_least=0.0
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class LineParameters(StrategyParameters):
    """Parameters of strategies that scan in line; all of those of parallel blind sampling."""

    c3_m: float = declared(2.0, "Distance that the line advances per step while nothing is in view.", above=0.0)  # [N]
    c5: float = declared(
        0.3, "Share of the path back to its place in the line that a drone flies per step.", above=0.0, at_most=1.0
    )  # [N]
    projection_line: bool = declared(
        False, "Give drones the nearest places in the line, instead of places in the order of their numbers."
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class SwarmParameters(LineParameters):
    """Parameters of all strategies that scan in line and follow a leader."""

    leader_stabilised: bool = declared(
        False, "Keep the drone that sees most from being pushed away by others, and have it push them twice as far."
    )
    repulsion_cutoff_m: float | None = declared(
        None, "Distance beyond which drones do not push each other away; empty: no limit.", above=0.0
    )
    follow_target_speed: bool = declared(
        True, "Scan as fast as the target moved, between c3 and c4 per step, if it was tracked for two or more steps."
    )  # [N]
    personal_best_memory: bool = declared(
        False, "Attract each drone to where it has seen most, instead of moving it at random."
    )
    revisit_radius_m: float | None = declared(None, "Distance to keep from earlier viewpoints; empty: none.", above=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class AosPsoParameters(SwarmParameters):
    """Parameters of AOS-PSO as published [N]."""

    c_c_m: float = declared(1.0, "Cognitive factor: distance that a drone moves at random per step.", above=0.0)
    c_s_m: float = declared(2.0, "Social factor: distance that a drone moves per step towards the one that sees most.")

    def __post_init__(self) -> None:
        LineParameters.__post_init__(self)
        # The paper's eq:aos-pso-parameter-constraint-1 and, below, -2.
        if self.c_s_m <= self.c_c_m:
            raise ParameterError(
                f"c_s_m must be above c_c_m (c_s > c_c), but c_s_m is {self.c_s_m:g} and c_c_m {self.c_c_m:g}.",
                "c_s_m",
            )
        if self.c_s_m + self.c_c_m > self.c4_m:
            raise ParameterError(
                f"c_s_m + c_c_m must be at most c4_m (c_s + c_c <= c4), "
                f"but {self.c_s_m:g} + {self.c_c_m:g} is above {self.c4_m:g}.",
                "c_s_m",
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class AosPsoStabilisedParameters(AosPsoParameters):
    """Parameters of AOS-PSO with the paper's two modifications."""

    leader_stabilised: bool = True
    projection_line: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class AosApsoUntunedParameters(SwarmParameters):
    """Parameters of untuned AOS-APSO; APSO's adaptation has none."""

    leader_stabilised: bool = True
    projection_line: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class AosApsoPaperParameters(SwarmParameters):
    """Parameters of the paper's AOS-APSO; those that begin with initial are of its ``eq:aso-apso-reset``."""

    leader_stabilised: bool = True
    projection_line: bool = True
    # The paper gives no gamma; 0.9 matches APSO's rate of 0.1.
    gamma: float = declared(0.9, "Deceleration of the adaptation; the nearer to 1, the slower.", above=0.0, below=1.0)
    initial_c_s_hat: float = declared(
        0.5, "Social factor at the start of each sighting, as a share of its largest value.", above=0.0, below=1.0
    )
    initial_c_c_hat: float = declared(
        0.5, "Cognitive factor at the start of each sighting, as a share of its largest value.", above=0.0, below=1.0
    )
    # Below 0.618, since the smallest factors must leave room for c_s + c_c <= c4: x (1 + x) < 1.
    min_factor: float = declared(0.0, "Lower bound of both factors' shares; 0 is off.", at_least=0.0, below=0.618)
    # Narrower bounds are the paper's cure for the explosion.
    max_factor: float = declared(1.0, "Upper bound of both factors' shares; 1 is off.", above=0.0, at_most=1.0)

    def __post_init__(self) -> None:
        LineParameters.__post_init__(self)
        if self.min_factor >= self.max_factor:
            raise ParameterError(
                f"min_factor must be below max_factor, but they are {self.min_factor:g} and {self.max_factor:g}.",
                "min_factor",
            )
        for name, value in (("initial_c_s_hat", self.initial_c_s_hat), ("initial_c_c_hat", self.initial_c_c_hat)):
            if not self.min_factor <= value <= self.max_factor:
                raise ParameterError(f"{name} must lie between min_factor and max_factor, but is {value:g}.", name)
        share = self.initial_c_s_hat * (1.0 + self.initial_c_c_hat)
        if share > 1.0:
            raise ParameterError(
                f"initial_c_s_hat * (1 + initial_c_c_hat) must be at most 1 (c_s + c_c <= c4), but is {share:g}.",
                "initial_c_s_hat",
            )


ParametersT = TypeVar("ParametersT", bound=StrategyParameters)


def parse_parameters(kind: type[ParametersT], values: Mapping[str, object], strategy: str) -> ParametersT:
    """Return ``kind`` made of a user's values; absent ones take their defaults.

    Raises:
        ParameterError: a name is unknown, a value has the wrong type, or a constraint is violated.
    """
    known = {parameter.name: parameter for parameter in parameters_of(kind)}
    for name in values:
        if name not in known:
            text = f"{strategy} has no parameter {name}; it has {', '.join(sorted(known))}."
            raise ParameterError(text, name)
    converted: dict[str, Any] = {name: known[name].converted(value) for name, value in values.items()}
    return kind(**converted)
