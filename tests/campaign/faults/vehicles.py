"""Faults of single vehicles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_sim.clock import SimTime
from aos_sim.swarm import AUTOPILOTS
from aos_sim.vehicle.kinematics import Kinematics
from aos_sim.vehicle.vehicle import SimulatedVehicle
from tests.campaign.faults.base import Basis, Fault, draw_time
from tests.campaign.world import World


@dataclass(frozen=True)
class LowBattery(Fault):
    """A battery turns out to be nearly empty."""

    vehicle_id: int
    left_fraction: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        return cls(draw_time(rng), basis.draw_vehicle(rng), round(float(rng.uniform(0.1, 0.3)), 2))

    async def act(self, world: World) -> None:
        battery = world.swarm.vehicle(self.vehicle_id).autopilot.battery
        battery.consumed_mah = max(battery.consumed_mah, (1.0 - self.left_fraction) * battery.capacity_mah)


@dataclass(frozen=True)
class DeadCamera(Fault):
    """The images of a camera do not arrive, or arrive damaged."""

    vehicle_id: int
    how: str

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        return cls(draw_time(rng), basis.draw_vehicle(rng), str(rng.choice(["nothing", "late", "torn", "half"])))

    async def act(self, world: World) -> None:
        world.camera_faults[self.vehicle_id] = self.how


@dataclass(frozen=True)
class Reboot(Fault):
    """An autopilot starts anew: in the air the vehicle falls."""

    vehicle_id: int

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        return cls(draw_time(rng), basis.draw_vehicle(rng))

    async def act(self, world: World) -> None:
        row, swarm = world.index(self.vehicle_id), world.swarm
        old = swarm.vehicle(self.vehicle_id)
        if old.autopilot.flight.airborne:
            world.oracle.note_fall(self.vehicle_id)
        autopilot = AUTOPILOTS[swarm.options.autopilot](old.autopilot.identity, swarm.kinematics(self.vehicle_id))
        swarm.vehicles[row] = _Rebooted(autopilot, old.camera, swarm.now)


class _Rebooted(SimulatedVehicle):
    """A vehicle whose time since boot is not the swarm's."""

    def __init__(self, autopilot: object, camera: object, booted_at: SimTime) -> None:
        super().__init__(autopilot, camera)  # type: ignore[arg-type]
        self._booted_at = booted_at

    def handle(self, message: mavlink.MAVLink_message, kinematics: Kinematics, now: SimTime) -> None:
        super().handle(message, kinematics, self._own_time(now))

    def update(self, kinematics: Kinematics, now: SimTime) -> None:
        super().update(kinematics, self._own_time(now))

    def _own_time(self, now: SimTime) -> SimTime:
        return SimTime(now.tick - self._booted_at.tick, now.start_utc_us + self._booted_at.boot_us)
