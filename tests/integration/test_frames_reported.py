"""Frames whose exposures the autopilot reports, with files in a folder or from a companion computer."""

from __future__ import annotations

import asyncio
import math
import os
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import aiohttp
import cv2
import numpy as np
import pytest
from aiohttp import web
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.errors import FrameRefusedError, LateFrameError, TornFrameError
from aos_drivers.frames.fetching import ImageFetcher, ImageLimits
from aos_drivers.frames.mount import CameraMount, Carrier
from aos_drivers.frames.settings import CameraPlan, CameraSettings, ImagePlace, SourceKind
from aos_gcs.clock import LoopClock
from aos_gcs.errors import CaptureError
from aos_gcs.geometry.poses import nadir_pose
from tests.fakes.mavlink_fleet import Network, open_network
from tests.fakes.mavlink_vehicle import HOME, FakeVehicle

FOV_RAD = 0.9
YAW_DEG, PITCH_DEG = 90.0, 5.0


def picture(shade: int) -> bytes:
    return bytes(cv2.imencode(".png", np.full((24, 32), shade, np.uint8))[1])


class ShutterVehicle(FakeVehicle):
    """A vehicle that triggers a camera of its own: ``on_exposure`` does with the file what a companion would."""

    def __init__(self, on_exposure: Callable[[int], None], autopilot: int = mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA):
        super().__init__(1, autopilot)
        self.on_exposure = on_exposure
        self.shot = 41
        self.offset_m = 0.0
        self.is_deaf = False
        self.lost_reports = 0
        self.velocity_ned_cmps = (0, 0, 0)

    def telemetry(self) -> bytes:
        self.boot_ms += 100  # and as much by the base class: the period of the network
        attitude = mavlink.MAVLink_attitude_message(
            self.boot_ms + 100, 0.0, math.radians(PITCH_DEG), math.radians(YAW_DEG), 0.0, 0.0, 0.0
        )
        return super().telemetry() + self.encoder.pack(attitude)

    def camera_heartbeat(self) -> bytes:
        return b""

    def report(self) -> bytes:
        place = (round(HOME.latitude_deg * 1e7), round(HOME.longitude_deg * 1e7))
        height_m = HOME.altitude_amsl_m + self.height_m + self.offset_m
        if self.autopilot == mavlink.MAV_AUTOPILOT_PX4:
            millimetres = round(height_m * 1000)
            message = mavlink.MAVLink_camera_image_captured_message(
                self.boot_ms, 0, 1, *place, millimetres, -1, [1.0, 0.0, 0.0, 0.0], self.shot, 1, b""
            )
        else:
            message = mavlink.MAVLink_camera_feedback_message(
                self.boot_ms * 1000, 0, 0, self.shot, *place, height_m, 0.0, 0.0, PITCH_DEG, YAW_DEG, 0.0, 1
            )
        return self.encoder.pack(message)

    def _on_command(self, message: mavlink.MAVLink_message) -> bytes:
        if self.is_deaf:
            return b""
        answer = super()._on_command(message)
        is_px4 = self.autopilot == mavlink.MAV_AUTOPILOT_PX4
        shutter = mavlink.MAV_CMD_DO_DIGICAM_CONTROL if is_px4 else mavlink.MAV_CMD_IMAGE_START_CAPTURE
        is_asked = message.command == mavlink.MAV_CMD_REQUEST_MESSAGE
        if is_asked and message.param1 == mavlink.MAVLINK_MSG_ID_CAMERA_FEEDBACK:
            return answer + self.report()
        if message.command != shutter or (is_px4 and message.param5 != 1.0):
            return answer
        self.shot += 1
        self.on_exposure(self.shot)
        if self.lost_reports:
            self.lost_reports -= 1
            return answer
        return answer + self.report()


@asynccontextmanager
async def bench(vehicle: ShutterVehicle, settings: CameraSettings) -> AsyncIterator[Network]:
    async with aiohttp.ClientSession() as session:
        fetcher = ImageFetcher(session, LoopClock(), ImageLimits(2**20, 10_000), ())
        async with open_network(vehicle, fetcher=fetcher, cameras=CameraPlan(settings)) as network:
            yield network


def in_folder(folder: Path, **changes: object) -> CameraSettings:
    place = ImagePlace(folder=str(folder), file_name=changes.pop("file_name", None))  # type: ignore[arg-type]
    settings = {"source": SourceKind.REPORTED, "place": place, "fov_rad": FOV_RAD} | changes
    return CameraSettings(**settings)  # type: ignore[arg-type]


def deadline_s(network: Network, seconds: float = 4.0) -> float:
    return network.clock.now_s() + seconds


@pytest.mark.parametrize("autopilot", [mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, mavlink.MAV_AUTOPILOT_PX4])
async def test_a_file_in_the_folder_and_the_report_become_one_frame(tmp_path: Path, autopilot: int) -> None:
    (tmp_path / "00042.png").write_bytes(picture(1))  # of another flight
    vehicle = ShutterVehicle(lambda shot: (tmp_path / f"{shot:05d}.png").write_bytes(picture(shot)), autopilot)
    vehicle.height_m = 30.0
    async with bench(vehicle, in_folder(tmp_path, file_name="{index:05d}.png")) as network:
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


