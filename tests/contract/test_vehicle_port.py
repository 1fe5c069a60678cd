"""What every driver of the Vehicle port has to do, shown with simulated vehicles over UDP."""

from __future__ import annotations

import asyncio
import itertools
import math
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.framing import FrameParser
from aos_gcs.clock import LoopClock
from aos_gcs.errors import CommandRefusedError, CommandTimeoutError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.ports import (
    Arm,
    Clock,
    Disarm,
    Driver,
    DriverContext,
    Fleet,
    FlightMode,
    Geofence,
    Goto,
    Hold,
    Land,
    LandedState,
    Notice,
    ReturnToLaunch,
    Severity,
    Takeoff,
    Vehicle,
)
from aos_gcs.runtime.drivers import load_driver
from aos_sim.camera.synthetic import CheckerboardGround
from aos_sim.swarm import SimulatedSwarm, SwarmOptions

DRIVERS = ("mavlink", "mavsdk")
AUTOPILOTS = ("arducopter", "px4")
SPEED = 10.0
SIZE_PX = 64
PATIENT = {
    "arducopter": {"FS_GCS_TIMEOUT": 120, "DISARM_DELAY": 120},
    "px4": {"COM_DL_LOSS_T": 120, "COM_DISARM_PRFLT": 120},
}
"""A busy machine may delay our heartbeats, and the takeoff after arming, by a real second, ten of the vehicles'."""


def pairs(*in_every_run: tuple[str, str]) -> pytest.MarkDecorator:
    """Every driver with every autopilot; those of mavsdk that are not named only with the slow tests."""
    cases = [
        pytest.param(*case, marks=() if case[0] == "mavlink" or case in in_every_run else pytest.mark.slow)
        for case in itertools.product(DRIVERS, AUTOPILOTS)
    ]
    return pytest.mark.parametrize(("driver", "autopilot"), cases, indirect=["driver"])


@pytest.fixture(params=DRIVERS)
def driver(request: pytest.FixtureRequest) -> Driver:
    if request.param == "mavsdk":
        pytest.importorskip("mavsdk", reason="needs the optional library mavsdk")
    return load_driver(request.param)


@dataclass
class Health:
    """Of the service, as the driver sees it."""

    is_good: bool = True


@dataclass
class Bench:
    """A fleet and the truth about it."""

    fleet: Fleet
    swarm: SimulatedSwarm
    clock: Clock
    port: int
    """Of the driver's link."""
    health: Health
    notices: list[Notice] = field(default_factory=list)

    def vehicle(self, vehicle_id: int) -> Vehicle:
        return self.fleet.vehicles()[vehicle_id]

    def after(self, duration_s: float) -> float:
        return self.clock.now_s() + duration_s

    async def until(self, condition: Callable[[], bool], within_s: float = 120.0) -> None:
        async with self.clock.timeout_at(self.after(within_s)):
            while not condition():
                await self.clock.sleep(0.1)

    async def all_ready(self) -> None:
        await self.until(
            lambda: (
                len(self.fleet.vehicles()) == self.swarm.options.vehicles
                and all(vehicle.state.ready_to_arm for vehicle in self.fleet.vehicles().values())
            )
        )

    async def fly(self, vehicle_id: int, height_m: float = 10.0) -> Vehicle:
        vehicle = self.vehicle(vehicle_id)
        await vehicle.execute(Arm(), self.after(120.0))
        await vehicle.execute(Takeoff(height_m), self.after(180.0))
        return vehicle


class Ear(asyncio.DatagramProtocol):
    """Keeps the names of the messages that arrive."""

    def __init__(self) -> None:
        self.heard: list[str] = []

    def datagram_received(self, data: bytes, _addr: tuple[str, int]) -> None:
        self.heard += [message.get_type() for message in FrameParser().feed(data)]


@asynccontextmanager
async def mute_vehicles(bench: Bench, system_ids: range) -> AsyncIterator[Ear]:
    """Vehicles that send heartbeats and never answer; yields what is sent to them."""
    encoders = [mavlink.MAVLink(None, srcSystem=number, srcComponent=1) for number in system_ids]
    beat = mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 0, 0, mavlink.MAV_STATE_STANDBY, 3
    )

    async def send(transport: asyncio.DatagramTransport) -> None:
        while True:
            for encoder in encoders:
                transport.sendto(beat.pack(encoder))
            await bench.clock.sleep(1.0)

    transport, ear = await asyncio.get_running_loop().create_datagram_endpoint(
        Ear, remote_addr=("127.0.0.1", bench.port)
    )
    sending = asyncio.create_task(send(transport))
    try:
        yield ear
    finally:
        sending.cancel()
        transport.close()


