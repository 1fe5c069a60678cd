"""Faults of sensors and clocks, and the wind."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_sim.errors.wind import Wind
from tests.campaign.faults.base import Basis, Fault, draw_duration, draw_time
from tests.campaign.world import World
from tests.fakes.air import FIRST_PORT, GCS, Address

MAX_JUMP_M = 1.5
"""Largest jump of a position: a vehicle follows it at once, and launch points are 5 m apart."""
_UP = 2


@dataclass(frozen=True)
class WindRises(Fault):
    """Wind with gusts, until the end."""

    speed_mps: float
    from_rad: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        return cls(draw_time(rng), round(float(rng.uniform(2.0, 10.0)), 1), round(float(rng.uniform(0.0, 6.28)), 2))

    async def act(self, world: World) -> None:
        world.swarm._wind = Wind(self.speed_mps, (self.from_rad + math.pi) % math.tau)


@dataclass(frozen=True)
class PositionJump(Fault):
    """A vehicle's position jumps, as after a change of satellites, and it flies to where it believes to belong."""

    vehicle_id: int
    east_m: float
    north_m: float
    duration_s: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        east_m, north_m = rng.uniform(-MAX_JUMP_M, MAX_JUMP_M, 2) / math.sqrt(2.0)
        return cls(draw_time(rng), basis.draw_vehicle(rng), round(east_m, 2), round(north_m, 2), draw_duration(rng))

    async def act(self, world: World) -> None:
        bias_m, row = world.swarm.errors._bias_m, world.index(self.vehicle_id)
        jump_m = np.array([self.east_m, self.north_m, 0.0])
        bias_m[:, row] += jump_m
        await world.sleep(self.duration_s)
        bias_m[:, row] -= jump_m


@dataclass(frozen=True)
class HeightReset(Fault):
    """The estimator of a vehicle resets its height, and the vehicle climbs or sinks by as much."""

    vehicle_id: int
    up_m: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        most_m = 0.4 * basis.slack_m
        return cls(draw_time(rng), basis.draw_vehicle(rng), round(float(rng.uniform(-most_m, most_m)), 2))

    async def act(self, world: World) -> None:
        world.swarm.errors._bias_m[0, world.index(self.vehicle_id), _UP] += self.up_m


@dataclass(frozen=True)
class HeightRunsAway(Fault):
    """The height that a vehicle estimates runs away from the true one, as with a barometer that warms up."""

    vehicle_id: int
    climb_mps: float
    duration_s: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        climb_mps = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.05, 0.2))
        return cls(draw_time(rng), basis.draw_vehicle(rng), round(climb_mps, 2), draw_duration(rng, 10.0, 30.0))

    async def act(self, world: World) -> None:
        row = world.index(self.vehicle_id)
        world.swarm.errors.climb_mps[row] = self.climb_mps
        await world.sleep(self.duration_s)
        world.swarm.errors.climb_mps[row] = 0.0


@dataclass(frozen=True)
class ReportedJump(Fault):
    """Only what a vehicle reports of its position jumps."""

    vehicle_id: int
    north_m: float
    duration_s: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        north_m = round(float(rng.uniform(-40.0, 40.0)), 1)
        return cls(draw_time(rng), basis.draw_vehicle(rng), north_m, draw_duration(rng, 1.0, 8.0))

    async def act(self, world: World) -> None:
        parser = mavlink.MAVLink(None)
        parser.robust_parsing = True
        port = FIRST_PORT + world.index(self.vehicle_id)
        north_e7 = round(math.degrees(self.north_m / 6_371_000.0) * 1e7)

        def shift(data: bytes, sender: Address, receiver: Address) -> bytes | None:
            if sender[1] != port or receiver != GCS:
                return data
            shifted = b""
            for message in parser.parse_buffer(data) or []:
                if message.get_type() == "GLOBAL_POSITION_INT":
                    message.lat += north_e7
                    packer = mavlink.MAVLink(None, message.get_srcSystem(), message.get_srcComponent())
                    packer.seq = message.get_seq()
                    shifted += message.pack(packer)
                else:
                    shifted += bytes(message.get_msgbuf())
            return shifted or None

        with world.middleman(shift):
            await world.sleep(self.duration_s)


@dataclass(frozen=True)
class ClockJump(Fault):
    """The time of day jumps, of the vehicles or of the station."""

    is_station: bool
    jump_s: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        return cls(draw_time(rng), bool(rng.random() < 0.5), float(rng.choice([-3600.0, -5.0, 5.0, 3600.0])))

    async def act(self, world: World) -> None:
        if self.is_station:
            if world.station is not None:
                world.station.clock._start_utc_s += self.jump_s
        else:
            now = world.swarm.now
            world.swarm.now = replace(now, start_utc_us=now.start_utc_us + round(self.jump_s * 1e6))
