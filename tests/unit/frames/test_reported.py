"""Frames whose exposures the autopilot reports, with files in a folder, in virtual time."""

from __future__ import annotations

import asyncio
import contextlib
import math
import os
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.errors import FrameRefusedError, LateFrameError, TornFrameError
from aos_drivers.frames.files.fetching import Download
from aos_drivers.frames.poses.mount import CameraMount, Carrier
from aos_drivers.frames.settings import CameraSettings, ImagePlace, SourceKind
from aos_gcs.cameras.calibration import Calibration
from aos_gcs.cameras.intrinsics import Intrinsics
from aos_gcs.errors import CaptureError
from aos_gcs.geometry.poses import nadir_pose
from tests.fakes.mavlink_vehicle import HOME
from tests.fakes.shutter_vehicle import (
    PITCH_DEG,
    YAW_DEG,
    NoDownloads,
    ShutterVehicle,
    deadline_s,
    open_camera,
    picture,
)

pytestmark = pytest.mark.looptime

FOV_RAD = 0.9


def in_folder(folder: Path, **changes: object) -> CameraSettings:
    place = ImagePlace(folder=str(folder), file_name=changes.pop("file_name", None))  # type: ignore[arg-type]
    settings = {"source": SourceKind.REPORTED, "place": place, "fov_rad": FOV_RAD} | changes
    return CameraSettings(**settings)  # type: ignore[arg-type]


@pytest.mark.parametrize("autopilot", [mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, mavlink.MAV_AUTOPILOT_PX4])
async def test_a_file_in_the_folder_and_the_report_become_one_frame(tmp_path: Path, autopilot: int) -> None:
    (tmp_path / "00042.png").write_bytes(picture(1))  # of another flight
    vehicle = ShutterVehicle(lambda shot: (tmp_path / f"{shot:05d}.png").write_bytes(picture(shot)), autopilot)
    vehicle.height_m = 30.0
    async with open_camera(vehicle, in_folder(tmp_path, file_name="{index:05d}.png")) as network:
        capture = await network.vehicle().capture(deadline_s(network))
        state = network.vehicle().state.camera
    assert (capture.image_index, capture.bands, capture.image[0, 0, 0]) == (42, ("grey",), 42)
    assert capture.position.altitude_amsl_m == pytest.approx(HOME.altitude_amsl_m + 30.0, abs=1e-3)
    assert capture.camera.horizontal_fov_rad == pytest.approx(FOV_RAD)
    # The body is pitched up by 5 degrees and heads east: what looks down in it looks 5 degrees to the east.
    tilt = math.radians(PITCH_DEG)
    assert capture.R_cam2enu[:, 2] == pytest.approx([math.sin(tilt), 0.0, -math.cos(tilt)], abs=1e-6)
    assert capture.time_sigma_s is not None
    assert capture.time_sigma_s < 0.05
    assert state is not None
    assert (state.source, state.frames, state.refused) == ("reported", 1, 0)


async def test_a_calibration_turns_the_camera_and_shifts_its_clock(tmp_path: Path) -> None:
    intrinsics = Intrinsics(40.0, 41.0, 15.0, 12.0, (32, 24))
    calibration = Calibration(intrinsics, (0.0, math.radians(2.0), 0.0), -0.05)
    vehicle = ShutterVehicle(lambda shot: (tmp_path / f"{shot:05d}.png").write_bytes(picture(shot)))
    vehicle.height_m = 30.0
    vehicle.velocity_ned_cmps = (0, 0, -500)
    settings = in_folder(tmp_path, file_name="{index:05d}.png", fov_rad=None, calibration=calibration)
    async with open_camera(vehicle, settings) as network:
        capture = await network.vehicle().capture(deadline_s(network))
    assert (capture.camera.fx_px, capture.camera.fy_px, capture.camera.cx_px) == (40.0, 41.0, 15.0)
    # Two degrees up from straight down in the body, whose nose is 5 degrees up.
    tilt = math.radians(PITCH_DEG + 2.0)
    assert capture.R_cam2enu[:, 2] == pytest.approx([math.sin(tilt), 0.0, -math.cos(tilt)], abs=1e-6)
    # Positions stay, velocities say 5 m/s: what lies between two reports is not exactly on either.
    assert capture.position.altitude_amsl_m != pytest.approx(HOME.altitude_amsl_m + 30.0, abs=0.01)