@asynccontextmanager
async def open_bench(
    driver: Driver,
    autopilot: str,
    vehicles: int = 3,
    log_folder: Path | None = None,
    *,
    factory_settings: bool = False,
) -> AsyncIterator[Bench]:
    async with AsyncExitStack() as stack:
        clock = LoopClock(SPEED)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        notices: list[Notice] = []
        health = Health()
        context = DriverContext(clock, lambda: health.is_good, notices.append, log_folder)
        fleet = await stack.enter_async_context(driver([f"udpin://127.0.0.1:{port}"], context))
        options = SwarmOptions(
            vehicles=vehicles,
            links=(f"udpout://127.0.0.1:{port}",),
            speed=SPEED,
            autopilot=autopilot,
            image_size_px=SIZE_PX,
            start_up_s=2.0,
            parameters=PATIENT[autopilot],
            factory_settings=factory_settings,
        )
        swarm = await stack.enter_async_context(SimulatedSwarm(options, CheckerboardGround()))
        yield Bench(fleet, swarm, clock, port, health, notices)


@pairs()
async def test_three_vehicles_fly_take_images_and_come_home(driver: Driver, autopilot: str, tmp_path: Path) -> None:
    async with open_bench(driver, autopilot, log_folder=tmp_path) as bench:
        await bench.all_ready()
        vehicles = await asyncio.gather(*[bench.fly(number, 10.0 + number) for number in (1, 2, 3)])
        for number, vehicle in enumerate(vehicles, 1):
            assert vehicle.state.armed
            assert bench.swarm.kinematics(number).position_enu_m[2] == pytest.approx(10.0 + number, abs=1.2)

        targets = [bench.swarm.frame.to_geodetic((12.0 * number, 15.0, 10.0 + number)) for number in (1, 2, 3)]
        await asyncio.gather(
            *[
                vehicle.execute(Goto(target, 5.0), bench.after(30.0))
                for vehicle, target in zip(vehicles, targets, strict=True)
            ]
        )
        await bench.until(
            lambda: all(
                math.dist(bench.swarm.kinematics(number).position_enu_m, (12.0 * number, 15.0, 10.0 + number)) < 1.0
                for number in (1, 2, 3)
            )
        )

        captures = await asyncio.gather(*[vehicle.capture(bench.after(60.0)) for vehicle in vehicles])
        for number, capture in enumerate(captures, 1):
            assert (capture.vehicle_id, capture.image_index) == (number, 0)
            assert capture.image.shape == (SIZE_PX, SIZE_PX, 4)
            assert capture.bands == ("red", "green", "blue", "thermal")
            assert -50 < float(np.median(capture.image[..., 3])) < 60
            place_enu_m = bench.swarm.frame.to_enu(capture.position)
            assert math.dist(place_enu_m, (12.0 * number, 15.0, 10.0 + number)) < 1.5
            assert capture.R_cam2enu[:, 2] == pytest.approx([0.0, 0.0, -1.0], abs=1e-6)
            assert capture.camera.horizontal_fov_rad == pytest.approx(bench.swarm.options.fov_rad, abs=1e-6)
        assert (await vehicles[0].capture(bench.after(60.0))).image_index == 1

        await vehicles[0].execute(Hold(), bench.after(30.0))
        assert vehicles[0].state.mode is FlightMode.HOLD
        await vehicles[0].execute(Land(), bench.after(30.0))
        await asyncio.gather(*[vehicle.execute(ReturnToLaunch(), bench.after(30.0)) for vehicle in vehicles[1:]])
        assert [vehicle.state.mode for vehicle in vehicles] == [FlightMode.LAND, FlightMode.RETURN, FlightMode.RETURN]
        await bench.until(lambda: not any(vehicle.state.armed for vehicle in vehicles), 240.0)
        assert bench.swarm.report().landed == 3
        assert [notice for notice in bench.notices if notice.severity is Severity.CRITICAL] == []
    assert (tmp_path / "mavlink.tlog").stat().st_size > 10_000


