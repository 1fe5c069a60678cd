"""What a fault is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np

if TYPE_CHECKING:
    from tests.campaign.world import World

LAST_S = 45.0
"""Latest time of a fault; most missions are on their way home by then."""


@dataclass(frozen=True)
class Basis:
    """What a fault may depend on when it is drawn."""

    autopilot: str
    vehicle_ids: tuple[int, ...]
    slack_m: float
    """Height by which the layers' spacing exceeds the separation: what the heights of two vehicles may err together."""

    def draw_vehicle(self, rng: np.random.Generator) -> int:
        return int(rng.choice(self.vehicle_ids))


@dataclass(frozen=True)
class Fault(ABC):
    """Something that happens in a mission, ``at_s`` seconds after its launch."""

    WEIGHT: ClassVar[float] = 1.0
    """Frequency with which the fault is drawn, relative to the others."""

    at_s: float

    @classmethod
    @abstractmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        """Draw one."""

    @abstractmethod
    async def act(self, world: World) -> None:
        """Let it happen; return when it is over."""

    def describe(self) -> str:
        """Return it in one line."""
        values = ", ".join(
            f"{entry.name}={_short(getattr(self, entry.name))}" for entry in fields(self) if entry.name != "at_s"
        )
        return f"{self.at_s:5.1f} s  {type(self).__name__}({values})"


def _short(value: object) -> str:
    return f"{value:.2f}" if isinstance(value, float) else str(value)


def draw_time(rng: np.random.Generator, latest_s: float = LAST_S) -> float:
    """Draw when a fault happens; a fifth of all from the launch on."""
    return 0.0 if rng.random() < 0.2 else round(float(rng.uniform(0.0, latest_s)), 1)


def draw_duration(rng: np.random.Generator, shortest_s: float = 2.0, longest_s: float = 30.0) -> float:
    """Draw how long a fault lasts."""
    return round(float(rng.uniform(shortest_s, longest_s)), 1)
