"""The latest values that a vehicle's autopilot has reported."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.confirmation import Confirmation, JumpFilter
from aos_drivers.vehicle.frozen import FrozenPosition
from aos_drivers.vehicle.jumps import PositionJumps
from aos_drivers.vehicle.position_report import position_from_e7, position_report
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AboveHomeM, AmslM, amsl_above_home_m
from aos_gcs.ports import FlightMode, LandedState

_UNKNOWN_UINT16 = 0xFFFF
MOST_UNREAD = 32
"""Messages that wait until somebody asks for what they report."""
_ORDER_S = 2.0
"""Time for which an older position does not replace a newer one; after that, the vehicle's clock may have jumped."""
_RELATIVE_FRAMES = frozenset({mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT})
_STAGES = {0: "dev", 64: "alpha", 128: "beta", 192: "rc"}
"""Stages of a firmware's version; FIRMWARE_VERSION_TYPE."""
_IGNORES_POSITION = 0b111
_LANDED = {
    mavlink.MAV_LANDED_STATE_ON_GROUND: LandedState.ON_GROUND,
    mavlink.MAV_LANDED_STATE_IN_AIR: LandedState.IN_AIR,
    mavlink.MAV_LANDED_STATE_TAKEOFF: LandedState.TAKING_OFF,
    mavlink.MAV_LANDED_STATE_LANDING: LandedState.LANDING,
}


_FLIES = frozenset({LandedState.IN_AIR, LandedState.TAKING_OFF, LandedState.LANDING})


@dataclass(frozen=True, slots=True)
class PositionTarget:
    """Position that the autopilot reports to be flying to."""

    position: GeodeticPosition
    at_s: float


