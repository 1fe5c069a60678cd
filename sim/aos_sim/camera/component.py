"""The camera component of one vehicle, without I/O: commands in, exposures and messages out.

The camera hangs in a stabilised gimbal that looks straight down and follows the vehicle's heading.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AboveHomeM
from aos_gcs.geometry.poses import mavlink_quaternion_from_R_cam2enu, nadir_pose
from aos_sim.clock import TICK_US, SimTime
from aos_sim.vehicle.commands import CommandRequest
from aos_sim.vehicle.streams import StreamSchedule
from aos_sim.vehicle.telemetry import degrees_e7

SENSOR_WIDTH_MM = 6.4
FIRMWARE_VERSION = 0x01000000

MAX_PENDING = 4
"""Exposures that may wait to be developed; beyond, the camera is busy."""

INTERVAL_PENDING = 2
"""Exposures that may wait to be developed before an interval leaves one out: late images are of no use to a search."""

KEPT_CAPTURES = 1000
"""Captures whose CAMERA_IMAGE_CAPTURED can be asked for again."""

RETRANSMISSION_WINDOW_S = 5.0
"""A capture command with the sequence number of the one before, within this time, is the same one sent again."""

STORAGE_MIB = 32_000.0

IDLE, CAPTURING, INTERVAL_IDLE, INTERVAL_CAPTURING = 0, 1, 2, 3
"""CAMERA_CAPTURE_STATUS.image_status."""


@dataclass(frozen=True, slots=True)
class Exposure:
    """One press of the shutter."""

    system_id: int
    index: int
    """Counts the camera's images from 0."""
    at: SimTime


@dataclass(frozen=True, slots=True)
class CameraView:
    """Pose of the vehicle at an exposure, by its own estimate; the gimbal adds its attitude."""

    position: GeodeticPosition
    relative_altitude_m: AboveHomeM
    """Height above home."""
    heading_rad: float


@dataclass(slots=True)
class _Interval:
    """Captures still to come of an interval command."""

    command: tuple[int, int]
    """Ticks between two captures, and their number; 0: endless. A command that repeats it is the same one again."""
    next_tick: int
    remaining: float
    """Infinite when no number was given."""

    @property
    def period_ticks(self) -> int:
        """Ticks between two captures."""
        return self.command[0]