async def test_a_level_mount_takes_the_heading_alone(tmp_path: Path) -> None:
    vehicle = ShutterVehicle(lambda _: (tmp_path / "DSC7.PNG").write_bytes(picture(3)))
    async with open_camera(vehicle, in_folder(tmp_path, mount=CameraMount(Carrier.LEVEL))) as network:
        capture = await network.vehicle().capture(deadline_s(network))
    expected = nadir_pose([0, 0, 0], math.radians(YAW_DEG)).R_cam2enu
    assert capture.R_cam2enu == pytest.approx(expected, abs=1e-6)


async def test_a_gimbal_without_reports_is_refused_and_counted(tmp_path: Path) -> None:
    vehicle = ShutterVehicle(lambda _: (tmp_path / "a.png").write_bytes(picture(3)))
    settings = in_folder(tmp_path, mount=CameraMount(Carrier.GIMBAL), max_pose_age_s=0.2)
    async with open_camera(vehicle, settings) as network:
        with pytest.raises(FrameRefusedError, match=r"image 42 from vehicle 1: .*no gimbal attitude"):
            await network.vehicle().capture(deadline_s(network))
        state = network.vehicle().state.camera
        notices = [notice.text for notice in network.notices if "gimbal" in notice.text]
    assert state is not None
    assert (state.frames, state.refused) == (0, 1)
    assert "gimbal" in state.problem
    assert len(notices) == 1