@dataclass(slots=True, eq=False)
class Telemetry:
    """Latest value per quantity; ``None`` until it is reported. Policy: newer values replace older ones.

    ``update`` takes the messages of the vehicle's autopilot component alone.
    """

    mode: FlightMode = FlightMode.UNKNOWN
    mode_name: str = ""
    armed: bool = False
    heartbeat_at_s: float | None = None
    round_trip_s: float = 0.0
    """Time that a question and its answer take at most now: a message that comes earlier may be older than it."""
    landed: LandedState = LandedState.UNKNOWN
    landed_at_s: float | None = None
    has_flown: bool = False
    """Whether it has reported to be in the air since its motors were started."""
    position: GeodeticPosition | None = None
    position_at_s: float | None = None
    position_boot_ms: int = 0
    """The vehicle's time since boot of ``position``."""
    jumps: PositionJumps = field(default_factory=PositionJumps)
    velocity_enu_mps: tuple[float, float, float] | None = None
    heading_rad: float | None = None
    home: GeodeticPosition | None = None
    prearm_healthy: bool | None = None
    ekf_flags: int | None = None
    estimator_flags: int | None = None
    battery_fraction: float | None = None
    battery_at_s: float | None = None
    battery_voltage_v: float | None = None
    gps_fix: int | None = None
    satellites: int | None = None
    hdop: float | None = None
    receiver_accuracy_m: tuple[float, float] | None = None
    """Horizontal and vertical accuracy that the satellite receiver reports."""
    estimator_accuracy_m: tuple[float, float] | None = None
    """Horizontal and vertical accuracy that the autopilot's estimator reports."""
    altitude_test_ratio: float | None = None
    horizontal_test_ratio: float | None = None
    vibration_mps2: float | None = None
    gps_altitude_amsl_m: AmslM | None = None
    pressure_hpa: float | None = None
    firmware: str = ""
    """Version of the autopilot: "4.7.0 dev"; empty until it is reported."""
    board_id: str = ""
    """Hexadecimal; empty when the board has none."""
    target: PositionTarget | None = None
    text: str = ""
    text_at_s: float | None = None
    relative_altitude_m: AboveHomeM | None = None
    _disarming: Confirmation = field(default_factory=Confirmation)
    _landing: Confirmation = field(default_factory=Confirmation)
    _jumps: JumpFilter = field(default_factory=JumpFilter)
    _frozen: FrozenPosition = field(default_factory=FrozenPosition)

    @property
    def height_above_home_m(self) -> AboveHomeM | None:
        """Height above home; unknown before home is, because autopilots report a meaningless one until then."""
        return self.relative_altitude_m if self.home is not None else None

    @property
    def horizontal_accuracy_m(self) -> float | None:
        """Largest horizontal accuracy reported, by the receiver or the estimator."""
        return max((each[0] for each in self._accuracies_m()), default=None)

    @property
    def vertical_accuracy_m(self) -> float | None:
        """Largest vertical accuracy reported, by the receiver or the estimator."""
        return max((each[1] for each in self._accuracies_m()), default=None)

    def _accuracies_m(self) -> list[tuple[float, float]]:
        return [each for each in (self.receiver_accuracy_m, self.estimator_accuracy_m) if each is not None]

    def after_restart(self) -> Telemetry:
        """Return the telemetry of the same vehicle when its autopilot has restarted.

        Mode, motors and position stay as they were last, without the time of a report where that would make them
        certain: a vehicle in the air is not on the ground because its autopilot has restarted.
        """
        telemetry = Telemetry()
        telemetry.mode, telemetry.mode_name, telemetry.armed = self.mode, self.mode_name, self.armed
        telemetry.position, telemetry.position_at_s = self.position, self.position_at_s
        telemetry.velocity_enu_mps, telemetry.jumps = self.velocity_enu_mps, self.jumps
        telemetry.has_flown = self.has_flown
        return telemetry

    @property
    def has_position(self) -> bool:
        """Whether the autopilot has a position that it measures. Without one it goes on to send the last."""
        if self.gps_fix is not None and self.gps_fix < mavlink.GPS_FIX_TYPE_3D_FIX:
            return False
        if self.ekf_flags is not None:
            return bool(self.ekf_flags & mavlink.EKF_POS_HORIZ_ABS) and not self.ekf_flags & mavlink.EKF_CONST_POS_MODE
        # PX4 sets its bit of a constant position while it stands still, too.
        return self.estimator_flags is None or bool(self.estimator_flags & mavlink.ESTIMATOR_POS_HORIZ_ABS)

    def take_position(
        self,
        position: GeodeticPosition | None,
        now_s: float,
        velocity_enu_mps: tuple[float, float, float] | None = None,
        boot_ms: int | None = None,
    ) -> bool:
        """Take in a reported position, and return whether it counts; one that is only repeated keeps its age."""
        if position is not None and not self._jumps.admits(position, now_s, self.position, self.position_at_s):
            return False
        if position is not None and (self.has_position or self.position is None):
            velocity_enu_mps = velocity_enu_mps or self.velocity_enu_mps
            is_copy = boot_ms is not None and self._frozen.is_copy(position, boot_ms, now_s)
            if not self._frozen.is_repeated(position, now_s, velocity_enu_mps, self.pressure_hpa) and not is_copy:
                self.position_at_s = now_s
            self.position = position
        return True

    def take_armed(self, armed: bool, now_s: float) -> bool:
        """Take in whether the motors run, and return whether the report counts: that they have stopped is confirmed."""
        if armed or not self.armed:
            self._disarming.deny()
        elif not self._disarming.claim(now_s):
            return False
        self.armed, self.heartbeat_at_s = armed, now_s
        self.has_flown = self.has_flown and armed
        return True

    def take_landed(self, landed: LandedState, now_s: float) -> None:
        """Take in the landed state: that the vehicle is on the ground counts from the second report on."""
        if landed is not LandedState.ON_GROUND:
            self._landing.deny()
        elif not self._landing.claim(now_s):
            return
        self.landed, self.landed_at_s = landed, now_s
        self.has_flown = self.has_flown or (self.armed and landed in _FLIES)

    def update(self, message: mavlink.MAVLink_message, now_s: float) -> None:
        """Update from one message; messages without telemetry are ignored."""
        handler = _HANDLERS.get(message.get_msgId())
        if handler is not None:
            handler(self, message, now_s)


