"""Missions whose altitude layers follow the ground, on a fake fleet in virtual time."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("rasterio")

from aos_gcs.errors import MissionError
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.checks import CheckStatus, PreflightCheck
from aos_gcs.mission.model.phase import Outcome, Phase, Suspension
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.preflight import checks
from aos_gcs.planning.search_settings import SearchSettings
from aos_gcs.planning.settings import FlightSettings, PreflightSettings, TerrainSettings
from aos_gcs.ports import Goto, LandedState, ReturnToLaunch
from aos_gcs.runtime.simulated import virtual_time
from tests.fakes.fleet import ORIGIN, FakeVehicle
from tests.fakes.mission_flight import Flight, flying, prepare
from tests.fakes.relief import Relief, hill, level, terrain, write_relief
from tests.fakes.restarted_flight import killed_while_searching, restarted
from tests.fakes.retraced import check_decisions_again

pytestmark = pytest.mark.virtual

FLOOR_M = 30.0
SEPARATION_M = 1.5
CLIMB = "climb of the return"
PREFLIGHT = PreflightSettings(upload_fence=True, set_return_height=True, overrides={CLIMB: "a test"})
RIDGE_M = 10.0
SLOW = FlightSettings(cruise_speed_mps=5.0)
"""Speed at which layers rise and sink by 20 %."""


def ridge(_east: NDArray[np.float64], north: NDArray[np.float64]) -> NDArray[np.float64]:
    """A ridge across the legs, steeper than the layers."""
    return RIDGE_M * np.exp(-(((north - 50.0) / 25.0) ** 2))


def model(folder: Path, relief: Relief = ridge, **values: object) -> TerrainSettings:
    """Return a terrain that layers follow."""
    file = write_relief(folder / "ground.tif", relief, origin=ORIGIN)
    return terrain(file, floor_above_ground_m=FLOOR_M, **{"follow": True, **values})


def over_relief(folder: Path, n: int = 3, relief: Relief = ridge, **changes: object) -> Flight:
    return prepare(n, **{"terrain": model(folder, relief), "preflight": PREFLIGHT, "flight": SLOW, **changes})


async def watch_heights(flight: Flight, relief: Relief, found: list[tuple[float, float]]) -> None:
    """Note the height above the origin and above the ground of all that fly by our commands."""
    while True:
        for one in flight.fleet.members.values():
            if one.state.landed is LandedState.IN_AIR and isinstance(last_command(flight, one), Goto):
                place_m = one.true_enu_m()
                ground_m = float(relief(place_m[:1], place_m[1:2])[0])
                found.append((float(place_m[2]), float(place_m[2]) - ground_m))
        await flight.clock.sleep(0.2)


def last_command(flight: Flight, vehicle: FakeVehicle) -> object:
    (member,) = flight.mission.sortie.context.roster.select([vehicle.vehicle_id])
    return member.last_command


def of_check(flight: Flight, name: str) -> list[PreflightCheck]:
    return [check for check in flight.view.snapshot().preflight if check.name == name]


async def test_a_mission_flies_over_a_ridge_above_the_floor_and_in_separate_layers(tmp_path: Path) -> None:
    flight, found = over_relief(tmp_path), list[tuple[float, float]]()
    async with flying(flight) as run:
        watches = [asyncio.create_task(flight.watch_separation())]
        watches.append(asyncio.create_task(watch_heights(flight, ridge, found)))
        assert await run is Outcome.FOUND
        for watch in watches:
            watch.cancel()
    heights_m, above_m = np.array(found).T
    assert np.ptp(heights_m) > 2.0 * (3 - 1) + 1.5, "the layers rise and sink"
    assert above_m.min() >= FLOOR_M - 1.0
    assert flight.smallest_m >= SEPARATION_M
    assert [flight.task(number) for number in (1, 2, 3)] == [Task.LANDED] * 3
    sent_m = [one.sent_enu_m for step in flight.recorder.steps.values() for one in step.waypoints if one.sent_enu_m]
    assert np.ptp(np.array(sent_m)[:, 2]) > 2.0 * (3 - 1) + 0.5
    check_decisions_again(flight.recorder)


async def test_a_sweep_flies_over_a_ridge_above_the_floor_and_in_separate_layers(tmp_path: Path) -> None:
    """Fronts of a sweep lie far ahead, and are drawn back to where straight ways stay near the layers."""
    flight, found = over_relief(tmp_path, target=None, search=SearchSettings()), list[tuple[float, float]]()
    async with flying(flight) as run:
        watches = [asyncio.create_task(flight.watch_separation())]
        watches.append(asyncio.create_task(watch_heights(flight, ridge, found)))
        assert await run is Outcome.NOT_FOUND
        for watch in watches:
            watch.cancel()
    assert sum(step.branch == "sweep" for step in flight.recorder.steps.values()) >= 10
    heights_m, above_m = np.array(found).T
    assert np.ptp(heights_m) > 2.0 * (3 - 1) + 1.5, "the layers rise and sink"
    assert above_m.min() >= FLOOR_M - 1.0
    assert flight.smallest_m >= SEPARATION_M
    check_decisions_again(flight.recorder)


async def test_over_level_ground_layers_that_follow_are_level(tmp_path: Path) -> None:
    flight = over_relief(tmp_path, 2, level(0.0))
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    assert not of_check(flight, checks.RETURN_CLIMB)
    sent = [one.sent_enu_m for step in flight.view.steps() for one in step.waypoints if one.sent_enu_m is not None]
    assert np.array(sent)[:, 2].reshape(-1, 2) == pytest.approx(np.tile((35.0, 37.5), (len(sent) // 2, 1)), abs=0.05)


async def test_returns_clear_the_highest_ground_at_heights_of_their_own_and_climbs_are_to_be_accepted(
    tmp_path: Path,
) -> None:
    flight = over_relief(tmp_path, auto_start=False, preflight=replace(PREFLIGHT, overrides={}))
    async with flying(flight) as run:
        await flight.until(
            lambda: (
                len(of_check(flight, CLIMB)) == 3
                and all(one.status is CheckStatus.PASS for one in of_check(flight, checks.RETURN_HEIGHT))
            )
        )
        surface = flight.mission.sortie.context.roster.layers.known_surface()
        assert surface.highest_m >= RIDGE_M - 0.5
        for vehicle_id, layer_m in ((1, 35.0), (2, 37.5), (3, 40.0)):
            height_m = flight.fleet.members[vehicle_id].return_height_m
            assert height_m == pytest.approx(layer_m + surface.highest_m, abs=0.1)
        climbs = of_check(flight, CLIMB)
        assert [one.status for one in climbs] == [CheckStatus.FAIL, CheckStatus.FAIL, CheckStatus.PASS]
        assert "through the layers of vehicles that may be above it then: 2" in climbs[0].text
        assert flight.mission.phase is Phase.PREFLIGHT
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_return_height_below_the_highest_layer_place_fails(tmp_path: Path) -> None:
    """A lower one would cross the returns of others, and one of the layer's own height flies into the ridge."""
    flight = over_relief(tmp_path, auto_start=False, preflight=replace(PREFLIGHT, set_return_height=False))
    async with flying(flight) as run:
        await flight.until(lambda: any("30 m, " in one.text for one in of_check(flight, checks.RETURN_HEIGHT)))
        (first, *_) = of_check(flight, checks.RETURN_HEIGHT)
        assert first.status is CheckStatus.FAIL
        assert "m below its layer above the highest place of the ground that the layers follow" in first.text
        assert "(RTL_ALT) to 4" in first.remedy
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_model_that_is_gone_leaves_the_layers_without_heights(tmp_path: Path) -> None:
    gone = terrain(tmp_path / "gone.tif", follow=True)
    flight = over_relief(tmp_path, 2, auto_start=False, terrain=gone)
    async with flying(flight) as run:
        await flight.until(lambda: bool(of_check(flight, checks.TERRAIN)))
        layers = of_check(flight, checks.ALTITUDE_LAYER)
        assert {one.status for one in layers} == {CheckStatus.FAIL}
        assert "its height is not known" in layers[0].text
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_one_that_leaves_flies_home_in_its_layer_and_another_joins_in_it(tmp_path: Path) -> None:
    flight, found = over_relief(tmp_path, target=None), list[tuple[float, float]]()
    async with flying(flight) as run:
        watch = asyncio.create_task(watch_heights(flight, ridge, found))
        await flight.until(lambda: len(flight.view.steps()) == 4)
        await flight.commands.act(Action.PAUSE, None)
        flight.fleet.members[2].battery_fraction = 0.1
        await flight.until(lambda: flight.task(2) is Task.LANDED)
        joining = FakeVehicle(5, flight.clock, np.array((20.0, -3.0, 0.0)), None)
        flight.fleet.members[5] = joining
        await flight.until(lambda: 5 in {v.telemetry.vehicle_id for v in flight.view.snapshot().vehicles})
        await flight.clock.sleep(5.0)
        (result,) = await flight.commands.act(Action.JOIN, (5,))
        assert result.accepted, result.text
        tasks = {}
        while tasks.get(5) is not Task.SWARM:
            tasks = {one.telemetry.vehicle_id: one.task for one in flight.view.snapshot().vehicles}
            await flight.clock.sleep(0.2)
        surface = flight.mission.sortie.context.roster.layers.known_surface()
        place_m = joining.true_enu_m()
        assert place_m[2] - surface.at(place_m) == pytest.approx(37.5, abs=0.5), "the layer that became free"
        await flight.commands.act(Action.RETURN, None)
        await run
        watch.cancel()
    assert min(above_m for _, above_m in found) >= FLOOR_M - 1.0


