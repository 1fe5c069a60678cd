"""Missions over relief on a fake fleet, in virtual time: what preflight says of the ground, and what is flown."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rasterio")

from aos_gcs.airspace.plans import TrafficSituation, vet_plan
from aos_gcs.airspace.waypoints import WaypointVerdict
from aos_gcs.elevation.model import ModelKind
from aos_gcs.imaging.model import SurfaceKind
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.checks import CheckStatus, PreflightCheck
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.preflight import checks
from aos_gcs.planning.settings import PreflightSettings, TerrainSettings
from tests.fakes.fleet import ORIGIN
from tests.fakes.mission_flight import Flight, flying, prepare
from tests.fakes.relief import Relief, hill, level, terrain, write_relief
from tests.fakes.retraced import check_decisions_again
from tests.fakes.waypoints import request

pytestmark = pytest.mark.virtual


def model(folder: Path, relief: Relief, **values: Any) -> TerrainSettings:
    return terrain(write_relief(folder / "ground.tif", relief, origin=ORIGIN), **values)


async def terrain_checks(flight: Flight) -> dict[int, PreflightCheck]:
    async with flying(flight) as run:
        await flight.until(lambda: any(check.name == checks.TERRAIN for check in flight.view.snapshot().preflight))
        found = {check.vehicle_id: check for check in flight.view.snapshot().preflight if check.name == checks.TERRAIN}
        await flight.commands.act(Action.ABORT, None)
        await run
    return found


async def test_a_mission_over_level_ground_flies_as_without_a_model(tmp_path: Path) -> None:
    flight = prepare(n=2, terrain=model(tmp_path, level(0.0)))
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    found = [check for check in flight.view.snapshot().preflight if check.name == checks.TERRAIN]
    assert {check.status for check in found} == {CheckStatus.PASS}
    assert [check.vehicle_id for check in found] == [1, 2]


async def test_a_hill_below_a_leg_fails_with_place_and_amount(tmp_path: Path) -> None:
    found = await terrain_checks(prepare(n=2, auto_start=False, terrain=model(tmp_path, hill(5.0, 40.0, 25.0))))
    assert found[checks.MISSION].status is CheckStatus.FAIL
    assert "below the floor of 30 m above ground: raise it to 5" in found[checks.MISSION].text
    assert "48.30036, 14.30007" in found[checks.MISSION].text or "m north of the origin" in found[checks.MISSION].text
    assert found[1].status is CheckStatus.PASS


async def test_an_altitude_that_disagrees_with_the_model_fails_with_the_number(tmp_path: Path) -> None:
    found = await terrain_checks(prepare(n=2, auto_start=False, terrain=model(tmp_path, level(-14.0))))
    assert found[1].status is CheckStatus.FAIL
    assert "14." in found[1].text
    assert "above the ground of the elevation model" in found[1].text
    assert not found[1].overridable


async def test_launch_points_correct_what_all_altitudes_err_by(tmp_path: Path) -> None:
    """All vehicles report 8 m too much: the hill is 6 m above them, not 2 m below."""
    raised = terrain(
        write_relief(tmp_path / "a.tif", lambda e, n: hill(0.0, 40.0, 6.0, 12.0)(e, n) - 8.0, origin=ORIGIN)
    )
    found = await terrain_checks(prepare(n=2, auto_start=False, terrain=raised))
    assert found[checks.MISSION].status is CheckStatus.FAIL
    assert re.search(r"rises to (5\.[5-9]|6\.0) m above the origin", found[checks.MISSION].text)


async def test_a_model_that_is_gone_blocks_the_launch_by_name(tmp_path: Path) -> None:
    found = await terrain_checks(prepare(n=2, auto_start=False, terrain=terrain(tmp_path / "gone.tif")))
    assert found[checks.MISSION].status is CheckStatus.FAIL
    assert "gone.tif" in found[checks.MISSION].text


async def test_the_flight_knows_hills_beside_the_plan(tmp_path: Path) -> None:
    """Findings and detours send vehicles beyond their legs."""
    flight = prepare(n=2, auto_start=False, terrain=model(tmp_path, hill(45.0, 40.0, 40.0, radius_m=10.0)))
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        bounds = flight.mission.sortie.context.bounds
        assert bounds.limits is not None
        assert bounds.limits.above_ground is not None
        assert bounds.ground is not None
        lowest_m, highest_m = bounds.ground.bounds_at(np.array([[45.0, 40.0]]))
        assert 30.0 < lowest_m[0] <= highest_m[0] < 41.0
        asked = request(1, (0.0, 40.0, 35.0), (45.0, 40.0, 35.0))
        situation = TrafficSituation(limits=bounds.limits, arrival_radius_m=0.5, movable=(asked,))
        (record,) = vet_plan({1: asked.requested_enu_m}, situation, bounds.detours, bounds.ground)
        assert record.verdict is WaypointVerdict.SHORTENED
        assert "above the ground at" in record.reason
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_heights_above_ground_are_told_and_one_below_the_floor_is_an_alarm(tmp_path: Path) -> None:
    flight = prepare(n=2, target=None, terrain=model(tmp_path, level(-3.0), floor_above_ground_m=30.0))
    low = flight.fleet.members[2]
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        heights_m = [vehicle.height_above_ground_m for vehicle in flight.view.snapshot().vehicles]
        assert heights_m == pytest.approx([35.0, 37.5], abs=0.5)
        assert not any("above the ground, below the floor" in text for text in flight.texts())
        low.goal_enu_m = low.start_enu_m = low.position_enu_m() - np.array([0.0, 0.0, 12.0])
        await flight.until(lambda: any("below the floor of 30 m" in text for text in flight.texts()))
        await flight.until(lambda: any("above the floor above ground again" in text for text in flight.texts()))
        await flight.commands.act(Action.ABORT, None)
        await run
    texts = [text for text in flight.texts() if "below the floor of 30 m" in text]
    assert len(texts) == 1
    assert re.match(r"2[5-6]\.\d m above the ground", texts[0])


async def test_returns_and_landings_below_the_floor_are_none(tmp_path: Path) -> None:
    flight = prepare(n=2, target=None, terrain=model(tmp_path, level(0.0)))
    async with flying(flight) as run:
        await run
    assert {vehicle.task for vehicle in flight.view.snapshot().vehicles} == {Task.LANDED}
    assert not any("below the floor" in text for text in flight.texts())


RISE = 0.05
"""Slope of the ground, metres per metre to the north."""
RETURNING = PreflightSettings(upload_fence=True, set_return_height=True)
"""Vehicles return above the ground."""


def rising(_east: np.ndarray, north: np.ndarray) -> np.ndarray:
    return RISE * north


async def test_the_focal_plane_is_that_of_the_ground_below_the_swarm_then_at_the_target(tmp_path: Path) -> None:
    flight = prepare(n=4, terrain=model(tmp_path, rising), preflight=RETURNING)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN and flight.view.snapshot().step > 1)
        swarm_m = np.mean([frame.position.latitude_deg for step, frame in flight.recorder.frames if step == 1])
        north_m = (swarm_m - ORIGIN.latitude_deg) * math.pi / 180.0 * 6_367_000.0
        assert flight.view.steps()[0].focal_height_m == pytest.approx(RISE * north_m, abs=0.15)
        assert await run is Outcome.FOUND
    target = flight.view.snapshot().target
    assert target is not None
    assert flight.view.steps()[-1].focal_height_m == pytest.approx(RISE * target.position_enu_m[1], abs=0.2)
    check_decisions_again(flight.recorder)


@pytest.mark.parametrize(
    ("kind", "surface"), [(ModelKind.SURFACE, SurfaceKind.TERRAIN), (ModelKind.TERRAIN, SurfaceKind.LEVEL)]
)
async def test_the_focal_plane_stays_level_over_treetops_and_on_request(
    tmp_path: Path, kind: ModelKind, surface: SurfaceKind
) -> None:
    imaging = ImagingSettings(rx_quantile=0.998, plane_height_m=0.5, surface=surface)
    flight = prepare(n=4, target=None, imaging=imaging, terrain=model(tmp_path, rising, kind=kind), preflight=RETURNING)
    async with flying(flight) as run:
        await flight.until(lambda: flight.view.snapshot().step > 2)
        await flight.commands.act(Action.ABORT, None)
        await run
    assert {step.focal_height_m for step in flight.view.steps()} == {0.5}
