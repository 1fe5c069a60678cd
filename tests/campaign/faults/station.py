"""Faults of the station itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from tests.campaign.faults.base import Basis, Fault, draw_time
from tests.campaign.world import World


@dataclass(frozen=True)
class Freeze(Fault):
    """The event loop of the station is blocked."""

    duration_s: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        return cls(draw_time(rng), round(float(rng.uniform(0.5, 10.0)), 1))

    async def act(self, world: World) -> None:
        if world.loop is None or world.loop.is_frozen:
            return
        world.loop.freeze()
        with world.held_telemetry():
            try:
                await world.sleep(self.duration_s)
            finally:  # the mission may end before: a service that stands still would never end
                world.loop.thaw()


@dataclass(frozen=True)
class Kill(Fault):
    """The service is killed, and started again where ``restart_after_s`` says when."""

    WEIGHT: ClassVar[float] = 0.7

    restart_after_s: float | None

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        restart_after_s = None if rng.random() < 0.3 else round(float(rng.uniform(1.0, 30.0)), 1)
        return cls(draw_time(rng), restart_after_s)

    async def act(self, world: World) -> None:
        if world.station is None:
            return
        await world.kill_station()
        if self.restart_after_s is not None:
            await world.sleep(self.restart_after_s)
            await world.start_station()
