"""ArduCopter."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.autopilots.arducopter_setup import ArduCopterSetup
from aos_drivers.vehicle.autopilots.base import (
    REPEAT_S,
    MulticopterDialect,
    Step,
    Target,
    command_long,
    deviation,
    has_position_and_home,
    reposition,
)
from aos_drivers.vehicle.autopilots.goto import GotoEvidence
from aos_drivers.vehicle.telemetry import Telemetry
from aos_drivers.vehicle.transaction import CommandMessage
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AboveHomeM
from aos_gcs.ports import Arm, Command, FlightMode, Goto, Hold, Land, ReturnToLaunch, Takeoff

_MODES: dict[int, FlightMode] = {
    mavlink.COPTER_MODE_GUIDED: FlightMode.GUIDED,
    mavlink.COPTER_MODE_GUIDED_NOGPS: FlightMode.GUIDED,
    mavlink.COPTER_MODE_BRAKE: FlightMode.HOLD,
    mavlink.COPTER_MODE_LOITER: FlightMode.HOLD,
    mavlink.COPTER_MODE_POSHOLD: FlightMode.HOLD,
    mavlink.COPTER_MODE_AUTO: FlightMode.MISSION,
    mavlink.COPTER_MODE_RTL: FlightMode.RETURN,
    mavlink.COPTER_MODE_SMART_RTL: FlightMode.RETURN,
    mavlink.COPTER_MODE_AUTO_RTL: FlightMode.RETURN,
    mavlink.COPTER_MODE_LAND: FlightMode.LAND,
}
_COMMANDED: dict[FlightMode, tuple[int, str]] = {
    FlightMode.GUIDED: (mavlink.COPTER_MODE_GUIDED, "GUIDED"),
    # LOITER would take a missing pilot's throttle for "descend".
    FlightMode.HOLD: (mavlink.COPTER_MODE_BRAKE, "BRAKE"),
    FlightMode.RETURN: (mavlink.COPTER_MODE_RTL, "RTL"),
    FlightMode.LAND: (mavlink.COPTER_MODE_LAND, "LAND"),
}
_POSITION_FLAGS = mavlink.EKF_POS_HORIZ_REL | mavlink.EKF_POS_HORIZ_ABS


class ArduCopterDialect(MulticopterDialect):
    """ArduCopter 4.1 and newer (DO_REPOSITION)."""

    name = "arducopter"
    setup = ArduCopterSetup()
    arming_mode: ClassVar[FlightMode] = FlightMode.GUIDED
    modes_with_target: ClassVar[frozenset[FlightMode]] = frozenset({FlightMode.GUIDED})
    modes_by_command: ClassVar[Mapping[type[Command], frozenset[str]]] = MappingProxyType(
        {
            **dict.fromkeys((Arm, Takeoff, Goto), frozenset({"GUIDED"})),
            Hold: frozenset({"BRAKE"}),
            ReturnToLaunch: frozenset({"RTL", "LAND"}),
            Land: frozenset({"LAND"}),
        }
    )
    shutter_report_id = mavlink.MAVLINK_MSG_ID_CAMERA_FEEDBACK

    def mode(self, heartbeat: mavlink.MAVLink_heartbeat_message) -> tuple[FlightMode, str]:
        """See the base class."""
        entry = mavlink.enums["COPTER_MODE"].get(heartbeat.custom_mode)
        name = str(entry.name).removeprefix("COPTER_MODE_") if entry is not None else f"mode {heartbeat.custom_mode}"
        fallback = FlightMode.MANUAL if entry is not None else FlightMode.UNKNOWN
        return _MODES.get(heartbeat.custom_mode, fallback), name

    def is_ready(self, telemetry: Telemetry, now_s: float) -> bool | None:
        """See the base class. The pre-arm bit alone is not enough: in STABILIZE it needs no position."""
        if telemetry.prearm_healthy is None or telemetry.ekf_flags is None:
            return None
        has_ekf = telemetry.ekf_flags & _POSITION_FLAGS == _POSITION_FLAGS
        is_constant = bool(telemetry.ekf_flags & mavlink.EKF_CONST_POS_MODE)
        return telemetry.prearm_healthy and has_ekf and not is_constant and has_position_and_home(telemetry, now_s)

    def estimator_problem(self, telemetry: Telemetry) -> str:
        """See the base class."""
        flags = telemetry.ekf_flags
        if flags is not None and (not flags & _POSITION_FLAGS or flags & mavlink.EKF_CONST_POS_MODE):
            return "its estimator has no position"
        return deviation(telemetry)

    def stream_rates_hz(self, position_hz: float) -> dict[int, float]:
        """See the base class."""
        own = {
            mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT: 1.0,
            mavlink.MAVLINK_MSG_ID_VIBRATION: 0.5,
            # A velocity that another station commands shows here alone.
            mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED: 1.0,
        }
        return {**super().stream_rates_hz(position_hz), **own}

    def set_mode(self, mode: FlightMode, target: Target) -> Step:
        """See the base class."""
        number, name = _COMMANDED[mode]
        flag = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        message = command_long(target, mavlink.MAV_CMD_DO_SET_MODE, flag, number)
        return Step(f"enter {name}", message, lambda state, _now_s: state.mode is mode, REPEAT_S)

    def takeoff(self, height_above_home_m: AboveHomeM, target: Target, home: GeodeticPosition) -> CommandMessage:
        """See the base class. ArduCopter takes the height relative to home."""
        del home
        nan = math.nan
        return command_long(target, mavlink.MAV_CMD_NAV_TAKEOFF, 0.0, 0.0, 0.0, nan, 0.0, 0.0, height_above_home_m)

    def goto(self, command: Goto, target: Target, telemetry: Telemetry, now_s: float) -> list[Step]:
        """See the base class.

        ArduCopter ignores the speed of DO_REPOSITION and takes the one of WPNAV_SPEED whenever it enters GUIDED, so the
        speed comes afterwards. What it acknowledges it has taken over: its own target is not needed as evidence, and
        that of 4.7-dev (September 2025) is a hundred times too near to its origin. To a vehicle in GUIDED it is sent
        without the change of mode: where a pilot has left GUIDED since the last heartbeat, it is refused. A heading
        comes after the place, which ends the one before.
        """
        evidence = GotoEvidence(command.position, telemetry, now_s, is_echo_reliable=False)
        changes_mode = telemetry.mode is not FlightMode.GUIDED
        change_speed = command_long(
            target, mavlink.MAV_CMD_DO_CHANGE_SPEED, mavlink.SPEED_TYPE_GROUNDSPEED, command.speed_mps, -1.0
        )
        message = reposition(command, target, changes_mode=changes_mode)
        return [
            Step("goto", message, evidence, REPEAT_S, needs_acceptance=True),
            *([] if command.heading_rad is None else [_turn(command.heading_rad, target)]),
            Step("change its speed", change_speed, lambda _state, _now_s: True, needs_acceptance=True),
        ]


def _turn(heading_rad: float, target: Target) -> Step:
    """Return the step that turns the vehicle the short way round."""
    message = command_long(target, mavlink.MAV_CMD_CONDITION_YAW, math.degrees(heading_rad) % 360.0)
    return Step("turn", message, lambda _state, _now_s: True, is_optional=True)
