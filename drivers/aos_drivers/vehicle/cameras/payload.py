"""Poses and exposures that a vehicle's autopilot and gimbal report, without I/O."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.poses.clocks import BootClock, ExposureTime
from aos_drivers.frames.poses.gimbal import gimbal_attitude
from aos_drivers.frames.poses.mount import Carrier
from aos_drivers.frames.poses.track import PoseTrack
from aos_drivers.frames.settings import CameraSettings
from aos_drivers.vehicle.failures import ReportFailures
from aos_drivers.vehicle.position_report import position_from_e7, position_report
from aos_drivers.vehicle.telemetry import MOST_UNREAD
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AmslM
from aos_gcs.geometry.rotations import R_from_yaw_pitch_roll


@dataclass(frozen=True, slots=True, eq=False)
class ShutterReport:
    """Report of an autopilot on one exposure of the camera that it triggers."""

    index: int
    is_success: bool
    time: ExposureTime
    position: GeodeticPosition | None
    """Position of the vehicle at exposure; None if it is not reported."""
    R_body2ned: NDArray[np.float64] | None
    """Attitude of the vehicle at exposure, shape (3, 3); None if the message may give that of the gimbal."""


class PayloadRecord:
    """The motion of one vehicle, its clock and its latest exposure. Survives reboots of the vehicle.

    Motion and times are taken in when somebody asks for what they change, in the order of their arrival and as of then;
    at most 32 of them wait for that.
    """

    __slots__ = ("_clock", "_failures", "_track", "_unread", "latest_report", "reports")

    def __init__(self, failures: ReportFailures) -> None:
        self._failures = failures
        self._track = PoseTrack()
        self._clock = BootClock()
        self._unread: list[tuple[mavlink.MAVLink_message, float]] = []
        """Messages that are not taken in yet, with their times of arrival."""
        self.latest_report: ShutterReport | None = None
        self.reports = 0
        """Number of reports received: indices start again when the vehicle restarts."""

    @property
    def track(self) -> PoseTrack:
        """Motion of the vehicle and its gimbal."""
        self._take_in()
        return self._track

    @property
    def clock(self) -> BootClock:
        """Clock of the vehicle."""
        self._take_in()
        return self._clock

    def _take_in(self) -> None:
        if self._unread:
            unread, self._unread = self._unread, []
            self._failures.take_in(unread, self._take)

    def _take(self, message: mavlink.MAVLink_message, now_s: float) -> None:
        _HANDLERS[message.get_msgId()](self._track, self._clock, message, now_s)

    def boot_now_s(self, now_s: float, timesync_offset_s: float | None) -> float | None:
        """Return the vehicle's time since boot; None before it has reported one."""
        offset_s = self.clock.offset_s(timesync_offset_s)
        return None if offset_s is None else now_s + offset_s

    def update(
        self,
        message: mavlink.MAVLink_message,
        message_id: int,
        now_s: float,
        timesync_offset_s: float | None,
        *,
        of_autopilot: bool,
    ) -> None:
        """Update from a message of the vehicle; most are ignored."""
        if of_autopilot and message_id in _HANDLERS:
            unread = self._unread
            unread.append((message, now_s))
            if len(unread) >= MOST_UNREAD:
                self._take_in()
        elif message_id == mavlink.MAVLINK_MSG_ID_GIMBAL_DEVICE_ATTITUDE_STATUS:
            # A separate gimbal has its own clock: the time of arrival is used.
            boot_now_s = self.boot_now_s(now_s, timesync_offset_s)
            at_s = message.time_boot_ms / 1e3 if of_autopilot else boot_now_s
            if at_s is not None:
                self._take_gimbal(message, at_s)
        elif of_autopilot and message_id in _REPORTS:
            boot_now_s = self.boot_now_s(now_s, timesync_offset_s)
            if boot_now_s is not None:
                self.latest_report = _REPORTS[message_id](message, self.clock, boot_now_s)
                self.reports += 1

    def _take_gimbal(self, message: mavlink.MAVLink_gimbal_device_attitude_status_message, at_s: float) -> None:
        try:
            attitude = gimbal_attitude(message.q, message.flags, message.delta_yaw)
        except ValueError:
            return  # An invalid attitude is ignored; a frame that lacks one is refused with that reason.
        self.track.add_gimbal(at_s, attitude)


