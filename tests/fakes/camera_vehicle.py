"""A vehicle whose camera component answers, and a web server for its images."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.files.fetching import ImageLimits
from aos_drivers.frames.files.images import Image
from aos_gcs.geometry.poses import mavlink_quaternion_from_R_cam2enu, nadir_pose
from tests.fakes.mavlink_fleet import Network
from tests.fakes.mavlink_vehicle import FakeVehicle

START = mavlink.MAV_CMD_IMAGE_START_CAPTURE
REQUEST = mavlink.MAV_CMD_REQUEST_MESSAGE
DOWN = tuple(mavlink_quaternion_from_R_cam2enu(nadir_pose([0, 0, 0]).R_cam2enu))
URL = "http://10.0.0.1/7.tiff"


@dataclass
class RecordedFetcher:
    """Delivers one image and notes what it was asked for."""

    asked: list[tuple[str, str]] = field(default_factory=list)
    limits: ImageLimits = field(default_factory=ImageLimits)

    async def fetch(self, url: str, host: str, _deadline_s: float) -> tuple[Image, tuple[str, ...]]:
        self.asked.append((url, host))
        return np.zeros((24, 32, 1), np.uint8), ("grey",)


class CameraVehicle(FakeVehicle):
    """A vehicle whose camera answers; ``lost`` messages about images do not arrive the first time."""

    def __init__(self) -> None:
        super().__init__(1)
        self.image_index = 7
        self.lost = 0
        self.result = mavlink.MAV_RESULT_ACCEPTED
        self.position_e7 = (480000000, 140000000)
        self.q: tuple[float, ...] = DOWN
        self.capture_result = 1
        self.focal_mm = 6.4
        self.seen_sequences: set[float] = set()

    def captured(self, index: int) -> bytes:
        return self.camera.pack(
            mavlink.MAVLink_camera_image_captured_message(
                0,
                1_700_000_000_500_000,
                0,
                *self.position_e7,
                335_000,
                35_000,
                [*self.q],
                index,
                self.capture_result,
                URL.encode(),
            )
        )

    def _on_command(self, message: mavlink.MAVLink_message) -> bytes:
        if message.target_component != 100:
            return super()._on_command(message)
        self.commands.append(message)
        if message.command == START:
            return self._on_capture(message)
        wanted = int(message.param1)
        if wanted == mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION:
            names = [0] * 32
            return self.camera.pack(
                mavlink.MAVLink_camera_information_message(
                    0, names, names, 0, self.focal_mm, 6.4, 4.8, 640, 480, 0, 2, 0, b""
                )
            )
        if wanted == mavlink.MAVLINK_MSG_ID_CAMERA_CAPTURE_STATUS:
            return self.camera.pack(
                mavlink.MAVLink_camera_capture_status_message(0, 0, 0, 0.0, 0, 0.0, self.image_index)
            )
        return self.captured(int(message.param2)) if int(message.param2) < self.image_index else b""

    def _on_capture(self, message: mavlink.MAVLink_message) -> bytes:
        ack = self.camera.pack(mavlink.MAVLink_command_ack_message(START, self.result, 0, 0, 254, 190))
        if self.result != mavlink.MAV_RESULT_ACCEPTED or message.param4 in self.seen_sequences:
            return ack
        self.seen_sequences.add(message.param4)
        self.image_index += 1
        if self.lost:
            self.lost -= 1
            return ack
        return ack + self.captured(self.image_index - 1)


async def settle(network: Network) -> None:
    await network.clock.sleep(0.5)
