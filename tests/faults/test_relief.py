"""Missions in layers that follow the ground, flown by the driver with both simulated autopilots, in virtual time."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("rasterio")

from aos_gcs.imaging.model import SurfaceKind
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.phases import ENDING
from aos_gcs.planning.settings import FlightSettings, PreflightSettings
from aos_sim.swarm import SwarmOptions
from tests.fakes.air import Air
from tests.fakes.air_flight import AirFlight, flying_over
from tests.fakes.relief import terrain, write_relief

pytestmark = [pytest.mark.looptime, pytest.mark.slow, pytest.mark.timeout(900)]

FLOOR_M = 30.0
SLOW = FlightSettings(cruise_speed_mps=5.0)
"""Speed at which layers rise and sink by 20 %."""
PREFLIGHT = PreflightSettings(
    upload_fence=True, set_return_height=True, overrides={"climb of the return": "a test", "geofence": "a test"}
)


def ridge(_east: NDArray[np.float64], north: NDArray[np.float64]) -> NDArray[np.float64]:
    """A ridge across the legs."""
    return 8.0 * np.exp(-(((north - 45.0) / 22.0) ** 2))


async def watch(flight: AirFlight, found: list[tuple[float, float]]) -> None:
    """Note the true height above the origin and above the ground of each vehicle of the swarm."""
    while flight.mission.phase not in ENDING:
        for one in flight.mission.view.snapshot().vehicles:
            if one.task is Task.SWARM and one.waypoint_enu_m is not None:
                place_m = np.array(flight.swarm.kinematics(one.telemetry.vehicle_id).position_enu_m)
                found.append((place_m[2], place_m[2] - ridge(place_m[:1], place_m[1:2])[0]))
        await flight.clock.sleep(0.2)


@pytest.mark.parametrize("autopilot", ["arducopter", "px4"])
async def test_both_autopilots_keep_their_layers_over_a_ridge(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, autopilot: str
) -> None:
    origin = SwarmOptions(links=("udpout://127.0.0.1:1",)).origin
    file = write_relief(tmp_path / "ground.tif", ridge, origin=origin)
    found: list[tuple[float, float]] = []
    async with flying_over(
        monkeypatch,
        Air(),
        autopilot=autopilot,
        terrain=terrain(file, floor_above_ground_m=FLOOR_M, follow=True),
        imaging=ImagingSettings(rx_quantile=0.998, surface=SurfaceKind.LEVEL),
        preflight=PREFLIGHT,
        flight=SLOW,
    ) as flight:
        watching = asyncio.create_task(watch(flight, found))
        assert await flight.run is Outcome.FOUND, flight.texts()
        await watching
        flight.assert_nobody_was_endangered()
        assert flight.swarm.report().landed == 3
    heights_m, above_m = np.array(found).T
    assert np.ptp(heights_m) > 2.0 * (3 - 1) + 1.5, "the layers rise and sink"
    assert above_m.min() >= FLOOR_M - 1.0
