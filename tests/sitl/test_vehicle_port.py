"""The contract of the vehicle port with an autopilot of one's own in the loop; docs/sitl.md says how to start one."""

from __future__ import annotations

import math
import os
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.clock import LoopClock
from aos_gcs.errors import CommandError, CommandRefusedError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.fleet.homes import next_home
from aos_gcs.ports import (
    Arm,
    Clock,
    Disarm,
    DriverContext,
    FlightMode,
    Geofence,
    Goto,
    Hold,
    Land,
    LandedState,
    Notice,
    ReturnToLaunch,
    Takeoff,
    Vehicle,
)
from aos_gcs.runtime.drivers import load_driver

pytestmark = [pytest.mark.sitl, pytest.mark.timeout(600)]

LINKS = {"arducopter": "AOS_SITL_ARDUCOPTER", "px4": "AOS_SITL_PX4"}
HEIGHT_M = 10.0
AWAY_ENU_M = (0.0, 20.0, HEIGHT_M + 2.0)
FAR_ENU_M = (0.0, 55.0, HEIGHT_M)
RISING_ENU_M = ((30.0, HEIGHT_M), (60.0, HEIGHT_M + 6.0), (90.0, HEIGHT_M + 6.0), (120.0, HEIGHT_M))
"""North of where it took off, and up, of the waypoints of a sweep over a hill."""
SWEEP_MPS = 5.0
BRAKING_M = 12.5
"""Distance before a waypoint at which the next one is sent: the stopping distance."""
SPEEDING_UP_M = 15.0
RETURN_HEIGHT_M = 18.0
"""Height within the fence, which the vehicle keeps from one test to the next."""


async def until(clock: Clock, condition: Callable[[], bool], within_s: float) -> None:
    async with clock.timeout_at(clock.now_s() + within_s):
        while not condition():
            await clock.sleep(0.1)


def distance_m(vehicle: Vehicle, frame: LocalFrame, place_enu_m: tuple[float, float, float]) -> float:
    position = vehicle.state.position
    return math.inf if position is None else float(np.linalg.norm(frame.to_enu(position) - place_enu_m))


@dataclass(frozen=True)
class Bench:
    """The first vehicle that is ready to arm."""

    vehicle: Vehicle
    clock: Clock
    frame: LocalFrame
    """Local frame about the home that the vehicle will have once it is armed."""

    def after(self, duration_s: float) -> float:
        """Return the deadline so many seconds from now."""
        return self.clock.now_s() + duration_s

    async def landed(self) -> None:
        """Land, and wait until the motors stand still."""
        state = self.vehicle.state
        if state.armed:
            await self.vehicle.execute(Land(), self.after(15.0))
        await until(self.clock, lambda: _stands(self.vehicle), 120.0)


def _stands(vehicle: Vehicle) -> bool:
    return vehicle.state.landed is LandedState.ON_GROUND and not vehicle.state.armed


@asynccontextmanager
async def open_bench(driver: str, autopilot: str) -> AsyncIterator[Bench]:
    link = os.environ.get(LINKS[autopilot])
    if not link:
        pytest.skip(f"needs {LINKS[autopilot]}, such as udpin://0.0.0.0:14550")
    clock = LoopClock()
    notices: list[Notice] = []
    async with load_driver(driver)([link], DriverContext(clock, lambda: True, notices.append)) as fleet:
        await until(clock, lambda: any(v.state.ready_to_arm for v in fleet.vehicles().values()), 180.0)
        vehicle = next(v for v in fleet.vehicles().values() if v.state.ready_to_arm)
        assert vehicle.state.autopilot == autopilot
        home = next_home(vehicle.state)  # the flight before may have ended far from where it began
        assert home is not None
        yield Bench(vehicle, clock, LocalFrame(home))


everywhere = pytest.mark.parametrize(
    ("driver", "autopilot"), [(driver, autopilot) for driver in ("mavlink", "mavsdk") for autopilot in LINKS]
)


@everywhere
async def test_a_flight_from_take_off_to_landing(driver: str, autopilot: str) -> None:
    async with open_bench(driver, autopilot) as bench:
        vehicle, clock, frame, after = bench.vehicle, bench.clock, bench.frame, bench.after
        with pytest.raises(CommandRefusedError, match="take off first"):
            await vehicle.execute(Goto(frame.origin, 5.0), after(5.0))

        await vehicle.execute(Arm(), after(30.0))
        try:
            await vehicle.execute(Takeoff(HEIGHT_M), after(90.0))
            with pytest.raises(CommandRefusedError, match="land it"):
                await vehicle.execute(Disarm(), after(5.0))
            await vehicle.execute(Goto(frame.to_geodetic(AWAY_ENU_M), 5.0), after(15.0))
            await until(clock, lambda: distance_m(vehicle, frame, AWAY_ENU_M) < 1.5, 60.0)
            await vehicle.execute(Goto(frame.to_geodetic(FAR_ENU_M), 3.0), after(15.0))
            await clock.sleep(5.0)
            speed_mps = math.hypot(*(vehicle.state.velocity_enu_mps or ()))
            assert speed_mps == pytest.approx(3.0, abs=1.0)
            await vehicle.execute(Hold(), after(15.0))
            assert vehicle.state.mode is FlightMode.HOLD
            await until(clock, lambda: math.hypot(*(vehicle.state.velocity_enu_mps or (9.0,))) < 0.5, 15.0)
            assert distance_m(vehicle, frame, FAR_ENU_M) > 10.0
        finally:
            await bench.landed()