async def test_a_level_mount_takes_the_heading_alone(tmp_path: Path) -> None:
    vehicle = ShutterVehicle(lambda _: (tmp_path / "DSC7.PNG").write_bytes(picture(3)))
    async with bench(vehicle, in_folder(tmp_path, mount=CameraMount(Carrier.LEVEL))) as network:
        capture = await network.vehicle().capture(deadline_s(network))
    expected = nadir_pose([0, 0, 0], math.radians(YAW_DEG)).R_cam2enu
    assert capture.R_cam2enu == pytest.approx(expected, abs=1e-6)


async def test_a_gimbal_without_reports_is_refused_and_counted(tmp_path: Path) -> None:
    vehicle = ShutterVehicle(lambda _: (tmp_path / "a.png").write_bytes(picture(3)))
    settings = in_folder(tmp_path, mount=CameraMount(Carrier.GIMBAL), max_pose_age_s=0.2)
    async with bench(vehicle, settings) as network:
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

    async with bench(ShutterVehicle(write_slowly), in_folder(tmp_path, file_name="{index:05d}.png")) as network:
        assert (await network.vehicle().capture(deadline_s(network))).image[0, 0, 0] == 9


async def test_torn_late_and_absurd_frames_are_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "00042.png"
    vehicle = ShutterVehicle(lambda _: path.write_bytes(picture(1)[:40]))
    async with bench(vehicle, in_folder(tmp_path, file_name="{index:05d}.png")) as network:
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

    async with bench(ShutterVehicle(plant), in_folder(folder)) as network:
        with pytest.raises(LateFrameError):
            await network.vehicle().capture(deadline_s(network, 0.6))


async def test_a_folder_that_is_not_there_is_named(tmp_path: Path) -> None:
    async with bench(ShutterVehicle(lambda _: None), in_folder(tmp_path / "nowhere")) as network:
        with pytest.raises(CaptureError, match="nowhere cannot be read: No such file"):
            await network.vehicle().capture(deadline_s(network))


async def test_a_camera_that_fires_by_itself_is_waited_for(tmp_path: Path) -> None:
    vehicle = ShutterVehicle(lambda _: None)
    async with bench(vehicle, in_folder(tmp_path, is_triggered=False)) as network:
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
    async with bench(vehicle, in_folder(tmp_path, file_name="{index}.png")) as network:
        vehicle.lost_reports = 1
        assert (await network.vehicle().capture(deadline_s(network))).image_index == 42
    assert len(vehicle.sent(mavlink.MAV_CMD_IMAGE_START_CAPTURE)) == 1


async def test_the_second_image_of_a_repeated_command_serves_the_next_frame(tmp_path: Path) -> None:
    """It was exposed after the telemetry that the next frame is asked for with."""
    vehicle = ShutterVehicle(lambda shot: (tmp_path / f"{shot}.png").write_bytes(picture(shot)) and None)
    async with bench(vehicle, in_folder(tmp_path, file_name="{index}.png")) as network:
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
    async with bench(vehicle, in_folder(tmp_path, file_name="{index}.png")) as network:
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
    async with bench(vehicle, in_folder(tmp_path, pose_hz=20.0)) as network:
        await network.clock.sleep(0.8)
    intervals = {int(message.param1): message.param2 for message in vehicle.sent(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL)}
    for message_id in (mavlink.MAVLINK_MSG_ID_ATTITUDE, mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT):
        assert intervals[message_id] == 50_000.0


# --- over HTTP -------------------------------------------------------------------------------------------------------


@asynccontextmanager
async def companion(files: dict[str, bytes], age_s: float = 0.0) -> AsyncIterator[str]:
    """Serve files by name, and their listing; yields the address."""

    async def answer(request: web.Request) -> web.Response:
        name = request.match_info["name"]
        if not name:
            links = "".join(f'<a href="{entry}">{entry}</a>' for entry in files)
            return web.Response(text=links, content_type="text/html")
        if name not in files:
            raise web.HTTPNotFound
        response = web.Response(body=files[name])
        response.last_modified = time.time() - age_s
        return response

    app = web.Application()
    app.router.add_get("/{name:.*}", answer)
    runner = web.AppRunner(app, shutdown_timeout=0.1)
    await runner.setup()
    await web.TCPSite(runner, "127.0.0.1", 0).start()
    try:
        yield f"http://127.0.0.1:{runner.addresses[0][1]}"
    finally:
        await runner.cleanup()


@pytest.mark.parametrize("path", ["/{index:05d}.png", "/"])
async def test_a_companion_serves_the_image_by_its_index_or_in_a_listing(path: str) -> None:
    files = {"00007.png": picture(7)}
    vehicle = ShutterVehicle(
        lambda shot: (
            asyncio.get_running_loop().call_later(0.3, files.__setitem__, f"{shot:05d}.png", picture(shot)) and None
        )
    )
    async with companion(files) as base:
        settings = CameraSettings(SourceKind.REPORTED, ImagePlace(url=base + path), fov_rad=FOV_RAD)
        async with bench(vehicle, settings) as network:
            capture = await network.vehicle().capture(deadline_s(network))
    assert (capture.image_index, capture.image[0, 0, 0]) == (42, 42)


async def test_an_old_file_of_the_same_index_is_not_taken() -> None:
    async with companion({"42.png": picture(7)}, age_s=3600.0) as base:
        settings = CameraSettings(SourceKind.REPORTED, ImagePlace(url=base + "/{index}.png"), fov_rad=FOV_RAD)
        async with bench(ShutterVehicle(lambda _: None), settings) as network:
            with pytest.raises(LateFrameError, match=r"s old: that of another flight"):
                await network.vehicle().capture(deadline_s(network, 0.5))