@pairs(("mavsdk", "px4"))
async def test_hold_stops_a_vehicle_on_its_way(driver: Driver, autopilot: str) -> None:
    async with open_bench(driver, autopilot, vehicles=1) as bench:
        await bench.all_ready()
        vehicle = await bench.fly(1)
        await vehicle.execute(Goto(bench.swarm.frame.to_geodetic((0.0, 150.0, 10.0)), 8.0), bench.after(30.0))
        await bench.until(lambda: bench.swarm.kinematics(1).velocity_enu_mps[1] > 6.0)
        await vehicle.execute(Hold(), bench.after(30.0))
        await bench.until(lambda: math.hypot(*bench.swarm.kinematics(1).velocity_enu_mps) < 0.2)
        stopped_at_m = bench.swarm.kinematics(1).position_enu_m
        await bench.clock.sleep(5.0)
        assert math.dist(bench.swarm.kinematics(1).position_enu_m, stopped_at_m) < 1.0
        assert stopped_at_m[1] < 100.0


async def test_a_command_reaches_its_vehicle_and_no_other(driver: Driver) -> None:
    async with open_bench(driver, "arducopter") as bench:
        await bench.all_ready()
        await bench.fly(2)
        heights_m = [bench.swarm.kinematics(number).position_enu_m[2] for number in (1, 2, 3)]
        assert heights_m == pytest.approx([0.0, 10.0, 0.0], abs=1.2)
        assert [bench.vehicle(number).state.armed for number in (1, 2, 3)] == [False, True, False]


async def test_heartbeats_stop_with_the_health_of_the_service(driver: Driver) -> None:
    async with open_bench(driver, "arducopter", vehicles=1) as bench, mute_vehicles(bench, range(50, 51)) as ear:
        await bench.until(lambda: ear.heard.count("HEARTBEAT") >= 2)
        bench.health.is_good = False
        await bench.clock.sleep(3.0)
        ear.heard.clear()
        await bench.clock.sleep(10.0)
        assert "HEARTBEAT" not in ear.heard
        bench.health.is_good = True
        await bench.until(lambda: "HEARTBEAT" in ear.heard)


async def test_silent_vehicles_delay_no_other(driver: Driver) -> None:
    async with open_bench(driver, "arducopter", vehicles=1) as bench, mute_vehicles(bench, range(50, 70)):
        await bench.until(lambda: len(bench.fleet.vehicles()) == 21)
        await bench.until(lambda: bool(bench.vehicle(1).state.ready_to_arm))
        waiting = [
            asyncio.create_task(bench.vehicle(number).execute(Arm(), bench.after(600.0))) for number in range(50, 70)
        ]
        await bench.clock.sleep(1.0)
        await bench.fly(1)
        assert bench.swarm.kinematics(1).position_enu_m[2] == pytest.approx(10.0, abs=1.2)
        assert not any(task.done() for task in waiting)
        for task in waiting:
            task.cancel()
        await asyncio.wait(waiting)


@pairs(("mavsdk", "arducopter"), ("mavsdk", "px4"))
async def test_what_must_not_be_done_is_refused_in_words(driver: Driver, autopilot: str) -> None:
    async with open_bench(driver, autopilot, vehicles=1) as bench:
        await bench.all_ready()
        grounded = bench.vehicle(1)
        home = grounded.state.home
        assert home is not None
        with pytest.raises(CommandRefusedError, match="take off first"):
            await grounded.execute(Goto(home, 5.0), bench.after(5.0))
        flying = await bench.fly(1)
        with pytest.raises(CommandRefusedError, match="land it"):
            await flying.execute(Disarm(), bench.after(5.0))
        with pytest.raises(CommandRefusedError, match="not finite"):
            await flying.execute(Goto(GeodeticPosition(48.3, 14.3, math.nan), 5.0), bench.after(5.0))
        climbing = asyncio.create_task(
            flying.execute(Goto(bench.swarm.frame.to_geodetic((0, 0, 60)), 1e-3), bench.after(1))
        )
        await asyncio.sleep(0)
        await flying.execute(Hold(), bench.after(30.0))
        with pytest.raises(CommandRefusedError, match="superseded by Hold"):
            await climbing


