"""Reports of a vehicle about its pose: its estimate and, if it is simulated itself, the truth.

The true pose comes from SIM_STATE (ArduPilot's simulator) or HIL_STATE_QUATERNION (PX4's). Neither holds a time, so a
true pose is taken to be of the moment at which it arrives, counted on the vehicle's clock. A vehicle that sends neither
is where it believes to be.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import SEA_LEVEL, AboveHomeM, AmslM, above_home_m, home_below_m
from aos_sim.attached.pose_track import PoseTrack, TimedPose
from aos_sim.camera.component import CameraView

_UNKNOWN_HEADING = 65535
_MAX_AHEAD_S = 0.1
"""A vehicle's clock is not taken to be farther ahead of its last message: it may be slower than ours, or late."""
_REBOOT_MARGIN_S = 2.0


@dataclass(frozen=True, slots=True)
class VehiclePose:
    """Pose of a vehicle at one moment."""

    true: TimedPose
    believed: CameraView
    velocity_enu_mps: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Velocity that it has told last."""


@dataclass(slots=True)
class PoseTelemetry:
    """The poses of one vehicle, from its messages and the times of their arrival on any steady clock."""

    home: GeodeticPosition | None = None
    believed: PoseTrack = field(default_factory=PoseTrack)
    true: PoseTrack = field(default_factory=PoseTrack)
    tells_truth: bool = False
    """Whether the vehicle has ever told its true pose; from then on, its belief is not taken for it."""
    _home_altitude_amsl_m: AmslM = SEA_LEVEL
    _velocity_enu_mps: tuple[float, float, float] = (0.0, 0.0, 0.0)
    _boot_s: float = -math.inf
    """The vehicle's time in its latest message that tells one, ..."""
    _boot_heard_at_s: float = -math.inf
    """... and when that arrived."""

    def hear(self, message: mavlink.MAVLink_message, now_s: float) -> None:
        """Take in a message of the autopilot."""
        match message.get_msgId():
            case mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT:
                self._hear_belief(message, now_s)
            case mavlink.MAVLINK_MSG_ID_SIM_STATE:
                place = _place(message.lat_int, message.lon_int, message.alt)
                self._add_truth(place, message.yaw, now_s)
            case mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION:
                place = _place(message.lat, message.lon, message.alt / 1e3)
                self._add_truth(place, _yaw(message.attitude_quaternion), now_s)
            case mavlink.MAVLINK_MSG_ID_HOME_POSITION:
                self.home = _place(message.latitude, message.longitude, message.altitude / 1e3) or self.home

    def vehicle_time_s(self, now_s: float) -> float | None:
        """Return the vehicle's time since its start at ``now_s``, or None before it has told any."""
        if self.believed.is_empty:
            return None
        return self._boot_s + min(now_s - self._boot_heard_at_s, _MAX_AHEAD_S)

    def pose_at(self, moment_s: float) -> VehiclePose | None:
        """Return the pose at a moment of the vehicle's time, or None where it is not known (or not yet)."""
        believed = self.believed.at(moment_s)
        true = self.true.at(moment_s) if self.tells_truth else believed
        if believed is None or true is None:
            return None
        height_m = above_home_m(believed.position.altitude_amsl_m, self._home_altitude_amsl_m)
        return VehiclePose(true, CameraView(believed.position, height_m, believed.heading_rad), self._velocity_enu_mps)

    def _hear_belief(self, message: mavlink.MAVLink_message, now_s: float) -> None:
        boot_s = message.time_boot_ms / 1e3
        if boot_s + _REBOOT_MARGIN_S < self._boot_s:
            self.believed.clear()
            self.true.clear()
        self._boot_s, self._boot_heard_at_s = boot_s, now_s
        self._velocity_enu_mps = (message.vy / 100, message.vx / 100, -message.vz / 100)
        place = _place(message.lat, message.lon, message.alt / 1e3)
        if place is not None and message.hdg != _UNKNOWN_HEADING:
            self.believed.add(TimedPose(boot_s, place, math.radians(message.hdg / 100)))
            self._home_altitude_amsl_m = home_below_m(AmslM(message.alt / 1e3), AboveHomeM(message.relative_alt / 1e3))

    def _add_truth(self, place: GeodeticPosition | None, yaw_rad: float, now_s: float) -> None:
        moment_s = self.vehicle_time_s(now_s)
        if place is not None and moment_s is not None:
            self.tells_truth = True
            self.true.add(TimedPose(moment_s, place, yaw_rad % (2 * math.pi)))


def _place(latitude_e7: int, longitude_e7: int, altitude_amsl_m: AmslM) -> GeodeticPosition | None:
    """Return a position; None for latitude and longitude 0, which stand for "unknown"."""
    if latitude_e7 == 0 and longitude_e7 == 0:
        return None
    return GeodeticPosition(latitude_e7 / 1e7, longitude_e7 / 1e7, altitude_amsl_m)


def _yaw(q_wxyz: list[float]) -> float:
    """Return the heading of a rotation from forward-right-down to north-east-down."""
    w, x, y, z = q_wxyz
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
