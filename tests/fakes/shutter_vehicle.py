"""A vehicle in memory whose autopilot triggers a camera of its own."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

import cv2
import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.files.fetching import ImageFetcher, ImageLimits
from aos_drivers.frames.settings import CameraPlan, CameraSettings
from aos_gcs.ports import Worker
from tests.fakes.mavlink_fleet import Network, open_network
from tests.fakes.mavlink_vehicle import HOME, FakeVehicle
from tests.fakes.mission_flight import InlineExecutor

LIMITS = ImageLimits(2**20, 10_000)
YAW_DEG, PITCH_DEG = 90.0, 5.0


def picture(shade: int) -> bytes:
    return bytes(cv2.imencode(".png", np.full((24, 32), shade, np.uint8))[1])


class ShutterVehicle(FakeVehicle):
    """Vehicle that triggers its own camera; ``on_exposure`` delivers the file, as a companion computer would."""

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
async def open_camera(
    vehicle: ShutterVehicle, settings: CameraSettings, fetcher: ImageFetcher | None = None
) -> AsyncIterator[Network]:
    """Join the vehicle with a running driver; files are read inline where nothing has to be fetched."""
    if fetcher is None:
        asyncio.get_running_loop().set_default_executor(InlineExecutor(1))
    async with open_network(vehicle, fetcher=fetcher or NoDownloads(), cameras=CameraPlan(settings)) as network:
        yield network


class NoDownloads(ImageFetcher):
    """Limits and decoder of a driver that never fetches."""

    def __init__(self, limits: ImageLimits = LIMITS, decoding: Worker | None = None) -> None:
        super().__init__(None, None, limits, (), decoding)  # type: ignore[arg-type]


def deadline_s(network: Network, seconds: float = 4.0) -> float:
    """Return the clock time in so many seconds."""
    return network.clock.now_s() + seconds
