"""PX4 multicopters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

from pymavlink.dialects.v20 import ardupilotmega as mavlink

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
from aos_drivers.vehicle.autopilots.px4_setup import Px4Setup
from aos_drivers.vehicle.telemetry import Telemetry
from aos_drivers.vehicle.transaction import CommandMessage
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AboveHomeM
from aos_gcs.ports import Arm, Command, FlightMode, Goto, Hold, Land, ReturnToLaunch, Takeoff

_AUTO = 4
_MAIN_MODES: dict[int, tuple[FlightMode, str]] = {
    1: (FlightMode.MANUAL, "MANUAL"),
    2: (FlightMode.MANUAL, "ALTCTL"),
    3: (FlightMode.MANUAL, "POSCTL"),
    5: (FlightMode.MANUAL, "ACRO"),
    6: (FlightMode.GUIDED, "OFFBOARD"),
    7: (FlightMode.MANUAL, "STABILIZED"),
}
_AUTO_MODES: dict[int, tuple[FlightMode, str]] = {
    1: (FlightMode.HOLD, "AUTO.READY"),
    2: (FlightMode.TAKEOFF, "AUTO.TAKEOFF"),
    3: (FlightMode.HOLD, "AUTO.LOITER"),
    4: (FlightMode.MISSION, "AUTO.MISSION"),
    5: (FlightMode.RETURN, "AUTO.RTL"),
    6: (FlightMode.LAND, "AUTO.LAND"),
    9: (FlightMode.LAND, "AUTO.PRECLAND"),
}
_HOLD_NAME = _AUTO_MODES[3][1]
_COMMANDED: dict[FlightMode, int] = {FlightMode.HOLD: 3, FlightMode.RETURN: 5, FlightMode.LAND: 6}

STOPPED_MPS = 1.0
_SETTLING_S = 1.0
_STOP_REPEAT_S = 1.5


class Px4Dialect(MulticopterDialect):
    """PX4 1.14 and newer. It flies to our positions in its Hold mode, so GUIDED is never seen."""

    name = "px4"
    setup = Px4Setup()
    arming_mode: ClassVar[FlightMode] = FlightMode.HOLD
    modes_by_command: ClassVar[Mapping[type[Command], frozenset[str]]] = MappingProxyType(
        {
            Arm: frozenset({"AUTO.READY", "AUTO.LOITER"}),
            Takeoff: frozenset({"AUTO.TAKEOFF"}),
            **dict.fromkeys((Goto, Hold), frozenset({"AUTO.LOITER"})),
            ReturnToLaunch: frozenset({"AUTO.RTL", "AUTO.LAND", "AUTO.PRECLAND"}),
            Land: frozenset({"AUTO.LAND"}),
        }
    )
    modes_after_takeoff = frozenset({"AUTO.LOITER"})
    quiet_message_ids = (
        mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION,
        mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET,
        mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
        mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED,
        mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW,
        mavlink.MAVLINK_MSG_ID_VFR_HUD,
        mavlink.MAVLINK_MSG_ID_HIGHRES_IMU,
        mavlink.MAVLINK_MSG_ID_ALTITUDE,
        mavlink.MAVLINK_MSG_ID_ODOMETRY,
    )

    def mode(self, heartbeat: mavlink.MAVLink_heartbeat_message) -> tuple[FlightMode, str]:
        """See the base class."""
        main, sub = heartbeat.custom_mode >> 16 & 0xFF, heartbeat.custom_mode >> 24 & 0xFF
        if main == _AUTO:
            return _AUTO_MODES.get(sub, (FlightMode.UNKNOWN, f"AUTO.{sub}"))
        return _MAIN_MODES.get(main, (FlightMode.UNKNOWN, f"mode {main}.{sub}"))

    def is_ready(self, telemetry: Telemetry, now_s: float) -> bool | None:
        """See the base class."""
        if telemetry.prearm_healthy is None:
            return None
        flags = telemetry.estimator_flags
        has_estimate = flags is None or bool(flags & mavlink.ESTIMATOR_POS_HORIZ_ABS)
        return telemetry.prearm_healthy and has_estimate and has_position_and_home(telemetry, now_s)

    def estimator_problem(self, telemetry: Telemetry) -> str:
        """See the base class."""
        flags = telemetry.estimator_flags
        if flags is not None and not flags & mavlink.ESTIMATOR_POS_HORIZ_ABS:
            return "its estimator has no position"
        return deviation(telemetry)

    def stream_rates_hz(self, position_hz: float) -> dict[int, float]:
        """See the base class."""
        own = {mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS: 1.0, mavlink.MAVLINK_MSG_ID_VIBRATION: 0.5}
        return {**super().stream_rates_hz(position_hz), **own}

    def shutter_command(self, target: Target) -> CommandMessage:
        """See the base class. PX4's camera trigger knows the command of the older camera protocol alone."""
        return command_long(target, mavlink.MAV_CMD_DO_DIGICAM_CONTROL, 0.0, 0.0, 0.0, 0.0, 1.0)

    def set_mode(self, mode: FlightMode, target: Target) -> Step:
        """See the base class."""
        flag = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        sub = _COMMANDED[mode]
        message = command_long(target, mavlink.MAV_CMD_DO_SET_MODE, flag, _AUTO, sub)
        return Step(f"enter {_AUTO_MODES[sub][1]}", message, lambda state, _now_s: state.mode is mode, REPEAT_S)

    def goto(self, command: Goto, target: Target, telemetry: Telemetry, now_s: float) -> list[Step]:
        """See the base class.

        In Hold it is sent without the change of mode, which would overrule a pilot who has taken over since the last
        heartbeat, and cancel a failsafe. PX4 1.14 to 1.16 answer that it is unsupported, and fly there, in Hold and in
        no other mode; newer ones acknowledge it.
        """
        evidence = GotoEvidence(command.position, telemetry, now_s)
        if telemetry.mode_name == _HOLD_NAME:
            ignored = frozenset({mavlink.MAV_RESULT_UNSUPPORTED})
            message = reposition(command, target, changes_mode=False)
        else:
            message, ignored = reposition(command, target), frozenset()
        needs_answer = evidence.is_shown_before
        return [Step("goto", message, evidence, REPEAT_S, needs_answer=needs_answer, ignored_results=ignored)]

    def stop(self, target: Target, now_s: float) -> Step:
        """See the base class.

        On its way to one of our positions PX4 is in its Hold mode already, and entering it again would not stop it. A
        reposition to "here", NaN in every coordinate, does, from every other mode too. That it does not move proves
        nothing before it has had the time to follow a goto, whose acknowledgement looks the same.
        """
        nan = math.nan
        flags = float(mavlink.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE)
        message = command_long(target, mavlink.MAV_CMD_DO_REPOSITION, -1.0, flags, 0.0, nan, nan, nan, nan)
        settled_at_s = now_s + _SETTLING_S

        def is_done(state: Telemetry, _now_s: float) -> bool:
            is_recent = state.position_at_s is not None and state.position_at_s >= settled_at_s
            return is_recent and state.mode is FlightMode.HOLD and _is_slow(state)

        return Step("hold", message, is_done, _STOP_REPEAT_S)

    def takeoff(self, height_above_home_m: AboveHomeM, target: Target, home: GeodeticPosition) -> CommandMessage:
        """See the base class. PX4 takes every altitude above mean sea level; NaN stands for "here"."""
        altitude_amsl_m = home.altitude_amsl_m + height_above_home_m
        nan = math.nan
        return command_long(target, mavlink.MAV_CMD_NAV_TAKEOFF, 0.0, 0.0, 0.0, nan, nan, nan, altitude_amsl_m)


def _is_slow(telemetry: Telemetry) -> bool:
    velocity_enu_mps = telemetry.velocity_enu_mps
    return velocity_enu_mps is not None and math.hypot(*velocity_enu_mps) <= STOPPED_MPS