def motion_rates_hz(settings: CameraSettings) -> dict[int, float]:
    """Return the messages, with their rates, that are needed to interpolate poses."""
    if not settings.needs_motion:
        return {}
    rates = {
        mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: settings.pose_hz,
        mavlink.MAVLINK_MSG_ID_ATTITUDE: settings.pose_hz,
        mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: 1.0,
    }
    if settings.mount.carrier is Carrier.GIMBAL:
        rates[mavlink.MAVLINK_MSG_ID_GIMBAL_DEVICE_ATTITUDE_STATUS] = settings.pose_hz
    return rates


def _take_position(
    track: PoseTrack, clock: BootClock, message: mavlink.MAVLink_global_position_int_message, now_s: float
) -> None:
    report = position_report(message)
    boot_s = report.boot_ms / 1e3
    clock.hear_boot(boot_s, now_s)
    if (position := report.position) is not None:
        place = position.latitude_deg, position.longitude_deg, position.altitude_amsl_m
        track.add_motion(boot_s, (*place, *report.velocity_enu_mps))


def _take_attitude(track: PoseTrack, clock: BootClock, message: mavlink.MAVLink_attitude_message, now_s: float) -> None:
    boot_s = message.time_boot_ms / 1e3
    clock.hear_boot(boot_s, now_s)
    angles_rad = (message.yaw, message.pitch, message.roll)
    if all(map(math.isfinite, angles_rad)):
        track.add_attitude(boot_s, angles_rad)


def _take_system_time(
    _track: PoseTrack, clock: BootClock, message: mavlink.MAVLink_system_time_message, _now_s: float
) -> None:
    clock.hear_utc(message.time_unix_usec / 1e6, message.time_boot_ms / 1e3)


def _from_feedback(
    message: mavlink.MAVLink_camera_feedback_message, clock: BootClock, boot_now_s: float
) -> ShutterReport:
    """Report of ArduPilot: its attitude is that of the body, its time one of two kinds."""
    angles_deg = (message.yaw, message.pitch, message.roll)
    R_body2ned = None
    if all(map(math.isfinite, angles_deg)):
        yaw_rad, pitch_rad, roll_rad = map(math.radians, angles_deg)
        R_body2ned = R_from_yaw_pitch_roll((yaw_rad, pitch_rad, roll_rad))
    return ShutterReport(
        index=message.img_idx,
        is_success=True,
        time=clock.exposure_time(message.time_usec, boot_now_s),
        position=position_from_e7(message.lat, message.lng, AmslM(message.alt_msl)),
        R_body2ned=R_body2ned,
    )


def _from_image_captured(
    message: mavlink.MAVLink_camera_image_captured_message, clock: BootClock, boot_now_s: float
) -> ShutterReport:
    """Report of PX4: its time counts from boot. Its attitude is ignored, as it may be the gimbal's or the body's."""
    return ShutterReport(
        index=message.image_index,
        is_success=message.capture_result == 1,
        time=clock.exposure_time(message.time_boot_ms * 1000, boot_now_s),
        position=position_from_e7(message.lat, message.lon, AmslM(message.alt / 1000)),
        R_body2ned=None,
    )


_REPORTS: dict[int, Callable[[mavlink.MAVLink_message, BootClock, float], ShutterReport]] = {
    mavlink.MAVLINK_MSG_ID_CAMERA_FEEDBACK: _from_feedback,
    mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED: _from_image_captured,
}
_HANDLERS: dict[int, Callable[[PoseTrack, BootClock, mavlink.MAVLink_message, float], None]] = {
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: _take_position,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: _take_attitude,
    mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: _take_system_time,
}
