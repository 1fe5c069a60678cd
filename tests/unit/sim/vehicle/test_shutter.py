"""Cameras that the simulated autopilots trigger and report."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_sim.camera.component import MAX_PENDING
from aos_sim.camera.folder import ImageFolder
from aos_sim.clock import SimTime
from aos_sim.packets import Parser
from aos_sim.swarm import AUTOPILOTS, SHUTTERS, SwarmOptions
from aos_sim.vehicle.configuration import VehicleIdentity
from aos_sim.vehicle.dynamics import SwarmState
from aos_sim.vehicle.kinematics import read_kinematics
from aos_sim.vehicle.vehicle import SimulatedVehicle

FRAME = LocalFrame(GeodeticPosition(48.3, 14.3, 260.0))
NOW = SimTime(500, start_utc_us=1_700_000_000_000_000)
START, DIGICAM = mavlink.MAV_CMD_IMAGE_START_CAPTURE, mavlink.MAV_CMD_DO_DIGICAM_CONTROL


class Bench:
    def __init__(self, flavour: str) -> None:
        state = SwarmState.at_rest(np.array([[3.0, 4.0, 20.0]]), np.array([0.7]))
        self.kinematics = read_kinematics(state, FRAME)[0]
        identity = VehicleIdentity(7, FRAME, uid=1, start_up_s=0.0, parameters={})
        autopilot = AUTOPILOTS[flavour](identity, self.kinematics)
        self.camera = SHUTTERS[flavour](autopilot)
        self.vehicle = SimulatedVehicle(autopilot, self.camera)
        self._parser = Parser()
        self._codec = mavlink.MAVLink(None, 254, 190)

    def command(self, command: int, param1: float = 0.0, param3: float = 0.0, param5: float = 0.0) -> list:
        packet = mavlink.MAVLink_command_long_message(7, 1, command, 0, param1, 0, param3, 0, param5, 0, 0)
        for message in Parser().feed(packet.pack(self._codec)):
            self.vehicle.handle(message, self.kinematics, NOW)
        return list(self._parser.feed(self.vehicle.drain()))


def names(messages: list) -> list[str]:
    return [message.get_type() for message in messages]


def test_arducopter_gives_the_bodys_attitude_and_the_time_of_the_gps() -> None:
    answers = Bench("arducopter").command(START, param3=1.0)
    assert names(answers) == ["COMMAND_ACK", "CAMERA_FEEDBACK"]
    feedback = answers[1]
    assert (feedback.get_srcComponent(), feedback.img_idx, feedback.time_usec) == (1, 0, NOW.utc_us)
    assert feedback.yaw == pytest.approx(math.degrees(0.7), abs=1e-4)
    place = GeodeticPosition(feedback.lat / 1e7, feedback.lng / 1e7, feedback.alt_msl)
    assert FRAME.to_enu(place) == pytest.approx([3.0, 4.0, 20.0], abs=0.02)


def test_px4_gives_no_url_and_knows_the_older_command_alone() -> None:
    bench = Bench("px4")
    assert "CAMERA_IMAGE_CAPTURED" not in names(bench.command(START, param3=1.0))
    answers = bench.command(DIGICAM, param5=1.0)
    captured = next(message for message in answers if message.get_type() == "CAMERA_IMAGE_CAPTURED")
    assert (captured.image_index, captured.file_url, captured.time_boot_ms) == (0, "", NOW.boot_ms)
    assert names(bench.command(DIGICAM, param5=0.0)) == ["COMMAND_ACK"]


def test_a_camera_with_images_to_develop_is_busy_until_they_are() -> None:
    bench = Bench("arducopter")
    for _ in range(MAX_PENDING):
        bench.command(START)
    (busy,) = bench.command(START)
    assert busy.result == mavlink.MAV_RESULT_TEMPORARILY_REJECTED
    for exposure in bench.camera.take_exposures():
        bench.camera.image_ready(exposure, bench.vehicle.view(), "")
    assert bench.camera.image_count == MAX_PENDING
    assert names(bench.command(START)) == ["COMMAND_ACK", "CAMERA_FEEDBACK"]


def test_files_appear_whole_and_replace_those_of_another_flight(tmp_path: Path) -> None:
    folder = ImageFolder(tmp_path / "images", [7])
    asyncio.run(folder.__aenter__())
    for data in (b"old", b"new"):
        path = Path(folder.publish(7, 12, data))
    assert path == tmp_path / "images" / "7" / "00012.tiff"
    assert path.read_bytes() == b"new"
    assert list(path.parent.iterdir()) == [path]


async def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(ConfigurationError, match="--image-folder"):
        async with ImageFolder(tmp_path / "file" / "images", [7]):
            pass
    with pytest.raises(ConfigurationError, match="--image-folder needs cameras"):
        SwarmOptions(cameras=False, image_folder=tmp_path)
