"""Cameras that the autopilot triggers: it reports each exposure, and the file goes another way.

Like the camera component's, they hang in a stabilised gimbal that looks straight down, follows the heading and reports
nothing. The autopilot tells its own position and, on ArduPilot, the attitude of its body.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_sim.camera.component import MAX_PENDING, CameraView, Exposure
from aos_sim.clock import SimTime
from aos_sim.vehicle.autopilot import SimulatedAutopilot
from aos_sim.vehicle.commands import CommandRequest
from aos_sim.vehicle.telemetry import body_quaternion, degrees_e7


class ShutterCamera(ABC):
    """A camera on an output of the autopilot, which answers for it.

    Take the exposures to be developed from :meth:`take_exposures` and report each with :meth:`image_ready`.
    """

    COMPONENT_ID: ClassVar[int] = int(mavlink.MAV_COMP_ID_AUTOPILOT1)
    COMMANDS: ClassVar[frozenset[int]]
    """Commands that trigger this autopilot."""

    def __init__(self, autopilot: SimulatedAutopilot) -> None:
        self._autopilot = autopilot
        self._now = SimTime(0)
        self._exposures: list[Exposure] = []
        self._pending = 0
        self._next_index = 0

    @property
    def image_count(self) -> int:
        """Images that were delivered."""
        return self._next_index - self._pending

    @abstractmethod
    def report(self, exposure: Exposure) -> mavlink.MAVLink_message:
        """Return what the autopilot says of an exposure, at its time."""

    @abstractmethod
    def is_shot(self, request: CommandRequest) -> bool:
        """Return whether a command of ``COMMANDS`` asks for an image."""

    def answers(self, message: mavlink.MAVLink_message) -> bool:
        """Whether a message is for the camera."""
        is_command = message.get_type() in ("COMMAND_LONG", "COMMAND_INT")
        return is_command and message.target_component in (0, self.COMPONENT_ID) and message.command in self.COMMANDS

    def handle(self, message: mavlink.MAVLink_message, now: SimTime) -> None:
        """Take in a command."""
        self._now = now
        request = CommandRequest.of(message)
        if self._pending >= MAX_PENDING:
            self._autopilot.acknowledge(request, mavlink.MAV_RESULT_TEMPORARILY_REJECTED)
            return
        self._autopilot.acknowledge(request, mavlink.MAV_RESULT_ACCEPTED)
        if self.is_shot(request):
            exposure = Exposure(self._autopilot.identity.system_id, self._next_index, now)
            self._next_index += 1
            self._pending += 1
            self._exposures.append(exposure)
            self._autopilot.send(self.report(exposure))

    def update(self, now: SimTime) -> None:
        """Advance to ``now``."""
        self._now = now

    def drain(self) -> list[mavlink.MAVLink_message]:
        """Return nothing: the autopilot speaks for the camera."""
        return []

    def take_exposures(self) -> list[Exposure]:
        """Return the exposures made since the last call."""
        exposures, self._exposures = self._exposures, []
        return exposures

    def image_ready(self, exposure: Exposure, view: CameraView, file_url: str) -> None:
        """Count an image that was written; nobody is told where."""
        del exposure, view, file_url
        self._pending -= 1


class ArduPilotShutter(ShutterCamera):
    """CAMERA_FEEDBACK as ArduPilot sends it without a feedback pin: time of the GPS, attitude of the body."""

    COMMANDS = frozenset({mavlink.MAV_CMD_IMAGE_START_CAPTURE, mavlink.MAV_CMD_DO_DIGICAM_CONTROL})

    def is_shot(self, request: CommandRequest) -> bool:
        """See the base class."""
        is_digicam = request.command == mavlink.MAV_CMD_DO_DIGICAM_CONTROL
        return not is_digicam or request.param(5) == 1.0

    def report(self, exposure: Exposure) -> mavlink.MAVLink_message:
        """See the base class."""
        kinematics, position = self._autopilot.kinematics, self._autopilot.kinematics.geodetic
        return mavlink.MAVLink_camera_feedback_message(
            time_usec=exposure.at.utc_us,
            target_system=0,
            cam_idx=0,
            img_idx=exposure.index,
            lat=degrees_e7(position.latitude_deg),
            lng=degrees_e7(position.longitude_deg),
            alt_msl=position.altitude_amsl_m,
            alt_rel=kinematics.position_enu_m[2] - self._autopilot.flight.home_enu_m[2],
            roll=math.degrees(kinematics.roll_rad),
            pitch=math.degrees(kinematics.pitch_rad),
            yaw=math.degrees(kinematics.heading_rad),
            foc_len=0.0,
            flags=mavlink.CAMERA_FEEDBACK_PHOTO,
            completed_captures=exposure.index + 1,
        )


class Px4Shutter(ShutterCamera):
    """CAMERA_IMAGE_CAPTURED as PX4 sends it: no URL, no time of day before a fix, and the attitude of the body."""

    COMMANDS = frozenset({mavlink.MAV_CMD_DO_DIGICAM_CONTROL})

    def is_shot(self, request: CommandRequest) -> bool:
        """See the base class."""
        return request.param(5) == 1.0

    def report(self, exposure: Exposure) -> mavlink.MAVLink_message:
        """See the base class."""
        kinematics, position = self._autopilot.kinematics, self._autopilot.kinematics.geodetic
        return mavlink.MAVLink_camera_image_captured_message(
            time_boot_ms=exposure.at.boot_ms,
            time_utc=0,
            camera_id=1,
            lat=degrees_e7(position.latitude_deg),
            lon=degrees_e7(position.longitude_deg),
            alt=round(position.altitude_amsl_m * 1e3),
            relative_alt=-1000,
            q=list(body_quaternion(kinematics.roll_rad, kinematics.pitch_rad, kinematics.heading_rad)),
            image_index=exposure.index,
            capture_result=1,
            file_url=b"",
        )
