"""Vehicles of every implementation of the port, each with the truth about its flight."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.framing import FrameParser
from aos_gcs.clock import LoopClock
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.ports import Arm, Clock, DriverContext, Fleet, FormerLinks, Geofence, Notice, Takeoff, Vehicle
from aos_gcs.runtime.drivers import load_driver
from aos_sim.camera.synthetic import CheckerboardGround
from aos_sim.swarm import SimulatedSwarm, SwarmOptions
from tests.fakes.air import GCS, HOST, Air
from tests.fakes.air_flight import IMAGE_SIZE_PX, simulated
from tests.fakes.fleet import FRAME, FakeFleet, FakeVehicle
from tests.fakes.program import unused_port
from tests.fakes.sim_errors import POSITIONS_ERR
from tests.timing import patience

MAVLINK, MAVSDK = "mavlink", "mavsdk"
FAKE = "fake"
"""The vehicles that the tests of whole missions fly, without a link."""
AUTOPILOTS = ("arducopter", "px4")
SPEED = 5.0
"""Vehicles' seconds per second where no virtual time can be had."""
MUTE_ID = 50
PATIENT = {
    "arducopter": {"FS_GCS_TIMEOUT": 60, "DISARM_DELAY": 120},
    "px4": {"COM_DL_LOSS_T": 60, "COM_DISARM_PRFLT": 120},
}
"""A busy machine may delay our heartbeats, and the takeoff after arming, by a real second, five of the vehicles'."""
_DRIVERS = (pytest.param(MAVLINK, marks=pytest.mark.looptime), pytest.param(MAVSDK, marks=pytest.mark.realtime))
each_driver = pytest.mark.parametrize("implementation", _DRIVERS)
each_implementation = pytest.mark.parametrize(
    "implementation", [*_DRIVERS, pytest.param(FAKE, marks=pytest.mark.looptime)]
)


def pairs(*in_every_run: tuple[str, str], fake: bool = True) -> pytest.MarkDecorator:
    """Every driver with every autopilot; those of mavsdk that are not named only with the slow tests."""
    virtual = [(MAVLINK, autopilot) for autopilot in AUTOPILOTS] + [(FAKE, AUTOPILOTS[0])] * fake
    real = [(MAVSDK, autopilot) for autopilot in AUTOPILOTS]
    cases = [pytest.param(*case, marks=pytest.mark.looptime) for case in virtual]
    in_time = {case: pytest.mark.realtime if case in in_every_run else pytest.mark.slow for case in real}
    cases += [pytest.param(*case, marks=mark) for case, mark in in_time.items()]
    return pytest.mark.parametrize(("implementation", "autopilot"), cases)


class Motion(Protocol):
    """True place and velocity of a vehicle."""

    @property
    def position_enu_m(self) -> tuple[float, float, float]: ...
    @property
    def velocity_enu_mps(self) -> tuple[float, float, float]: ...


@dataclass
class Bench:
    """A fleet and the truth about it."""

    fleet: Fleet
    vehicles: int
    clock: Clock
    frame: LocalFrame
    motion: Callable[[int], Motion]
    unanswering: Callable[[], AbstractAsyncContextManager[Unanswering]]
    patience: float = field(default=1.0, kw_only=True)
    """Factor by which limits of waiting are longer than written; 1 in virtual time."""

    def vehicle(self, vehicle_id: int) -> Vehicle:
        return self.fleet.vehicles()[vehicle_id]

    def after(self, limit_s: float) -> float:
        """Return the deadline of what takes less than a limit of waiting."""
        return self.clock.now_s() + limit_s * self.patience

    def expiring(self, duration_s: float) -> float:
        """Return a deadline that has to expire."""
        return self.clock.now_s() + duration_s

    async def until(self, condition: Callable[[], bool], within_s: float = 120.0) -> None:
        async with self.clock.timeout_at(self.after(within_s)):
            while not condition():
                await self.clock.sleep(0.1)

    async def all_ready(self) -> None:
        await self.until(
            lambda: (
                len(self.fleet.vehicles()) == self.vehicles
                and all(vehicle.state.ready_to_arm for vehicle in self.fleet.vehicles().values())
            ),
            within_s=600.0,  # MAVSDK's servers start slowly on a busy machine
        )

    async def fly(self, vehicle_id: int, height_m: float = 10.0) -> Vehicle:
        vehicle = self.vehicle(vehicle_id)
        await vehicle.execute(Arm(), self.after(120.0))
        await vehicle.execute(Takeoff(height_m), self.after(180.0))
        return vehicle


@dataclass
class Unanswering:
    """A vehicle that was heard and answers nothing."""

    vehicle: Vehicle
    fall_silent: Callable[[], object]
    """Have it no longer be heard either."""


@dataclass
class Health:
    """Health of the service, as the driver sees it."""

    is_good: bool = True


@dataclass
class DriverBench(Bench):
    """A driver's fleet over a link to simulated vehicles."""

    swarm: SimulatedSwarm
    port: int
    """Port of the driver's link."""
    health: Health
    notices: list[Notice]


class Ear(asyncio.DatagramProtocol):
    """Keeps the names of the messages that arrive."""

    def __init__(self) -> None:
        self.heard: list[str] = []

    def datagram_received(self, data: bytes, _addr: tuple[str, int]) -> None:
        self.heard += [message.get_type() for message in FrameParser().feed(data)]


@dataclass
class MuteVehicles:
    """Vehicles that send heartbeats and never answer."""

    heard: list[str]
    """Names of the messages that were sent to them."""
    stop: Callable[[], object]
    """End their heartbeats."""