def has_no_position(target: mavlink.MAVLink_message) -> bool:
    """Return whether a reported target, POSITION_TARGET_GLOBAL_INT or POSITION_TARGET_LOCAL_NED, is not a position."""
    return bool(target.type_mask & _IGNORES_POSITION)


def _take_global_position(
    telemetry: Telemetry, message: mavlink.MAVLink_global_position_int_message, now_s: float
) -> None:
    report = position_report(message)
    boot_ms, position, velocity_enu_mps = report.boot_ms, report.position, report.velocity_enu_mps
    is_recent = telemetry.position_at_s is not None and now_s - telemetry.position_at_s < _ORDER_S
    if is_recent and boot_ms < telemetry.position_boot_ms:
        return  # overtaken by a newer one
    if not telemetry.take_position(position, now_s, velocity_enu_mps, boot_ms):
        return
    telemetry.position_boot_ms = boot_ms
    if position is not None:
        telemetry.jumps.take(position, velocity_enu_mps, boot_ms)
    if report.heading_rad is not None:
        telemetry.heading_rad = report.heading_rad
    telemetry.relative_altitude_m = report.relative_altitude_m
    telemetry.velocity_enu_mps = velocity_enu_mps


def _take_attitude(telemetry: Telemetry, message: mavlink.MAVLink_attitude_message, _now_s: float) -> None:
    if telemetry.position is None and math.isfinite(message.yaw):
        telemetry.heading_rad = message.yaw % math.tau


def _take_sys_status(telemetry: Telemetry, message: mavlink.MAVLink_sys_status_message, now_s: float) -> None:
    # PX4 never says that the check is present.
    telemetry.prearm_healthy = bool(message.onboard_control_sensors_health & mavlink.MAV_SYS_STATUS_PREARM_CHECK)
    if message.voltage_battery not in (0, _UNKNOWN_UINT16):
        telemetry.battery_voltage_v = message.voltage_battery / 1000
    _take_charge(telemetry, message.battery_remaining, now_s)


def _take_battery(telemetry: Telemetry, message: mavlink.MAVLink_battery_status_message, now_s: float) -> None:
    if message.id == 0:
        _take_charge(telemetry, message.battery_remaining, now_s)


def _take_charge(telemetry: Telemetry, percent: int, now_s: float) -> None:
    if 0 <= percent <= 100:
        telemetry.battery_fraction, telemetry.battery_at_s = percent / 100, now_s


def _take_vibration(telemetry: Telemetry, message: mavlink.MAVLink_vibration_message, _now_s: float) -> None:
    levels_mps2 = message.vibration_x, message.vibration_y, message.vibration_z
    telemetry.vibration_mps2 = max(levels_mps2) if all(map(math.isfinite, levels_mps2)) else None


def _take_gps(telemetry: Telemetry, message: mavlink.MAVLink_gps_raw_int_message, _now_s: float) -> None:
    telemetry.gps_fix = message.fix_type
    telemetry.satellites = message.satellites_visible if message.satellites_visible != 255 else None
    telemetry.hdop = message.eph / 100 if message.eph != _UNKNOWN_UINT16 else None
    # Packets of MAVLink 1 lack the accuracies, and their fields read 0.
    has_accuracy = message.h_acc > 0 and message.v_acc > 0
    telemetry.receiver_accuracy_m = (message.h_acc / 1000, message.v_acc / 1000) if has_accuracy else None
    is_fixed = message.fix_type >= mavlink.GPS_FIX_TYPE_3D_FIX
    telemetry.gps_altitude_amsl_m = AmslM(message.alt / 1000) if is_fixed else None


