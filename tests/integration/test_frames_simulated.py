"""Both drivers take frames of simulated vehicles whose autopilots trigger the cameras."""

from __future__ import annotations

import asyncio
import math
import socket
from pathlib import Path

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.ports import DriverContext
from aos_gcs.runtime.drivers import load_driver
from aos_sim.camera.synthetic import CheckerboardGround
from aos_sim.swarm import SimulatedSwarm, SwarmOptions

SPEED = 4.0
SIZE_PX = 64


@pytest.mark.parametrize(
    ("driver_name", "autopilot"),
    [
        ("mavlink", "arducopter"),
        pytest.param("mavsdk", "px4", marks=pytest.mark.slow),
        pytest.param("mavlink", "px4", marks=pytest.mark.slow),
        pytest.param("mavsdk", "arducopter", marks=pytest.mark.slow),
    ],
)
async def test_reported_frames_have_the_true_poses(driver_name: str, autopilot: str, tmp_path: Path) -> None:
    if driver_name == "mavsdk":
        pytest.importorskip("mavsdk", reason="needs the optional library mavsdk")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    options = SwarmOptions(
        vehicles=2,
        links=(f"udpout://127.0.0.1:{port}",),
        speed=SPEED,
        autopilot=autopilot,
        image_size_px=SIZE_PX,
        start_up_s=2.0,
        image_folder=tmp_path,
    )
    camera = {
        "source": "reported",
        "folder": str(tmp_path / "{vehicle_id}"),
        "file_name": "{index:05d}.tiff",
        "carrier": "level",
        "fov_deg": 50,
    }
    clock = LoopClock(SPEED)
    context = DriverContext(clock, lambda: True, lambda _: None, options={"camera": camera})
    async with (
        load_driver(driver_name)([f"udpin://127.0.0.1:{port}"], context) as fleet,
        SimulatedSwarm(options, CheckerboardGround()) as swarm,
    ):
        async with clock.timeout_at(clock.now_s() + 200.0):
            while len(fleet.vehicles()) < 2 or not all(
                vehicle.state.ready_to_arm for vehicle in fleet.vehicles().values()
            ):
                await clock.sleep(0.5)
        deadline_s = clock.now_s() + 100.0
        captures = await asyncio.gather(*[fleet.vehicles()[number].capture(deadline_s) for number in (1, 2)])
        again = await fleet.vehicles()[1].capture(deadline_s)
        states = [fleet.vehicles()[number].state.camera for number in (1, 2)]
    for number, capture in enumerate(captures, 1):
        truth = swarm.kinematics(number)
        assert (capture.vehicle_id, capture.image_index, capture.image.shape) == (number, 0, (SIZE_PX, SIZE_PX, 4))
        assert math.dist(swarm.frame.to_enu(capture.position), truth.position_enu_m) < 1.0
        assert capture.R_cam2enu == pytest.approx(nadir_pose([0, 0, 0], truth.heading_rad).R_cam2enu, abs=0.02)
    assert again.image_index >= 1  # more, where a busy machine has had a command repeated
    assert [(state.source, state.frames) for state in states if state is not None] == [("reported", 2), ("reported", 1)]