async def test_a_half_written_file_is_never_read(tmp_path: Path) -> None:
    data, path = picture(9), tmp_path / "00042.png"

    def write_slowly(_shot: int) -> None:
        path.write_bytes(data[: len(data) // 2])
        loop = asyncio.get_running_loop()
        loop.call_later(0.6, lambda: path.write_bytes(data))

    async with open_camera(ShutterVehicle(write_slowly), in_folder(tmp_path, file_name="{index:05d}.png")) as network:
        assert (await network.vehicle().capture(deadline_s(network))).image[0, 0, 0] == 9


async def test_the_late_file_of_an_exposure_is_not_taken_for_that_of_the_next(tmp_path: Path) -> None:
    def write(shot: int) -> None:
        path = tmp_path / f"{shot}.png"
        path.write_bytes(picture(shot))
        os.utime(path, (shot, shot))

    def write_late(shot: int) -> None:
        asyncio.get_running_loop().call_later(1.5 if shot == 42 else 0.9, write, shot)

    async with open_camera(ShutterVehicle(write_late), in_folder(tmp_path)) as network:
        with pytest.raises(LateFrameError, match="did not appear"):
            await network.vehicle().capture(deadline_s(network, 1.0))
        assert (await network.vehicle().capture(deadline_s(network))).image[0, 0, 0] == 43
        await network.clock.sleep(1.0)
        assert (await network.vehicle().capture(deadline_s(network))).image[0, 0, 0] == 44


async def test_a_file_that_never_comes_costs_the_frames_of_some_seconds(tmp_path: Path) -> None:
    def write(shot: int) -> None:
        if shot > 42:
            (tmp_path / f"{shot}.png").write_bytes(picture(shot))

    shades = []
    async with open_camera(ShutterVehicle(write), in_folder(tmp_path)) as network:
        for _ in range(8):
            with contextlib.suppress(LateFrameError):
                shades.append(int((await network.vehicle().capture(deadline_s(network, 2.5))).image[0, 0, 0]))
    assert shades == [48, 49]


async def test_torn_late_and_absurd_frames_are_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "00042.png"
    vehicle = ShutterVehicle(lambda _: path.write_bytes(picture(1)[:40]))
    async with open_camera(vehicle, in_folder(tmp_path, file_name="{index:05d}.png")) as network:
        with pytest.raises(TornFrameError, match="incomplete"):
            await network.vehicle().capture(deadline_s(network, 0.8))
        with pytest.raises(LateFrameError, match="image 43 from vehicle 1: its file did not appear"):
            await network.vehicle().capture(deadline_s(network, 0.5))
        vehicle.offset_m = 900.0
        vehicle.on_exposure = lambda shot: (tmp_path / f"{shot:05d}.png").write_bytes(picture(1)) and None
        with pytest.raises(FrameRefusedError, match="900 m from where the vehicle was"):
            await network.vehicle().capture(deadline_s(network))
        state = network.vehicle().state.camera
    assert state is not None
    assert (state.torn, state.late, state.refused, state.failed) == (1, 1, 1, 0)


async def test_links_and_pipes_in_the_folder_are_not_followed(tmp_path: Path) -> None:
    folder, secret = tmp_path / "images", tmp_path / "secret.png"
    folder.mkdir()
    secret.write_bytes(picture(1))

    def plant(_shot: int) -> None:
        (folder / "00042.png").symlink_to(secret)
        os.mkfifo(folder / "00043.png")

    async with open_camera(ShutterVehicle(plant), in_folder(folder)) as network:
        with pytest.raises(LateFrameError):
            await network.vehicle().capture(deadline_s(network, 0.6))


async def test_a_folder_that_is_not_there_is_named(tmp_path: Path) -> None:
    async with open_camera(ShutterVehicle(lambda _: None), in_folder(tmp_path / "nowhere")) as network:
        with pytest.raises(CaptureError, match="nowhere cannot be read: No such file"):
            await network.vehicle().capture(deadline_s(network))


async def test_a_camera_that_fires_by_itself_is_waited_for(tmp_path: Path) -> None:
    vehicle = ShutterVehicle(lambda _: None)
    async with open_camera(vehicle, in_folder(tmp_path, is_triggered=False)) as network:
        waiting = asyncio.create_task(network.vehicle().capture(deadline_s(network)))
        await network.clock.sleep(0.3)
        (tmp_path / "a.png").write_bytes(picture(5))
        network.deliver(vehicle.report(), next(iter(network.vehicles)))
        assert (await waiting).image_index == 41
        with pytest.raises(LateFrameError, match="no exposure was reported"):
            await network.vehicle().capture(deadline_s(network, 0.2))
    assert not vehicle.sent(mavlink.MAV_CMD_IMAGE_START_CAPTURE)


async def test_a_lost_report_is_asked_for_again(tmp_path: Path) -> None:
    vehicle = ShutterVehicle(lambda shot: (tmp_path / f"{shot}.png").write_bytes(picture(shot)) and None)
    async with open_camera(vehicle, in_folder(tmp_path, file_name="{index}.png")) as network:
        vehicle.lost_reports = 1
        assert (await network.vehicle().capture(deadline_s(network))).image_index == 42
    assert len(vehicle.sent(mavlink.MAV_CMD_IMAGE_START_CAPTURE)) == 1


async def test_the_second_image_of_a_repeated_command_serves_the_next_frame(tmp_path: Path) -> None:
    """The second image was exposed after the telemetry with which the next frame is asked for."""
    vehicle = ShutterVehicle(lambda shot: (tmp_path / f"{shot}.png").write_bytes(picture(shot)) and None)
    async with open_camera(vehicle, in_folder(tmp_path, file_name="{index}.png")) as network:
        await network.clock.sleep(0.3)
        assert (await network.vehicle().capture(deadline_s(network))).image_index == 42
        vehicle.shot += 1
        vehicle.on_exposure(vehicle.shot)
        vehicle.is_deaf = True
        await network.clock.sleep(0.3)
        second = asyncio.create_task(network.vehicle().capture(deadline_s(network)))
        await network.clock.sleep(0.02)
        vehicle.boot_ms += 50
        network.deliver(vehicle.report(), next(iter(network.vehicles)))
        assert (await second).image[0, 0, 0] == 43


async def test_a_report_from_before_the_command_is_that_of_another_exposure(tmp_path: Path) -> None:
    vehicle = ShutterVehicle(lambda shot: (tmp_path / f"{shot}.png").write_bytes(picture(shot)) and None)
    async with open_camera(vehicle, in_folder(tmp_path, file_name="{index}.png")) as network:
        await network.clock.sleep(0.3)
        earlier = vehicle.report()
        vehicle.shot += 1
        await network.clock.sleep(0.7)
        capturing = asyncio.create_task(network.vehicle().capture(deadline_s(network)))
        await network.clock.sleep(0.01)
        network.deliver(earlier, next(iter(network.vehicles)))
        assert (await capturing).image_index == 43


async def test_motion_is_asked_for_at_the_rate_that_poses_need(tmp_path: Path) -> None:
    vehicle = ShutterVehicle(lambda _: None)
    async with open_camera(vehicle, in_folder(tmp_path, pose_hz=20.0)) as network:
        await network.clock.sleep(0.8)
    intervals = {int(message.param1): message.param2 for message in vehicle.sent(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL)}
    for message_id in (mavlink.MAVLINK_MSG_ID_ATTITUDE, mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT):
        assert intervals[message_id] == 50_000.0


async def test_an_old_file_of_the_same_index_is_not_taken() -> None:
    class OldFile(NoDownloads):
        async def download(self, _url: str, _host: str, _deadline_s: float) -> Download:
            return Download(picture(7), age_s=3600.0)

    settings = CameraSettings(SourceKind.REPORTED, ImagePlace(url="http://companion/{index}.png"), fov_rad=FOV_RAD)
    async with open_camera(ShutterVehicle(lambda _: None), settings, OldFile()) as network:
        with pytest.raises(LateFrameError, match=r"s old: that of another flight"):
            await network.vehicle().capture(deadline_s(network))
