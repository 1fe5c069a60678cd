"""Missions of vehicles whose altitudes err: refused before the launch, or flown at their true distances."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.errors import MissionFailedError
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import Deadlines, FlightSettings, PreflightSettings
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual

SEPARATION_M = 1.5
BAD = {"bias_m": (0.5, 2.0), "swing_m": (0.2, 0.1)}
LONG_AREA = ((-12.0, 10.0), (12.0, 10.0), (12.0, 130.0), (-12.0, 130.0))
SHORT_RETURN = Deadlines(connect_s=5.0, preflight_s=15.0, capture_s=5.0, transfer_s=20.0, land_s=60.0)
OVERRIDDEN = PreflightSettings(
    upload_fence=True,
    overrides={"home altitude": "measured: the meadow is level", "altitude accuracy": "a test of the datum"},
)


@asynccontextmanager
async def watched(flight: Flight) -> AsyncIterator[asyncio.Task[Outcome]]:
    """Fly, and watch the true distances."""
    async with flying(flight) as run:
        watch = asyncio.create_task(flight.watch_separation())
        yield run
        with suppress(MissionFailedError):
            await run
        watch.cancel()


def report(flight: Flight, fix: int, horizontal_m: float, vertical_m: float) -> None:
    """Have all vehicles report these accuracies."""
    for vehicle in flight.fleet.members.values():
        vehicle.gps_fix, vehicle.horizontal_accuracy_m, vehicle.vertical_accuracy_m = fix, horizontal_m, vertical_m


def failures(flight: Flight) -> set[str]:
    return {check.name for check in flight.view.snapshot().preflight if check.blocks}


@pytest.mark.parametrize(
    ("reported", "names"),
    [
        ((3, 0.4, 2.0), {"home altitude", "altitude accuracy"}),
        # Receivers that know it better than their estimates, which were begun before they had their corrections.
        ((6, 0.02, 0.03), {"home altitude"}),
    ],
    ids=["honest", "believed to be RTK"],
)
async def test_altitudes_that_err_by_metres_are_refused(reported: tuple[int, float, float], names: set[str]) -> None:
    flight = prepare(6, errors=BAD)
    report(flight, *reported)
    async with watched(flight) as run:
        await flight.until(lambda: failures(flight) == names)
        await flight.until(run.done)
    assert not any(vehicle.armed or vehicle.commands for vehicle in flight.fleet.members.values())
    assert run.result() is Outcome.FAILED


@pytest.mark.parametrize("seed", range(4))
async def test_errors_of_altitude_that_were_overridden_are_taken_out_on_the_ground(seed: int) -> None:
    flight = prepare(6, errors=BAD, preflight=OVERRIDDEN, seed=seed)
    for vehicle in flight.fleet.members.values():
        ground_enu_m = vehicle.home_enu_m - vehicle.errors.estimate_enu_m(0.0)
        vehicle.errors = replace(vehicle.errors, seed=vehicle.errors.seed + 100 * seed)
        vehicle.home_enu_m = ground_enu_m + vehicle.errors.estimate_enu_m(0.0)
        vehicle.__post_init__()
    report(flight, 3, 0.5, 2.0)
    async with watched(flight):
        pass
    assert flight.smallest_m >= SEPARATION_M
    assert all(flight.task(vehicle_id) is Task.LANDED for vehicle_id in flight.fleet.members)


async def test_slopes_measured_by_rtk_are_no_errors() -> None:
    flight = prepare(4)
    for vehicle_id, vehicle in flight.fleet.members.items():
        vehicle.home_enu_m = vehicle.home_enu_m + np.array([0.0, 0.0, 1.5 * vehicle_id])
        vehicle.__post_init__()
    async with watched(flight) as run:
        await flight.until(lambda: flight.view.snapshot().phase == "line")
        layers_m = {v.telemetry.vehicle_id: v.layer_height_m for v in flight.view.snapshot().vehicles}
        heights_m = {one: vehicle.true_enu_m()[2] for one, vehicle in flight.fleet.members.items()}
        assert heights_m == pytest.approx(layers_m, abs=0.15)
    assert run.result() is Outcome.FOUND
    assert flight.smallest_m >= SEPARATION_M


async def test_a_height_that_runs_away_in_flight_is_found_and_the_vehicle_leaves() -> None:
    flight = prepare(
        5, target=None, flight=FlightSettings(layer_spacing_m=3.0), area_enu_m=LONG_AREA, camera_delay_s=1.0
    )
    async with watched(flight) as run:
        await flight.until(lambda: flight.view.snapshot().phase == "scan")
        vehicle = flight.fleet.members[3]
        now_s = flight.clock.now_s()
        vehicle.errors = replace(vehicle.errors, climb_mps=0.05, climb_from_s=now_s)
        await flight.until(lambda: flight.task(3) is not Task.SWARM)
        assert vehicle.position_enu_m()[2] - vehicle.true_enu_m()[2] < 1.5
        await flight.until(run.done)
    assert flight.smallest_m >= SEPARATION_M
    (text,) = [text for text in flight.texts() if text.startswith("wrong altitude")]
    assert "below the height that it reports, by its satellite receiver and the others" in text
    assert {one: flight.task(one) for one in flight.fleet.members} == dict.fromkeys(flight.fleet.members, Task.LANDED)


def degrade(flight: Flight, vehicle_ids: range, **reported: object) -> None:
    """Have vehicles report another accuracy or fix from now on."""
    for vehicle_id in vehicle_ids:
        for name, value in reported.items():
            setattr(flight.fleet.members[vehicle_id], name, value)


def told(flight: Flight) -> list[str]:
    beginnings = "its altitude is accurate to", "it has lost its RTK", "its estimator rejects"
    return [text for text in flight.texts() if text.startswith(beginnings)]


@pytest.mark.parametrize(
    ("reported", "words"),
    [
        ({"vertical_accuracy_m": 1.5}, "its altitude is accurate to ± 3.0 m only (95 %), layers of 2.5 m allow ± 0.2"),
        ({"gps_fix": 3}, "it has lost its RTK fix, which layers of 2.5 m need"),
        ({"altitude_test_ratio": 1.2}, "its estimator rejects the heights that it measures (120% of what it accepts)"),
    ],
    ids=["accuracy", "fix", "estimator"],
)
async def test_a_vehicle_whose_altitude_becomes_inaccurate_leaves_and_others_keep_clear(
    reported: dict[str, object], words: str
) -> None:
    flight = prepare(4, target=None, area_enu_m=LONG_AREA, camera_delay_s=1.0)
    async with watched(flight) as run:
        await flight.until(lambda: flight.view.snapshot().phase == "scan")
        member = flight.mission.sortie.context.roster.select([2])[0]
        before_m = flight.mission.sortie.context.flight.accuracy(member).vertical_m
        degrade(flight, range(2, 3), **reported)
        await flight.until(lambda: flight.task(2) is Task.RETURNING)
        after_m = flight.mission.sortie.context.flight.accuracy(member).vertical_m
        assert after_m == reported.get("vertical_accuracy_m", before_m)
        await flight.until(lambda: flight.task(2) is Task.LANDED)
        assert flight.view.snapshot().phase in {"line", "scan"}
        await flight.commands.act(Action.RETURN, None)
        await run
    (text,) = told(flight)
    assert text.startswith(words)
    assert flight.smallest_m >= SEPARATION_M


async def test_a_short_loss_of_accuracy_or_of_the_fix_changes_nothing() -> None:
    flight = prepare(4)
    async with watched(flight) as run:
        await flight.until(lambda: flight.view.snapshot().phase == "scan")
        for bad, good in (
            ({"vertical_accuracy_m": 5.0}, {"vertical_accuracy_m": 0.03}),
            ({"gps_fix": 4}, {"gps_fix": 6}),
        ):
            degrade(flight, range(1, 5), **bad)
            await flight.clock.sleep(4.0)
            degrade(flight, range(1, 5), **good)
            await flight.clock.sleep(1.0)
    assert run.result() is Outcome.FOUND
    assert not told(flight)


@pytest.mark.parametrize("phase", ["line", "scan", "converge"])
async def test_all_fly_home_when_all_lose_their_corrections_at_once(phase: str) -> None:
    # So close to one another, they wait above their homes until it is over.
    flight = prepare(4, deadlines=SHORT_RETURN)
    async with watched(flight) as run:
        await flight.until(lambda: flight.view.snapshot().phase == phase)
        degrade(flight, range(1, 5), gps_fix=3, horizontal_accuracy_m=1.5, vertical_accuracy_m=3.0)
        await flight.until(run.done)
    assert {one: flight.task(one) for one in flight.fleet.members} == dict.fromkeys(flight.fleet.members, Task.LANDED)
    assert len(told(flight)) == 4
    assert flight.smallest_m >= SEPARATION_M


async def test_an_accuracy_that_was_overridden_on_the_ground_is_not_found_again_in_flight() -> None:
    flight = prepare(4, target=None, preflight=OVERRIDDEN)
    report(flight, 3, 0.5, 1.0)
    async with watched(flight) as run:
        await flight.until(lambda: flight.view.snapshot().phase == "scan")
        report(flight, 3, 0.5, 1.4)
        await flight.clock.sleep(8.0)
        assert not told(flight)
        report(flight, 3, 0.5, 1.6)
        await flight.until(lambda: len(told(flight)) == 4)
        await flight.until(run.done)


async def test_layers_of_three_metres_without_rtk_need_accurate_altitudes_only() -> None:
    flight = prepare(4, flight=FlightSettings(layer_spacing_m=3.0))
    report(flight, 3, 0.3, 0.25)
    async with watched(flight) as run:
        pass
    assert run.result() is Outcome.FOUND
    assert flight.smallest_m >= SEPARATION_M


async def test_layers_below_three_metres_need_rtk_even_where_altitudes_seem_accurate() -> None:
    flight = prepare(4)
    report(flight, 3, 0.02, 0.03)
    async with watched(flight):
        await flight.until(lambda: failures(flight) == {"altitude accuracy"})
    (check, *_) = [check for check in flight.view.snapshot().preflight if check.name == "altitude accuracy"]
    assert "layers of 2.5 m need an RTK fix" in check.remedy