@pytest.fixture(scope="module")
def last(tmp_path_factory: pytest.TempPathFactory) -> MissionSnapshot:
    """The last state on record of a station that was killed while it searched over the ridge."""

    async def fly() -> MissionSnapshot:
        return await killed_while_searching(over_relief(tmp_path_factory.mktemp("former")), steps=3)

    return virtual_time.run(fly())


def follow(last: MissionSnapshot, settings: TerrainSettings) -> Flight:
    return restarted(last, preflight=PREFLIGHT, flight=SLOW, terrain=settings)


async def test_a_flight_that_is_taken_up_goes_on_above_the_same_surface(last: MissionSnapshot, tmp_path: Path) -> None:
    flight = follow(last, model(tmp_path))
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.TAKEOFF)
        await flight.clock.sleep(2.0)
        roster = flight.mission.sortie.context.roster
        assert [roster.is_in_layer(member) for member in roster.members()] == [True] * 3
        await flight.commands.act(Action.RESUME, None)
        assert await run is Outcome.FOUND


async def test_a_flight_that_is_taken_up_without_its_model_holds_and_returns_by_its_autopilots(
    last: MissionSnapshot, tmp_path: Path
) -> None:
    flight = follow(last, terrain(tmp_path / "gone.tif", follow=True))
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.TAKEOFF)
        await flight.until(lambda: any("The altitude layers follow it" in text for text in flight.texts()))
        with pytest.raises(MissionError, match="follow an elevation model that is not loaded"):
            await flight.commands.act(Action.RESUME, None)
        await flight.clock.sleep(10.0)
        assert flight.view.snapshot().suspension is Suspension.HELD
        assert not any(vehicle.commands for vehicle in flight.fleet.members.values())
        await flight.commands.act(Action.RETURN, None)
        await run
    commands = [command for one in flight.fleet.members.values() for command in one.commands]
    assert not any(isinstance(command, Goto) for command in commands)
    assert sum(isinstance(command, ReturnToLaunch) for command in commands) >= 3


async def test_a_flight_in_level_layers_is_not_taken_up_as_one_that_follows_the_ground(
    last: MissionSnapshot, tmp_path: Path
) -> None:
    flight = follow(replace(last, follows_ground=False), model(tmp_path))
    async with flying(flight) as run:
        await flight.until(lambda: any("cannot be taken up: the plan has changed" in text for text in flight.texts()))
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_layers_follow_hills_beside_the_legs_too(tmp_path: Path) -> None:
    """Detours and findings lead vehicles there; their layers are above it."""
    flight = over_relief(tmp_path, 2, hill(35.0, 40.0, 15.0, radius_m=12.0), auto_start=False)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        surface = flight.mission.sortie.context.roster.layers.known_surface()
        assert surface.at(np.array((35.0, 40.0))) >= 13.0
        await flight.commands.act(Action.ABORT, None)
        await run
