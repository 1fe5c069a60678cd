"""Faults of the radio link, and others who use it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_sim.swarm import SimulatedSwarm
from aos_sim.vehicle.telemetry import degrees_e7
from tests.campaign.faults.base import Basis, Fault, draw_duration, draw_time
from tests.campaign.world import World
from tests.fakes.air import FIRST_PORT, GCS, HOST, Address
from tests.fakes.air_flight import WarmSpot

WORST = {"loss": 0.3, "duplicate": 0.4, "reorder": 0.2, "latency_s": 0.8, "corrupt": 0.05, "burst": 0.004}
"""Greatest value of each field of the tests' ``Faults``."""


@dataclass(frozen=True)
class BadRadio(Fault):
    """Datagrams of all vehicles are lost, late, copied, overtaken or damaged."""

    WEIGHT: ClassVar[float] = 3.0

    kind: str
    value: float
    duration_s: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        kind = str(rng.choice(list(WORST)))
        return cls(draw_time(rng), kind, round(float(rng.uniform(0.1, 1.0)) * WORST[kind], 4), draw_duration(rng))

    async def act(self, world: World) -> None:
        before = getattr(world.air.faults, self.kind)
        setattr(world.air.faults, self.kind, max(before, self.value))
        await world.sleep(self.duration_s)
        setattr(world.air.faults, self.kind, before)


@dataclass(frozen=True)
class LatePackets(Fault):
    """A few genuine packets arrive seconds late, after newer ones."""

    late_s: float
    probability: float
    duration_s: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        return cls(draw_time(rng), round(float(rng.uniform(0.5, 4.0)), 1), 0.02, draw_duration(rng))

    async def act(self, world: World) -> None:
        faults = world.air.faults
        before = faults.reorder, faults.reorder_s
        faults.reorder, faults.reorder_s = self.probability, self.late_s
        await world.sleep(self.duration_s)
        faults.reorder, faults.reorder_s = before


@dataclass(frozen=True)
class LinkCut(Fault):
    """Nothing reaches a vehicle, and it reaches nobody."""

    vehicle_id: int
    duration_s: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        return cls(draw_time(rng), basis.draw_vehicle(rng), draw_duration(rng, longest_s=40.0))

    async def act(self, world: World) -> None:
        index = world.index(self.vehicle_id)
        world.air.cut.add(index)
        await world.sleep(self.duration_s)
        world.air.cut.discard(index)


@dataclass(frozen=True)
class Twin(Fault):
    """A stranger that stands on the ground is switched on and uses the id of a vehicle."""

    WEIGHT: ClassVar[float] = 0.7

    vehicle_id: int
    duration_s: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        return cls(draw_time(rng), basis.draw_vehicle(rng), draw_duration(rng, 5.0, 60.0))

    async def act(self, world: World) -> None:
        options = replace(
            world.swarm.options, vehicles=1, first_system_id=self.vehicle_id, seed=99, cameras=False, start_up_s=None
        )
        async with SimulatedSwarm(options, WarmSpot()) as strangers:
            await world.sleep(self.duration_s)
            if strangers.vehicle(self.vehicle_id).autopilot.flight.armed:
                world.oracle.report("wrong address", f"a stranger with the id {self.vehicle_id} was armed")


@dataclass(frozen=True)
class Spoofing(Fault):
    """Somebody sends telemetry in the name of a vehicle, from another address."""

    PERIOD_S: ClassVar[float] = 0.5
    ATTACKER: ClassVar[Address] = (HOST, 6666)

    vehicle_id: int
    claim: str
    duration_s: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        claim = str(rng.choice(["elsewhere", "landed", "rebooted"]))
        return cls(draw_time(rng), basis.draw_vehicle(rng), claim, draw_duration(rng))

    async def act(self, world: World) -> None:
        codec = mavlink.MAVLink(None, self.vehicle_id, 1)
        sender = self._sender(world)
        for _ in range(max(1, round(self.duration_s / self.PERIOD_S))):
            for message in self._messages(world):
                codec.seq = (codec.seq + 1) % 256
                world.air.carry(message.pack(codec), sender, GCS)
            await world.sleep(self.PERIOD_S)

    def _sender(self, world: World) -> Address:
        return self.ATTACKER

    def _messages(self, world: World) -> list[mavlink.MAVLink_message]:
        autopilot = world.swarm.vehicle(self.vehicle_id).autopilot
        here, boot_ms = autopilot.kinematics.geodetic, autopilot.now.boot_ms
        disarmed = mavlink.MAVLink_heartbeat_message(
            mavlink.MAV_TYPE_QUADROTOR, autopilot.MAV_AUTOPILOT, 0x51, autopilot.custom_mode(), 3, 3
        )
        grounded = mavlink.MAVLink_extended_sys_state_message(0, mavlink.MAV_LANDED_STATE_ON_GROUND)
        north_e7 = 4500 if self.claim == "elsewhere" else 0
        position = mavlink.MAVLink_global_position_int_message(
            time_boot_ms=500 if self.claim == "rebooted" else boot_ms,
            lat=degrees_e7(here.latitude_deg) + north_e7,
            lon=degrees_e7(here.longitude_deg),
            alt=round(here.altitude_amsl_m * 1e3),
            relative_alt=0,
            vx=0,
            vy=0,
            vz=0,
            hdg=0,
        )
        return {"elsewhere": [position], "landed": [disarmed, grounded], "rebooted": [position, disarmed, grounded]}[
            self.claim
        ]


@dataclass(frozen=True)
class Forgery(Spoofing):
    """Somebody forges the address of a vehicle, too, for one moment; without signing, nothing tells it apart."""

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        return replace(super().draw(rng, basis), duration_s=cls.PERIOD_S)

    def _sender(self, world: World) -> Address:
        return (HOST, FIRST_PORT + world.index(self.vehicle_id))
