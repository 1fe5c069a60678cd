"""All autopilots return by themselves at the same time: ways home that cross, in virtual time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.ports import Arm, DriverContext, Goto, Takeoff
from aos_sim.swarm import SimulatedSwarm
from tests.fakes.air import Air
from tests.fakes.air_flight import SEPARATION_M, simulated

pytestmark = [pytest.mark.looptime, pytest.mark.slow, pytest.mark.timeout(900)]

LAYERS_M = {1: 35.0, 2: 37.0, 3: 39.0}
PLACES_M = {1: (12.0, 24.0), 2: (0.0, 30.0), 3: (-12.0, 38.0)}
"""East and north of where they search. Their launch points lie in a row, the first in the west: the ways home of 1 and
3 cross. 3 has less to climb to one height and further to fly, so that both are at the crossing at the same time."""
ONE_HEIGHT_M = 60.0
LEVEL_M = {1: 0.0, 2: 0.0, 3: 0.0}
HILLSIDE_M = {1: 9.0, 2: 6.0, 3: 3.0}
"""Height by which the layers, which follow the ground, are lower in the search area than above its highest place."""
ALIKE = {
    "arducopter": {"FS_GCS_ENABLE": 1.0, "WPNAV_SPEED_UP": 300.0, "RTL_ALT": 100.0 * ONE_HEIGHT_M},
    "px4": {"NAV_DLL_ACT": 2.0, "RTL_RETURN_ALT": ONE_HEIGHT_M},
}


@pytest.mark.parametrize(
    ("autopilot", "in_layers", "lower_m"),
    [
        ("arducopter", True, LEVEL_M),
        ("px4", True, LEVEL_M),
        ("arducopter", True, HILLSIDE_M),
        ("px4", True, HILLSIDE_M),
        ("arducopter", False, LEVEL_M),
    ],
    ids=["arducopter", "px4", "arducopter, hillside", "px4, hillside", "one height"],
)
async def test_all_lose_the_link_at_once(
    monkeypatch: pytest.MonkeyPatch, autopilot: str, in_layers: bool, lower_m: Mapping[int, float]
) -> None:
    clock, air = LoopClock(), Air()
    context = DriverContext(clock=clock, is_healthy=lambda: True, notify=lambda _: None)
    options = {"vehicles": 3, "autopilot": autopilot, "parameters": ALIKE[autopilot]}
    async with simulated(monkeypatch, air, context, {}, **options) as (fleet, swarm):

        async def until(condition: Callable[[], bool], timeout_s: float) -> None:
            async with clock.timeout_at(clock.now_s() + timeout_s):
                while not condition():
                    await clock.sleep(0.2)

        async def bring(vehicle_id: int) -> None:
            vehicle, height_m = fleet.vehicles()[vehicle_id], LAYERS_M[vehicle_id]
            if in_layers:
                await vehicle.set_return_height(height_m, clock.now_s() + 30.0)
            await vehicle.execute(Arm(), clock.now_s() + 30.0)
            await vehicle.execute(Takeoff(height_m), clock.now_s() + 60.0)
            place_enu_m = (*PLACES_M[vehicle_id], height_m - lower_m[vehicle_id])
            await vehicle.execute(Goto(swarm.frame.to_geodetic(place_enu_m), 8.0), clock.now_s() + 30.0)
            await until(lambda: swarm.kinematics(vehicle_id).position_enu_m[1] > place_enu_m[1] - 0.3, 60.0)

        await until(lambda: len(fleet.vehicles()) == 3, 30.0)
        await until(lambda: all(vehicle.state.ready_to_arm for vehicle in fleet.vehicles().values()), 60.0)
        await asyncio.gather(*map(bring, LAYERS_M))
        assert _smallest_m(swarm) >= SEPARATION_M
        air.cut |= {0, 1, 2}
        await until(lambda: swarm.report().landed == 3 or _smallest_m(swarm) < SEPARATION_M, 240.0)
        assert (_smallest_m(swarm) >= SEPARATION_M) is in_layers, "at one height they meet: it is the layers that count"


def _smallest_m(swarm: SimulatedSwarm) -> float:
    smallest_m = swarm.report().min_separation_m
    assert smallest_m is not None
    return smallest_m