@pairs()
async def test_a_climb_can_be_held_and_continued(driver: Driver, autopilot: str) -> None:
    async with open_bench(driver, autopilot, vehicles=1) as bench:
        await bench.all_ready()
        vehicle = bench.vehicle(1)
        await vehicle.execute(Arm(), bench.after(60.0))
        climbing = asyncio.create_task(vehicle.execute(Takeoff(30.0), bench.after(180.0)))
        await bench.until(lambda: bench.swarm.kinematics(1).position_enu_m[2] > 10.0)
        await vehicle.execute(Hold(), bench.after(30.0))
        with pytest.raises(CommandRefusedError, match="superseded by Hold"):
            await climbing
        await bench.until(lambda: math.hypot(*bench.swarm.kinematics(1).velocity_enu_mps) < 0.2)
        held_enu_m = bench.swarm.kinematics(1).position_enu_m
        assert 9.0 < held_enu_m[2] < 25.0
        await bench.clock.sleep(5.0)
        assert math.dist(bench.swarm.kinematics(1).position_enu_m, held_enu_m) < 1.0
        await vehicle.execute(Goto(bench.swarm.frame.to_geodetic((*held_enu_m[:2], 30.0)), 5.0), bench.after(30.0))
        await bench.until(lambda: math.dist(bench.swarm.kinematics(1).position_enu_m, (*held_enu_m[:2], 30.0)) < 1.0)


@pairs()
async def test_a_hold_before_the_lift_off_is_safe_and_can_be_repeated(driver: Driver, autopilot: str) -> None:
    async with open_bench(driver, autopilot, vehicles=1) as bench:
        await bench.all_ready()
        vehicle = bench.vehicle(1)
        await vehicle.execute(Arm(), bench.after(60.0))
        climbing = asyncio.create_task(vehicle.execute(Takeoff(20.0), bench.after(180.0)))
        await asyncio.sleep(0)
        await vehicle.execute(Hold(), bench.after(30.0))
        with pytest.raises(CommandRefusedError, match="superseded by Hold"):
            await climbing
        assert bench.swarm.kinematics(1).position_enu_m[2] < 8.0
        assert abs(bench.swarm.kinematics(1).velocity_enu_mps[2]) < 1.0
        await bench.clock.sleep(2.0)
        if vehicle.state.landed is LandedState.ON_GROUND:
            await vehicle.execute(Takeoff(20.0), bench.after(180.0))
        else:
            await vehicle.execute(Goto(bench.swarm.frame.to_geodetic((0.0, 0.0, 20.0)), 5.0), bench.after(30.0))
        await bench.until(lambda: bench.swarm.kinematics(1).position_enu_m[2] > 19.0)


def fence_of(bench: Bench, half_width_m: float = 60.0, corners: int = 8) -> Geofence:
    """A regular polygon about the origin with a triangle left out, and a ceiling."""
    angles_rad = [2 * math.pi * corner / corners for corner in range(corners)]
    rings_enu_m = (
        [(half_width_m * math.cos(angle), half_width_m * math.sin(angle)) for angle in angles_rad],
        [(20.0, 20.0), (30.0, 20.0), (25.0, 30.0)],
    )
    places = [[bench.swarm.frame.to_geodetic((*corner, 0.0)) for corner in ring] for ring in rings_enu_m]
    inclusion, exclusion = (tuple((place.latitude_deg, place.longitude_deg) for place in ring) for ring in places)
    return Geofence(inclusion, (exclusion,), ceiling_above_home_m=45.5)


@pairs(("mavsdk", "px4"))
async def test_a_fence_is_uploaded_read_back_and_kept(driver: Driver, autopilot: str) -> None:
    async with open_bench(driver, autopilot, vehicles=2) as bench:
        await bench.all_ready()
        vehicle, other = bench.vehicle(1), bench.vehicle(2)
        facts = await vehicle.inspect(bench.after(100.0))
        assert facts.fence is None
        assert facts.firmware == {"arducopter": "4.7.0 dev", "px4": "1.16.0"}[autopilot]
        assert len(facts.board_id) > 4
        assert facts.link_loss.is_on
        assert facts.link_loss.text.startswith("return after")
        assert facts.low_battery.is_on
        assert facts.return_height_m == 30.0

        fence = fence_of(bench)
        await vehicle.upload_fence(fence, bench.after(100.0))
        facts, others = await asyncio.gather(*[one.inspect(bench.after(100.0)) for one in (vehicle, other)])
        assert facts.fence is not None
        assert facts.fence.is_same_as(fence)
        assert facts.at_fence.is_on
        assert others.fence is None, "a fence is for one vehicle"
        assert others.board_id != facts.board_id

        with pytest.raises(CommandRefusedError, match=r"refuses a geofence of 153 points: no space"):
            await vehicle.upload_fence(fence_of(bench, corners=150), bench.after(100.0))
        assert (await vehicle.inspect(bench.after(100.0))).fence == facts.fence

        await bench.fly(1)
        outside = vehicle.execute(Goto(bench.swarm.frame.to_geodetic((0.0, 80.0, 10.0)), 5.0), bench.after(8.0))
        with pytest.raises(CommandRefusedError if autopilot == "arducopter" else CommandTimeoutError):
            await outside
        assert bench.swarm.kinematics(1).position_enu_m[1] < 5.0