def _take_pressure(telemetry: Telemetry, message: mavlink.MAVLink_scaled_pressure_message, _now_s: float) -> None:
    is_pressure = math.isfinite(message.press_abs) and message.press_abs > 0.0
    telemetry.pressure_hpa = message.press_abs if is_pressure else None


def _take_version(telemetry: Telemetry, message: mavlink.MAVLink_autopilot_version_message, _now_s: float) -> None:
    major, minor, patch, stage = message.flight_sw_version.to_bytes(4, "big")
    name = _STAGES.get(stage, "")
    telemetry.firmware = f"{major}.{minor}.{patch} {name}".rstrip()
    uid = bytes(message.uid2) if any(message.uid2) else message.uid.to_bytes(8, "little")
    telemetry.board_id = uid.rstrip(b"\0").hex()


def _take_home(telemetry: Telemetry, message: mavlink.MAVLink_home_position_message, _now_s: float) -> None:
    home = position_from_e7(message.latitude, message.longitude, AmslM(message.altitude / 1000))
    telemetry.home = home or telemetry.home


def _take_extended_state(
    telemetry: Telemetry, message: mavlink.MAVLink_extended_sys_state_message, now_s: float
) -> None:
    telemetry.take_landed(_LANDED.get(message.landed_state, LandedState.UNKNOWN), now_s)


def _take_ekf(telemetry: Telemetry, message: mavlink.MAVLink_ekf_status_report_message, _now_s: float) -> None:
    telemetry.ekf_flags = message.flags
    # The message's "variances" are test ratios: innovations as a share of what the filter accepts.
    ratio = message.pos_vert_variance
    telemetry.altitude_test_ratio = ratio if math.isfinite(ratio) else None
    telemetry.horizontal_test_ratio = _largest(message.velocity_variance, message.pos_horiz_variance)


def _take_estimator(telemetry: Telemetry, message: mavlink.MAVLink_estimator_status_message, _now_s: float) -> None:
    telemetry.estimator_flags = message.flags
    telemetry.altitude_test_ratio = message.pos_vert_ratio if math.isfinite(message.pos_vert_ratio) else None
    telemetry.horizontal_test_ratio = _largest(message.vel_ratio, message.pos_horiz_ratio)
    accuracy_m = message.pos_horiz_accuracy, message.pos_vert_accuracy
    has_accuracy = all(math.isfinite(each_m) and each_m > 0.0 for each_m in accuracy_m)
    telemetry.estimator_accuracy_m = accuracy_m if has_accuracy else None


def _largest(*ratios: float) -> float | None:
    return max((ratio for ratio in ratios if math.isfinite(ratio)), default=None)


def _take_target(
    telemetry: Telemetry, message: mavlink.MAVLink_position_target_global_int_message, now_s: float
) -> None:
    altitude_m = AmslM(message.alt)
    if message.coordinate_frame in _RELATIVE_FRAMES:
        if telemetry.home is None:
            return
        altitude_m = amsl_above_home_m(telemetry.home.altitude_amsl_m, AboveHomeM(message.alt))
    position = position_from_e7(message.lat_int, message.lon_int, altitude_m)
    if position is not None and not has_no_position(message):
        telemetry.target = PositionTarget(position, now_s)


_Handler = Callable[[Telemetry, mavlink.MAVLink_message, float], None]
_HANDLERS: dict[int, _Handler] = {
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: _take_global_position,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: _take_attitude,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: _take_sys_status,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: _take_battery,
    mavlink.MAVLINK_MSG_ID_VIBRATION: _take_vibration,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: _take_gps,
    mavlink.MAVLINK_MSG_ID_SCALED_PRESSURE: _take_pressure,
    mavlink.MAVLINK_MSG_ID_HOME_POSITION: _take_home,
    mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION: _take_version,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: _take_extended_state,
    mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT: _take_ekf,
    mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS: _take_estimator,
    mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT: _take_target,
}
REPORT_IDS = frozenset(_HANDLERS)
"""Messages that change telemetry."""