@asynccontextmanager
async def mute_vehicles(clock: Clock, port: int, system_ids: range) -> AsyncIterator[MuteVehicles]:
    """Vehicles that send heartbeats and never answer; yields what is sent to them, and how to stop them."""
    encoders = [mavlink.MAVLink(None, srcSystem=number, srcComponent=1) for number in system_ids]
    beat = mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 0, 0, mavlink.MAV_STATE_STANDBY, 3
    )

    async def send(transport: asyncio.DatagramTransport) -> None:
        while True:
            for encoder in encoders:
                transport.sendto(beat.pack(encoder))
            await clock.sleep(1.0)

    transport, ear = await asyncio.get_running_loop().create_datagram_endpoint(Ear, remote_addr=(HOST, port))
    sending = asyncio.create_task(send(transport))
    try:
        yield MuteVehicles(ear.heard, sending.cancel)
    finally:
        sending.cancel()
        transport.close()


def open_bench(
    implementation: str, autopilot: str = "arducopter", vehicles: int = 3
) -> AbstractAsyncContextManager[Bench]:
    """Open vehicles of one implementation."""
    return _open_fakes(vehicles) if implementation == FAKE else open_driver(implementation, autopilot, vehicles)


@asynccontextmanager
async def open_driver(
    name: str,
    autopilot: str,
    vehicles: int = 3,
    log_folder: Path | None = None,
    *,
    factory_settings: bool = False,
    former: FormerLinks | None = None,
) -> AsyncIterator[DriverBench]:
    """Open a driver's vehicles, which are simulated beyond its link."""
    health, notices = Health(), list[Notice]()
    clock = LoopClock(SPEED) if name == MAVSDK else LoopClock()
    context = DriverContext(clock, lambda: health.is_good, notices.append, log_folder, former=former)
    options = {"vehicles": vehicles, "autopilot": autopilot, "factory_settings": factory_settings}
    connect = _connect_over_udp if name == MAVSDK else _connect_in_memory
    async with connect(context, options) as (fleet, swarm, port):

        @asynccontextmanager
        async def unanswering() -> AsyncIterator[Unanswering]:
            async with mute_vehicles(clock, port, range(MUTE_ID, MUTE_ID + 1)) as mute:
                await bench.until(lambda: MUTE_ID in fleet.vehicles())
                yield Unanswering(bench.vehicle(MUTE_ID), mute.stop)

        bench = DriverBench(
            *(fleet, vehicles, clock, swarm.frame, swarm.kinematics, unanswering, swarm, port, health, notices),
            patience=patience() if name == MAVSDK else 1.0,
        )
        yield bench


@asynccontextmanager
async def _connect_in_memory(
    context: DriverContext, options: dict[str, Any]
) -> AsyncIterator[tuple[Fleet, SimulatedSwarm, int]]:
    """Open the driver without MAVSDK, in virtual time."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        async with simulated(monkeypatch, Air(), context, {}, **options) as (fleet, swarm):
            yield fleet, swarm, GCS[1]


@asynccontextmanager
async def _connect_over_udp(
    context: DriverContext, options: dict[str, Any]
) -> AsyncIterator[tuple[Fleet, SimulatedSwarm, int]]:
    """Open the driver with MAVSDK, whose own threads know no virtual time."""
    pytest.importorskip("mavsdk", reason="needs the optional library mavsdk")
    port = unused_port()
    link = f"udpout://{HOST}:{port}"
    patient = PATIENT[options["autopilot"]]
    swarm_options = SwarmOptions(
        links=(link,),
        speed=SPEED,
        image_size_px=IMAGE_SIZE_PX,
        start_up_s=2.0,
        parameters=patient,
        errors=POSITIONS_ERR,
        **options,
    )
    async with (
        load_driver(MAVSDK)([f"udpin://{HOST}:{port}"], context) as fleet,
        SimulatedSwarm(swarm_options, CheckerboardGround()) as swarm,
    ):
        yield fleet, swarm, port


@dataclass(frozen=True)
class _FakeMotion:
    position_enu_m: tuple[float, float, float]
    velocity_enu_mps: tuple[float, float, float]

    @staticmethod
    def of(vehicle: FakeVehicle) -> _FakeMotion:
        velocity_enu_mps = vehicle.state.velocity_enu_mps
        assert velocity_enu_mps is not None
        east_m, north_m, up_m = vehicle.position_enu_m().tolist()
        return _FakeMotion((east_m, north_m, up_m), velocity_enu_mps)


@asynccontextmanager
async def _open_fakes(vehicles: int) -> AsyncIterator[Bench]:
    clock = LoopClock()
    fleet = FakeFleet(clock, vehicles, None)
    for member in fleet.members.values():
        member.has_interval = True

    @asynccontextmanager
    async def unanswering() -> AsyncIterator[Unanswering]:
        vehicle = fleet.members[1]
        vehicle.silent_since_s = clock.now_s()
        yield Unanswering(vehicle, lambda: None)

    yield Bench(fleet, vehicles, clock, FRAME, lambda number: _FakeMotion.of(fleet.members[number]), unanswering)


def fence_of(bench: Bench, half_width_m: float = 60.0, corners: int = 8) -> Geofence:
    """A regular polygon about the origin with a triangle left out, and a ceiling."""
    angles_rad = [2 * math.pi * corner / corners for corner in range(corners)]
    rings_enu_m = (
        [(half_width_m * math.cos(angle), half_width_m * math.sin(angle)) for angle in angles_rad],
        [(20.0, 20.0), (30.0, 20.0), (25.0, 30.0)],
    )
    places = [[bench.frame.to_geodetic((*corner, 0.0)) for corner in ring] for ring in rings_enu_m]
    inclusion, exclusion = (tuple((place.latitude_deg, place.longitude_deg) for place in ring) for ring in places)
    return Geofence(inclusion, (exclusion,), ceiling_above_home_m=45.5)
