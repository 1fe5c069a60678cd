"""A mission flies around its no-go zones: to the line, in the steps and home."""

from __future__ import annotations

import numpy as np
import pytest

from aos_gcs.airspace.limits import SafetyOverrides
from aos_gcs.airspace.polygon import signed_depth_m
from aos_gcs.airspace.waypoints import WaypointVerdict
from aos_gcs.mission.model.phase import Outcome
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual

ZONES = (
    ((-20.0, 3.0), (6.0, 3.0), (6.0, 8.0), (-20.0, 8.0)),
    ((-4.0, 22.0), (0.0, 22.0), (0.0, 30.0), (-4.0, 30.0)),
)
"""One between the launch points and the area, one in the middle of the swath."""
MARGIN_M = 1.0


async def watch(flight: Flight, depths_m: list[float]) -> None:
    zones = [np.array(zone) for zone in ZONES]
    while True:
        places_m = [vehicle.position_enu_m() for vehicle in flight.fleet.members.values()]
        depths_m += [signed_depth_m(place_m[:2], zone) for place_m in places_m for zone in zones]
        await flight.clock.sleep(0.1)


async def test_nobody_enters_a_no_go_zone_and_everybody_comes_home() -> None:
    flight = prepare(safety=SafetyOverrides(no_go_enu_m=ZONES, margin_m=MARGIN_M))
    depths_m: list[float] = []
    async with flying(flight) as run:
        watcher = run.get_loop().create_task(watch(flight, depths_m))
        assert await run is Outcome.FOUND
        watcher.cancel()
    assert max(depths_m) < -MARGIN_M + 1e-3
    assert [vehicle.armed for vehicle in flight.fleet.members.values()] == [False] * 4
    for vehicle in flight.fleet.members.values():
        assert vehicle.position_enu_m() == pytest.approx(vehicle.home_enu_m, abs=0.6)
    bent = [w for step in flight.view.steps() for w in step.waypoints if w.verdict is not WaypointVerdict.SENT]
    assert any("no-go zone" in waypoint.reason for waypoint in bent)


async def test_all_land_side_by_side_about_the_return_point() -> None:
    flight = prepare(return_enu_m=(30.0, 20.0))
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 1)
        flight.fleet.members[2].battery_fraction = 0.1
        assert await run is Outcome.FOUND
    places_m = np.array([vehicle.position_enu_m()[:2] for vehicle in flight.fleet.members.values()])
    assert (np.hypot(*(places_m - [30.0, 20.0]).T) < 5.0).all()
    gaps_m = np.hypot(*(places_m[:, None] - places_m[None]).transpose(2, 0, 1)) + 9.0 * np.eye(4)
    assert gaps_m.min() >= 2.0
    assert not any(vehicle.armed for vehicle in flight.fleet.members.values())
