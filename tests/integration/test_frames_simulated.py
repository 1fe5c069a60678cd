"""Both drivers take frames of simulated vehicles whose autopilots trigger the cameras."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.ports import Clock, DriverContext, Fleet
from aos_gcs.runtime.drivers import load_driver
from aos_sim.camera.synthetic import CheckerboardGround
from aos_sim.swarm import SimulatedSwarm, SwarmOptions
from tests.fakes.air import Air
from tests.fakes.air_flight import simulated
from tests.fakes.program import unused_port
from tests.fakes.sim_errors import POSITIONS_ERR

SPEED = 4.0


def context_of(clock: Clock, folder: Path) -> DriverContext:
    camera = {
        "source": "reported",
        "folder": str(folder / "{vehicle_id}"),
        "file_name": "{index:05d}.tiff",
        "carrier": "level",
        "fov_deg": 50,
    }
    return DriverContext(clock, lambda: True, lambda _: None, options={"camera": camera})


async def check_frames(fleet: Fleet, swarm: SimulatedSwarm, clock: Clock) -> None:
    async with clock.timeout_at(clock.now_s() + 200.0):
        while len(fleet.vehicles()) < 2 or not all(vehicle.state.ready_to_arm for vehicle in fleet.vehicles().values()):
            await clock.sleep(0.5)
    deadline_s = clock.now_s() + 100.0
    captures = await asyncio.gather(*[fleet.vehicles()[number].capture(deadline_s) for number in (1, 2)])
    again = await fleet.vehicles()[1].capture(deadline_s)
    states = [fleet.vehicles()[number].state.camera for number in (1, 2)]
    size_px = swarm.options.image_size_px
    for number, capture in enumerate(captures, 1):
        truth = swarm.kinematics(number)
        assert (capture.vehicle_id, capture.image_index, capture.image.shape) == (number, 0, (size_px, size_px, 4))
        assert math.dist(swarm.frame.to_enu(capture.position), truth.position_enu_m) < 1.0
        assert capture.R_cam2enu == pytest.approx(nadir_pose([0, 0, 0], truth.heading_rad).R_cam2enu, abs=0.02)
    assert again.image_index >= 1  # more, where a busy machine has had a command repeated
    assert [(state.source, state.frames) for state in states if state is not None] == [("reported", 2), ("reported", 1)]


@pytest.mark.looptime
@pytest.mark.parametrize("autopilot", ["arducopter", "px4"])
async def test_reported_frames_have_the_true_poses(
    autopilot: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = LoopClock()
    context = context_of(clock, tmp_path)
    options = {"vehicles": 2, "autopilot": autopilot, "image_folder": tmp_path}
    async with simulated(monkeypatch, Air(), context, {}, **options) as (fleet, swarm):
        await check_frames(fleet, swarm, clock)


@pytest.mark.slow
@pytest.mark.parametrize("autopilot", ["arducopter", "px4"])
async def test_mavsdk_takes_them_too(autopilot: str, tmp_path: Path) -> None:
    pytest.importorskip("mavsdk", reason="needs the optional library mavsdk")
    port = unused_port()
    options = SwarmOptions(
        vehicles=2,
        links=(f"udpout://127.0.0.1:{port}",),
        speed=SPEED,
        autopilot=autopilot,
        image_size_px=64,
        start_up_s=2.0,
        image_folder=tmp_path,
        errors=POSITIONS_ERR,
    )
    clock = LoopClock(SPEED)
    async with (
        load_driver("mavsdk")([f"udpin://127.0.0.1:{port}"], context_of(clock, tmp_path)) as fleet,
        SimulatedSwarm(options, CheckerboardGround()) as swarm,
    ):
        await check_frames(fleet, swarm, clock)