class CameraComponent:
    """MAVLink camera, component 100.

    Take the exposures to be developed from :meth:`take_exposures` and report each with :meth:`image_ready` or
    :meth:`image_failed`.
    """

    COMPONENT_ID = int(mavlink.MAV_COMP_ID_CAMERA)

    def __init__(self, system_id: int, camera: CameraModel) -> None:
        self._system_id = system_id
        self._camera = camera
        self._now = SimTime(0)
        self._outbox: list[mavlink.MAVLink_message] = []
        self._streams = StreamSchedule({mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1_000_000}, phase_ticks=system_id)
        self._exposures: list[Exposure] = []
        self._pending = 0
        self._next_index = 0
        self.failed_count = 0
        """Exposures without an image."""
        self._interval: _Interval | None = None
        self._captured: OrderedDict[int, mavlink.MAVLink_message] = OrderedDict()
        self._last_sequence: dict[tuple[int, int], tuple[int, float]] = {}
        self._builders: dict[int, Callable[[], mavlink.MAVLink_message]] = {
            mavlink.MAVLINK_MSG_ID_HEARTBEAT: self._heartbeat,
            mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION: self._camera_information,
            mavlink.MAVLINK_MSG_ID_CAMERA_SETTINGS: self._camera_settings,
            mavlink.MAVLINK_MSG_ID_STORAGE_INFORMATION: self._storage_information,
            mavlink.MAVLINK_MSG_ID_CAMERA_CAPTURE_STATUS: self._capture_status,
        }
        self._commands: dict[int, Callable[[CommandRequest], int]] = {
            mavlink.MAV_CMD_REQUEST_MESSAGE: self._request_message,
            mavlink.MAV_CMD_IMAGE_START_CAPTURE: self._start_capture,
            mavlink.MAV_CMD_IMAGE_STOP_CAPTURE: self._stop_capture,
            mavlink.MAV_CMD_SET_CAMERA_MODE: self._set_camera_mode,
            mavlink.MAV_CMD_REQUEST_CAMERA_INFORMATION: self._answer(mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION),
            mavlink.MAV_CMD_REQUEST_CAMERA_SETTINGS: self._answer(mavlink.MAVLINK_MSG_ID_CAMERA_SETTINGS),
            mavlink.MAV_CMD_REQUEST_STORAGE_INFORMATION: self._answer(mavlink.MAVLINK_MSG_ID_STORAGE_INFORMATION),
            mavlink.MAV_CMD_REQUEST_CAMERA_CAPTURE_STATUS: self._answer(mavlink.MAVLINK_MSG_ID_CAMERA_CAPTURE_STATUS),
        }

    @property
    def image_count(self) -> int:
        """Images that were delivered."""
        return self._next_index - self._pending - self.failed_count

    @property
    def takes_interval(self) -> bool:
        """Whether the camera takes images by itself."""
        return self._interval is not None

    def answers(self, message: mavlink.MAVLink_message) -> bool:
        """Whether a message is for the camera: sent to it, or sent to all components and a matter of cameras."""
        if message.get_type() not in ("COMMAND_LONG", "COMMAND_INT"):
            return False
        if message.target_component != 0:
            return bool(message.target_component == self.COMPONENT_ID)
        if message.command == mavlink.MAV_CMD_REQUEST_MESSAGE:
            asked = round(message.param1)
            camera_message = asked in self._builders and asked != mavlink.MAVLINK_MSG_ID_HEARTBEAT
            return bool(camera_message or asked == mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED)
        return bool(message.command in self._commands)

    def handle(self, message: mavlink.MAVLink_message, now: SimTime) -> None:
        """Take in a command."""
        self._now = now
        request = CommandRequest.of(message)
        command = self._commands.get(request.command)
        result = mavlink.MAV_RESULT_UNSUPPORTED if command is None else command(request)
        self._outbox.append(
            mavlink.MAVLink_command_ack_message(
                request.command, result, 0, 0, request.source_system, request.source_component
            )
        )

    def update(self, now: SimTime) -> None:
        """Advance to ``now``, at least one tick later than before."""
        self._now = now
        interval = self._interval
        if interval is not None and now.tick >= interval.next_tick and self._pending < INTERVAL_PENDING:
            self._expose()
            interval.next_tick = now.tick + interval.period_ticks
            interval.remaining -= 1
            if interval.remaining <= 0:
                self._interval = None
        for message_id in self._streams.due(now.tick):
            self._outbox.append(self._builders[message_id]())

    def drain(self) -> list[mavlink.MAVLink_message]:
        """Return the messages to be sent and forget them."""
        messages, self._outbox = self._outbox, []
        return messages

    def take_exposures(self) -> list[Exposure]:
        """Return the exposures made since the last call."""
        exposures, self._exposures = self._exposures, []
        return exposures

    def image_ready(self, exposure: Exposure, view: CameraView, file_url: str) -> None:
        """Announce that the image of an exposure can be fetched."""
        self._announce(
            mavlink.MAVLink_camera_image_captured_message(
                time_boot_ms=exposure.at.boot_ms,
                time_utc=exposure.at.utc_us,
                camera_id=0,
                lat=degrees_e7(view.position.latitude_deg),
                lon=degrees_e7(view.position.longitude_deg),
                alt=round(view.position.altitude_amsl_m * 1e3),
                relative_alt=round(view.relative_altitude_m * 1e3),
                q=_nadir_quaternion(view.heading_rad),
                image_index=exposure.index,
                capture_result=1,
                file_url=file_url.encode(),
            )
        )

    def image_failed(self, exposure: Exposure) -> None:
        """Announce that there is no image of an exposure."""
        self.failed_count += 1
        self._announce(
            mavlink.MAVLink_camera_image_captured_message(
                time_boot_ms=exposure.at.boot_ms,
                time_utc=exposure.at.utc_us,
                camera_id=0,
                lat=0,
                lon=0,
                alt=0,
                relative_alt=0,
                q=[math.nan] * 4,
                image_index=exposure.index,
                capture_result=0,
                file_url=b"",
            )
        )

    def _announce(self, captured: mavlink.MAVLink_camera_image_captured_message) -> None:
        self._pending -= 1
        self._captured[captured.image_index] = captured
        if len(self._captured) > KEPT_CAPTURES:
            self._captured.popitem(last=False)
        self._outbox.append(captured)

    # --- commands ----------------------------------------------------------------------------------------------------

    def _answer(self, message_id: int) -> Callable[[CommandRequest], int]:
        def answer(_: CommandRequest) -> int:
            self._outbox.append(self._builders[message_id]())
            return int(mavlink.MAV_RESULT_ACCEPTED)

        return answer

    def _request_message(self, request: CommandRequest) -> int:
        message_id = round(request.param(1))
        if message_id == mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED:
            return self._repeat_captured(round(request.finite_or_none(2) or 0), round(request.finite_or_none(3) or 0))
        builder = self._builders.get(message_id)
        if builder is None:
            return int(mavlink.MAV_RESULT_UNSUPPORTED)
        self._outbox.append(builder())
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _repeat_captured(self, first: int, last: int) -> int:
        """Announce captures again: from the ``first`` (-1: all) to the ``last`` (0: that one alone; -1: all since)."""
        last = self._next_index if first < 0 or last < 0 else max(first, last)
        captured = [message for index, message in self._captured.items() if first <= index <= last]
        self._outbox += captured
        return int(mavlink.MAV_RESULT_ACCEPTED if captured else mavlink.MAV_RESULT_DENIED)

    def _start_capture(self, request: CommandRequest) -> int:
        period_s = request.finite_or_none(2) or 0.0
        count = round(request.finite_or_none(3) or 0.0)
        if count == 1 and self._is_retransmission(request):
            return int(mavlink.MAV_RESULT_ACCEPTED)
        period_ticks = max(1, round(period_s * 1e6 / TICK_US))
        command = period_ticks, count
        if self._interval is not None and self._interval.command == command:
            return int(mavlink.MAV_RESULT_ACCEPTED)
        if self._interval is not None or self._pending >= MAX_PENDING:
            return int(mavlink.MAV_RESULT_TEMPORARILY_REJECTED)
        if count != 1 and not period_s > 0.0:
            return int(mavlink.MAV_RESULT_DENIED)
        if count == 1:
            self._expose()
            return int(mavlink.MAV_RESULT_ACCEPTED)
        self._interval = _Interval(command, self._now.tick, float(count) if count > 0 else math.inf)
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _is_retransmission(self, request: CommandRequest) -> bool:
        sequence = round(request.finite_or_none(4) or 0)
        source = (request.source_system, request.source_component)
        last_sequence, last_at_s = self._last_sequence.get(source, (0, -math.inf))
        repeated = sequence > 0 and sequence == last_sequence and self._now.s - last_at_s < RETRANSMISSION_WINDOW_S
        if not repeated and self._pending < MAX_PENDING:
            self._last_sequence[source] = (sequence, self._now.s)
        return repeated

    def _stop_capture(self, _: CommandRequest) -> int:
        self._interval = None
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _set_camera_mode(self, request: CommandRequest) -> int:
        if request.param(2) == mavlink.CAMERA_MODE_IMAGE:
            return int(mavlink.MAV_RESULT_ACCEPTED)
        return int(mavlink.MAV_RESULT_DENIED)

    def _expose(self) -> None:
        self._exposures.append(Exposure(self._system_id, self._next_index, self._now))
        self._next_index += 1
        self._pending += 1

    # --- messages ----------------------------------------------------------------------------------------------------

    def _heartbeat(self) -> mavlink.MAVLink_message:
        return mavlink.MAVLink_heartbeat_message(
            mavlink.MAV_TYPE_CAMERA, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE, 3
        )

    def _camera_information(self) -> mavlink.MAVLink_message:
        camera = self._camera
        mm_per_px = SENSOR_WIDTH_MM / camera.width_px
        return mavlink.MAVLink_camera_information_message(
            time_boot_ms=self._now.boot_ms,
            vendor_name=_name_bytes("aos-gcs"),
            model_name=_name_bytes("simulated RGB+thermal"),
            firmware_version=FIRMWARE_VERSION,
            focal_length=camera.fx_px * mm_per_px,
            sensor_size_h=SENSOR_WIDTH_MM,
            sensor_size_v=camera.height_px * mm_per_px,
            resolution_h=camera.width_px,
            resolution_v=camera.height_px,
            lens_id=0,
            flags=mavlink.CAMERA_CAP_FLAGS_CAPTURE_IMAGE,
            cam_definition_version=0,
            cam_definition_uri=b"",
        )

    def _camera_settings(self) -> mavlink.MAVLink_message:
        return mavlink.MAVLink_camera_settings_message(self._now.boot_ms, mavlink.CAMERA_MODE_IMAGE)

    def _storage_information(self) -> mavlink.MAVLink_message:
        return mavlink.MAVLink_storage_information_message(
            time_boot_ms=self._now.boot_ms,
            storage_id=1,
            storage_count=1,
            status=mavlink.STORAGE_STATUS_READY,
            total_capacity=STORAGE_MIB,
            used_capacity=0.0,
            available_capacity=STORAGE_MIB,
            read_speed=0.0,
            write_speed=0.0,
        )

    def _capture_status(self) -> mavlink.MAVLink_message:
        status = (IDLE, CAPTURING) if self._interval is None else (INTERVAL_IDLE, INTERVAL_CAPTURING)
        interval_s = 0.0 if self._interval is None else self._interval.period_ticks * TICK_US / 1e6
        return mavlink.MAVLink_camera_capture_status_message(
            time_boot_ms=self._now.boot_ms,
            image_status=status[self._pending > 0],
            video_status=0,
            image_interval=interval_s,
            recording_time_ms=0,
            available_capacity=STORAGE_MIB,
            image_count=self._next_index,
        )


def _nadir_quaternion(heading_rad: float) -> list[float]:
    R_cam2enu = nadir_pose((0.0, 0.0, 0.0), heading_rad).R_cam2enu
    return [float(part) for part in mavlink_quaternion_from_R_cam2enu(R_cam2enu)]


def _name_bytes(name: str) -> list[int]:
    return list(name.encode().ljust(32, b"\0"))