async def test_failsafes_that_are_off_are_told_with_their_remedy(driver: Driver) -> None:
    async with open_bench(driver, "arducopter", vehicles=1, factory_settings=True) as bench:
        await bench.all_ready()
        facts = await bench.vehicle(1).inspect(bench.after(100.0))
        assert (facts.link_loss.is_on, facts.low_battery.is_on, facts.at_fence.is_on) == (False, False, False)
        assert facts.link_loss.remedy == "set FS_GCS_ENABLE to 1 (return)"
        assert facts.return_height_m == 15.0


@pairs(("mavsdk", "px4"))
async def test_a_return_height_is_set_on_the_ground_kept_in_the_air_and_set_back(
    driver: Driver, autopilot: str
) -> None:
    async with open_bench(driver, autopilot, vehicles=2) as bench:
        await bench.all_ready()
        vehicle, other = bench.vehicle(1), bench.vehicle(2)
        before = await vehicle.inspect(bench.after(100.0))
        await vehicle.set_return_height(17.5, bench.after(100.0))
        facts, others = await asyncio.gather(*[one.inspect(bench.after(100.0)) for one in (vehicle, other)])
        assert facts.return_height_m == 17.5
        assert others.return_height_m == before.return_height_m, "a height is for one vehicle"

        for height_m in (0.0, math.nan):
            with pytest.raises(CommandRefusedError, match="is impossible"):
                await vehicle.set_return_height(height_m, bench.after(100.0))
        with pytest.raises(CommandRefusedError, match="has no FENCE_ENABLE that says how it returns"):
            await vehicle.restore_return({"FENCE_ENABLE": 0.0}, bench.after(100.0))

        await bench.fly(1)
        with pytest.raises(CommandRefusedError, match="the motors of vehicle 1 run"):
            await vehicle.set_return_height(25.0, bench.after(100.0))
        with pytest.raises(CommandRefusedError, match="the motors of vehicle 1 run"):
            await vehicle.restore_return(before.return_settings, bench.after(100.0))
        await vehicle.execute(Goto(bench.swarm.frame.to_geodetic((0.0, 30.0, 10.0)), 5.0), bench.after(30.0))
        await bench.until(lambda: bench.swarm.kinematics(1).position_enu_m[1] > 20.0)
        await vehicle.execute(ReturnToLaunch(), bench.after(30.0))
        highest_m = 0.0
        while vehicle.state.armed:
            highest_m = max(highest_m, bench.swarm.kinematics(1).position_enu_m[2])
            await bench.clock.sleep(0.5)
        assert highest_m == pytest.approx(17.5, abs=0.5)

        await vehicle.restore_return(before.return_settings, bench.after(100.0))
        assert (await vehicle.inspect(bench.after(100.0))).return_height_m == before.return_height_m


async def test_link_and_clock_are_measured(driver: Driver) -> None:
    async with open_bench(driver, "arducopter", vehicles=2) as bench:
        await bench.all_ready()
        await bench.until(lambda: all(_has_clock(vehicle) for vehicle in bench.fleet.vehicles().values()))
        for vehicle in bench.fleet.vehicles().values():
            link, loss = vehicle.state.link, vehicle.state.packet_loss_fraction
            assert link is not None
            assert link.address.startswith("127.0.0.1:")
            assert link.living_addresses == 1
            assert link.round_trip_s is not None
            assert link.round_trip_s >= 0.0
            assert loss is not None
            assert loss < 0.5


def _has_clock(vehicle: Vehicle) -> bool:
    return vehicle.state.link is not None and vehicle.state.link.clock_offset_s is not None


async def test_a_vehicle_that_does_not_answer_cannot_be_inspected(driver: Driver) -> None:
    async with open_bench(driver, "arducopter", vehicles=1) as bench, mute_vehicles(bench, range(50, 51)):
        await bench.until(lambda: 50 in bench.fleet.vehicles())
        mute = bench.vehicle(50)
        with pytest.raises(CommandTimeoutError, match="vehicle 50 does not tell its parameters in time"):
            await mute.inspect(bench.after(5.0))
        with pytest.raises(CommandTimeoutError, match="vehicle 50 does not take the geofence in time"):
            await mute.upload_fence(fence_of(bench), bench.after(5.0))
