"""Simulated vehicles behind the port of drivers, without autopilots and links, in virtual time."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Coroutine

import numpy as np
import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.errors import CommandRefusedError, CommandTimeoutError, ConfigurationError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.lab.flights import FlightParameters, build_flight
from aos_gcs.ports import (
    Arm,
    Capture,
    Disarm,
    FlightMode,
    Goto,
    Hold,
    Land,
    LandedState,
    ReturnToLaunch,
    Takeoff,
    Vehicle,
)
from aos_gcs.runtime.simulated.virtual_time import run
from aos_sim.errors.model import error_model
from aos_sim.flights.world import SimulatedFlight
from aos_sim.world.scene import Scene, SceneParameters, build_scene

HEIGHT_M = 20.0


@pytest.fixture(scope="module")
def meadow() -> Scene:
    return build_scene(SceneParameters(seed=1, trees_per_ha=0.0, side_m=20.0))


class Flown:
    """Two vehicles over a meadow."""

    def __init__(self, scene: Scene, grade: str) -> None:
        self.clock = LoopClock()
        self.flight = SimulatedFlight(scene, error_model(grade), 2, 64, seed=3)
        self.frame = LocalFrame(self.flight.origin)
        self.vehicles = self.flight.fleet(self.clock).vehicles()
        self.one: Vehicle = self.vehicles[1]

    def place_enu_m(self) -> np.ndarray:
        assert self.one.state.position is not None
        return self.frame.to_enu(self.one.state.position)

    def goto(self, east_m: float, north_m: float) -> Goto:
        return Goto(self.frame.to_geodetic(np.array([east_m, north_m, HEIGHT_M])), 10.0)

    async def take_off(self) -> None:
        await self.one.execute(Arm(), self.clock.now_s() + 5.0)
        await self.one.execute(Takeoff(HEIGHT_M), self.clock.now_s() + 60.0)
        await self.clock.sleep(5.0)


Work = Callable[[Flown], Coroutine[None, None, None]]


def fly(scene: Scene, work: Work, grade: str = "none") -> None:
    async def flown() -> None:
        await work(Flown(scene, grade))

    run(flown())


def test_it_takes_off_flies_returns_lands_and_disarms(meadow: Scene) -> None:
    async def work(flown: Flown) -> None:
        home_enu_m = flown.place_enu_m()
        await flown.take_off()
        assert flown.one.state.landed is LandedState.IN_AIR
        assert flown.place_enu_m()[2] == pytest.approx(HEIGHT_M, abs=0.2)
        await flown.one.execute(flown.goto(10.0, 15.0), flown.clock.now_s() + 5.0)
        await flown.clock.sleep(15.0)
        assert flown.place_enu_m() == pytest.approx([10.0, 15.0, HEIGHT_M], abs=0.2)
        await flown.one.execute(ReturnToLaunch(), flown.clock.now_s() + 5.0)
        await flown.clock.sleep(90.0)
        state = flown.one.state
        assert (state.mode, state.landed, state.armed) == (FlightMode.RETURN, LandedState.ON_GROUND, False)
        assert math.dist(flown.place_enu_m()[:2], home_enu_m[:2]) < 0.6
        assert flown.flight.landed == 2
        assert flown.flight.min_separation_m == pytest.approx(5.0, abs=1.0)

    fly(meadow, work)


def test_what_a_vehicle_must_not_do_is_refused(meadow: Scene) -> None:
    async def work(flown: Flown) -> None:
        def soon_s() -> float:
            return flown.clock.now_s() + 5.0

        with pytest.raises(CommandRefusedError, match="is not armed"):
            await flown.one.execute(Takeoff(HEIGHT_M), soon_s())
        with pytest.raises(CommandRefusedError, match="is not flying"):
            await flown.one.execute(flown.goto(1.0, 1.0), soon_s())
        await flown.one.execute(Arm(), soon_s())
        with pytest.raises(CommandTimeoutError):
            await flown.one.execute(Takeoff(HEIGHT_M), flown.clock.now_s() + 1.0)
        with pytest.raises(CommandRefusedError, match="is not on the ground"):
            await flown.one.execute(Disarm(), soon_s())
        climb = asyncio.create_task(flown.one.execute(Takeoff(HEIGHT_M), flown.clock.now_s() + 60.0))
        await flown.clock.sleep(1.0)
        await flown.one.execute(Hold(), soon_s())
        with pytest.raises(CommandRefusedError, match="another command"):
            await climb
        assert flown.one.state.mode is FlightMode.HOLD
        await flown.one.execute(Land(), soon_s())
        await flown.clock.sleep(30.0)
        assert flown.flight.landed == 2

    fly(meadow, work)


def test_images_and_poses_are_the_same_in_every_run_and_err_by_the_grade(meadow: Scene) -> None:
    captures: list[Capture] = []

    async def work(flown: Flown) -> None:
        await flown.take_off()
        captures.append(await flown.one.capture(flown.clock.now_s() + 5.0))

    fly(meadow, work, "gnss")
    fly(meadow, work, "gnss")
    fly(meadow, work, "none")
    first, again, exact = captures
    assert first.image.shape == (64, 64, 4)
    assert np.array_equal(first.image, again.image)
    assert (first.position, first.camera) == (again.position, again.camera)
    frame = LocalFrame(SimulatedFlight(meadow, error_model("none"), 2, 64, seed=3).origin)
    off_m = np.linalg.norm(frame.to_enu(first.position) - frame.to_enu(exact.position))
    # It hovers where it believes to be: the same place to both, but for the gusts and the place where it stood.
    assert 0.05 < off_m < 5.0
    assert not np.array_equal(first.image, exact.image)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [({"vehicles": 0}, "vehicles"), ({"errors": "perfect"}, "--errors"), ({"conditions": "hail"}, "conditions")],
)
def test_settings_out_of_range_are_refused(changes: dict[str, object], expected: str) -> None:
    settings = {"seed": 1, "vehicles": 3, "trees_per_ha": 0.0, "has_person": False, "side_m": 20.0} | changes
    with pytest.raises(ConfigurationError, match=expected):
        build_flight(FlightParameters(**settings))