@everywhere
async def test_waypoints_that_move_on_are_flown_to_without_slowing_down(driver: str, autopilot: str) -> None:
    """The next waypoint, as on the legs of a continuous search, comes long before it would brake for the last one."""
    async with open_bench(driver, autopilot) as bench:
        vehicle, clock, frame, after = bench.vehicle, bench.clock, bench.frame, bench.after
        await vehicle.execute(Arm(), after(30.0))
        try:
            await vehicle.execute(Takeoff(HEIGHT_M), after(90.0))
            # A take-off counts as done just below its height; the lines are measured from where the climb ends.
            await until(clock, lambda: abs((vehicle.state.velocity_enu_mps or (0.0, 0.0, 9.0))[2]) < 0.1, 20.0)
            slowest_mps, farthest_m = math.inf, 0.0
            begin_enu_m = _place_enu_m(vehicle, frame)
            for north_m, height_m in RISING_ENU_M:
                start_enu_m = _place_enu_m(vehicle, frame)
                end_enu_m = np.array((begin_enu_m[0], begin_enu_m[1] + north_m, height_m))
                await vehicle.execute(Goto(frame.to_geodetic(end_enu_m), SWEEP_MPS), after(15.0))
                while (place_enu_m := _place_enu_m(vehicle, frame))[1] < end_enu_m[1] - BRAKING_M:
                    if place_enu_m[1] - begin_enu_m[1] > SPEEDING_UP_M:
                        slowest_mps = min(slowest_mps, math.hypot(*(vehicle.state.velocity_enu_mps or ())))
                    farthest_m = max(farthest_m, _off_line_m(place_enu_m, start_enu_m, end_enu_m))
                    await clock.sleep(0.1)
            assert slowest_mps > 0.8 * SWEEP_MPS
            assert farthest_m < 0.75
        finally:
            await bench.landed()


def _place_enu_m(vehicle: Vehicle, frame: LocalFrame) -> NDArray[np.float64]:
    assert vehicle.state.position is not None
    return frame.to_enu(vehicle.state.position)


def _off_line_m(place_m: NDArray[np.float64], start_m: NDArray[np.float64], end_m: NDArray[np.float64]) -> float:
    """Return the distance of a place from the straight line between two others."""
    along = (end_m - start_m) / np.linalg.norm(end_m - start_m)
    return float(np.linalg.norm(np.cross(place_m - start_m, along)))


@everywhere
async def test_a_fence_is_read_back_and_kept(driver: str, autopilot: str) -> None:
    async with open_bench(driver, autopilot) as bench:
        vehicle, frame, after = bench.vehicle, bench.frame, bench.after
        before = await vehicle.inspect(after(30.0))
        assert before.firmware
        assert before.return_height_m > 0.0

        square, notch = (
            ((-60.0, -60.0), (60.0, -60.0), (60.0, 60.0), (-60.0, 60.0)),
            ((20.0, 20.0), (30.0, 20.0), (20.0, 30.0)),
        )
        rings = [[frame.to_geodetic((*corner, 0.0)) for corner in ring] for ring in (square, notch)]
        inclusion, exclusion = (tuple((place.latitude_deg, place.longitude_deg) for place in ring) for ring in rings)
        fence = Geofence(inclusion, (exclusion,), ceiling_above_home_m=40.0)
        await vehicle.upload_fence(fence, after(30.0))
        facts = await vehicle.inspect(after(30.0))
        assert facts.fence is not None
        assert facts.fence.is_same_as(fence)
        assert facts.at_fence.is_on

        await vehicle.execute(Arm(), after(30.0))
        try:
            await vehicle.execute(Takeoff(HEIGHT_M), after(90.0))
            for place_enu_m in ((0.0, 80.0, HEIGHT_M), (23.0, 23.0, HEIGHT_M), (0.0, 10.0, 60.0)):
                with pytest.raises(CommandError):
                    await vehicle.execute(Goto(frame.to_geodetic(place_enu_m), 5.0), after(8.0))
                assert distance_m(vehicle, frame, (0.0, 0.0, HEIGHT_M)) < 5.0
        finally:
            await bench.landed()


@everywhere
async def test_a_return_height_is_kept_and_set_back(driver: str, autopilot: str) -> None:
    async with open_bench(driver, autopilot) as bench:
        vehicle, clock, frame, after = bench.vehicle, bench.clock, bench.frame, bench.after
        before = await vehicle.inspect(after(30.0))
        await vehicle.set_return_height(RETURN_HEIGHT_M, after(30.0))
        try:
            assert (await vehicle.inspect(after(30.0))).return_height_m == pytest.approx(RETURN_HEIGHT_M, abs=0.01)
            await vehicle.execute(Arm(), after(30.0))
            try:
                await vehicle.execute(Takeoff(HEIGHT_M), after(90.0))
                with pytest.raises(CommandRefusedError, match="is armed"):
                    await vehicle.set_return_height(2.0 * RETURN_HEIGHT_M, after(5.0))
                await vehicle.execute(Goto(frame.to_geodetic(AWAY_ENU_M), 5.0), after(15.0))
                await until(clock, lambda: distance_m(vehicle, frame, AWAY_ENU_M) < 1.5, 60.0)
                # A PX4 moves the altitude of its home in flight, but returns at the height above the one it had before.
                home, heights_m = vehicle.state.home, [HEIGHT_M]
                assert home is not None
                await vehicle.execute(ReturnToLaunch(), after(15.0))
                while vehicle.state.armed:
                    assert vehicle.state.position is not None
                    heights_m.append(vehicle.state.position.altitude_amsl_m - home.altitude_amsl_m)
                    await clock.sleep(0.2)
                assert max(heights_m) == pytest.approx(RETURN_HEIGHT_M, abs=1.0)
            finally:
                await bench.landed()
        finally:
            await vehicle.restore_return(before.return_settings, after(30.0))
        assert (await vehicle.inspect(after(30.0))).return_settings == before.return_settings
