"""The contract of the vehicle port with an autopilot of one's own in the loop; docs/sitl.md says how to start one."""

from __future__ import annotations

import math
import os
from collections.abc import Callable

import numpy as np
import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.errors import CommandRefusedError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.ports import (
    Arm,
    Clock,
    Disarm,
    DriverContext,
    FlightMode,
    Goto,
    Hold,
    Land,
    LandedState,
    Notice,
    Takeoff,
    Vehicle,
)
from aos_gcs.service import load_driver

pytestmark = [pytest.mark.sitl, pytest.mark.timeout(600)]

LINKS = {"arducopter": "AOS_SITL_ARDUCOPTER", "px4": "AOS_SITL_PX4"}
HEIGHT_M = 10.0
AWAY_ENU_M = (0.0, 20.0, HEIGHT_M + 2.0)


async def until(clock: Clock, condition: Callable[[], bool], within_s: float) -> None:
    async with clock.timeout_at(clock.now_s() + within_s):
        while not condition():
            await clock.sleep(0.1)


def distance_m(vehicle: Vehicle, frame: LocalFrame, place_enu_m: tuple[float, float, float]) -> float:
    position = vehicle.state.position
    return math.inf if position is None else float(np.linalg.norm(frame.to_enu(position) - place_enu_m))


@pytest.mark.parametrize("autopilot", LINKS)
@pytest.mark.parametrize("driver", ["mavlink", "mavsdk"])
async def test_a_flight_from_take_off_to_landing(driver: str, autopilot: str) -> None:
    link = os.environ.get(LINKS[autopilot])
    if not link:
        pytest.skip(f"needs {LINKS[autopilot]}, such as udpin://0.0.0.0:14550")
    clock = LoopClock()
    notices: list[Notice] = []

    def after(duration_s: float) -> float:
        return clock.now_s() + duration_s

    async with load_driver(driver)([link], DriverContext(clock, lambda: True, notices.append)) as fleet:
        await until(clock, lambda: any(v.state.ready_to_arm for v in fleet.vehicles().values()), 180.0)
        vehicle = next(v for v in fleet.vehicles().values() if v.state.ready_to_arm)
        assert vehicle.state.autopilot == autopilot
        assert vehicle.state.home is not None
        frame = LocalFrame(vehicle.state.home)
        with pytest.raises(CommandRefusedError, match="take off first"):
            await vehicle.execute(Goto(vehicle.state.home, 5.0), after(5.0))

        await vehicle.execute(Arm(), after(30.0))
        try:
            await vehicle.execute(Takeoff(HEIGHT_M), after(90.0))
            with pytest.raises(CommandRefusedError, match="land it"):
                await vehicle.execute(Disarm(), after(5.0))
            await vehicle.execute(Goto(frame.to_geodetic(AWAY_ENU_M), 5.0), after(15.0))
            await until(clock, lambda: distance_m(vehicle, frame, AWAY_ENU_M) < 1.5, 60.0)
            await vehicle.execute(Goto(frame.to_geodetic((0.0, 200.0, HEIGHT_M)), 5.0), after(15.0))
            await clock.sleep(5.0)
            await vehicle.execute(Hold(), after(15.0))
            assert vehicle.state.mode is FlightMode.HOLD
            await until(clock, lambda: math.hypot(*(vehicle.state.velocity_enu_mps or (9.0,))) < 0.5, 15.0)
            assert distance_m(vehicle, frame, (0.0, 0.0, HEIGHT_M)) < 120.0
        finally:
            await vehicle.execute(Land(), after(15.0))
        await until(clock, lambda: vehicle.state.landed is LandedState.ON_GROUND and not vehicle.state.armed, 120.0)
