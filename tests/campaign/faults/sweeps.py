"""Faults that matter while a line flies on: slow cameras, a vehicle that lags, a station that analyses nothing."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from aos_sim.vehicle.flight import Setpoint
from aos_sim.vehicle.kinematics import Kinematics
from tests.campaign.faults.base import Basis, Fault, draw_duration, draw_time
from tests.campaign.world import World


@dataclass(frozen=True)
class SlowCamera(Fault):
    """The images of a camera arrive late, all by as much."""

    vehicle_id: int
    late_s: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        return cls(draw_time(rng), basis.draw_vehicle(rng), round(float(rng.uniform(0.3, 3.5)), 1))

    async def act(self, world: World) -> None:
        world.camera_delays_s[self.vehicle_id] = self.late_s, self.late_s


@dataclass(frozen=True)
class ErraticCameras(Fault):
    """The images of all cameras arrive after times that differ from one to the next, so that rounds mix."""

    longest_s: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        return cls(draw_time(rng), round(float(rng.uniform(0.5, 3.0)), 1))

    async def act(self, world: World) -> None:
        for vehicle in world.swarm.vehicles:
            world.camera_delays_s[vehicle.system_id] = 0.0, self.longest_s


@dataclass(frozen=True)
class Laggard(Fault):
    """A vehicle flies slower than it is told, as against the wind."""

    vehicle_id: int
    fastest_mps: float
    duration_s: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        return cls(
            draw_time(rng), basis.draw_vehicle(rng), round(float(rng.uniform(1.0, 4.5)), 1), draw_duration(rng, 5.0)
        )

    async def act(self, world: World) -> None:
        flight = world.swarm.vehicle(self.vehicle_id).autopilot.flight
        make_setpoint = flight._make_setpoint

        def slowly(kinematics: Kinematics) -> Setpoint:
            setpoint = make_setpoint(kinematics)
            return replace(setpoint, speed_mps=min(setpoint.speed_mps, self.fastest_mps))

        flight._make_setpoint = slowly
        try:
            await world.sleep(self.duration_s)
        finally:
            flight._make_setpoint = make_setpoint


@dataclass(frozen=True)
class HungImaging(Fault):
    """The process that analyses images answers late, or is killed with whatever it is asked."""

    WEIGHT: ClassVar[float] = 1.5

    duration_s: float
    dies: bool

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        return cls(draw_time(rng), draw_duration(rng, 1.0, 14.0), bool(rng.random() < 0.3))

    async def act(self, world: World) -> None:
        until_s = world.clock.now_s() + self.duration_s
        if self.dies:
            world.imaging.dies_until_s = until_s
        else:
            world.imaging.hangs_until_s = until_s
