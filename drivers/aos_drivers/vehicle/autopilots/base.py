"""Interface of the autopilots' dialects, and what the dialects of multicopters share."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.autopilots.goto import GotoEvidence, check_goto
from aos_drivers.vehicle.autopilots.setup import Setup
from aos_drivers.vehicle.telemetry import Telemetry
from aos_drivers.vehicle.transaction import CommandMessage
from aos_gcs.errors import CommandRefusedError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AboveHomeM
from aos_gcs.ports import (
    Arm,
    Command,
    Disarm,
    FlightMode,
    Goto,
    Hold,
    Land,
    LandedState,
    ReturnToLaunch,
    Takeoff,
)

HEIGHT_TOLERANCE_M = 1.0
_LONGEST_ROUND_TRIP_S = 1.0
"""Longest round trip that is waited for: without answers to requests none is known; later messages are dated."""
REPEAT_S = 2.0
"""An accepted goto or mode is sent again while telemetry does not show it: the answer may have been to an older one."""
_FRESH_S = 3.0
_LANDED_M = 5.0
"""Height above home from which a vehicle that has flown is not disarmed: detectors of landings are wrong at times, and
those that land on higher ground stop their motors by themselves."""
_MODE_OF: Mapping[type[Command], FlightMode] = {
    ReturnToLaunch: FlightMode.RETURN,
    Land: FlightMode.LAND,
}


@dataclass(frozen=True, slots=True)
class Target:
    """The component that commands go to."""

    system_id: int
    component_id: int


@dataclass(frozen=True, slots=True)
class Step:
    """One command message and how telemetry shows its effect."""

    name: str
    """Name in messages to the user: "enter GUIDED"."""
    message: CommandMessage
    is_done: Callable[[Telemetry, float], bool]
    """Whether the effect shows; called repeatedly with the telemetry and the time."""
    repeat_s: float = math.inf
    """Time after the acceptance at which the command is sent again, while not done."""
    needs_acceptance: bool = False
    """Whether what telemetry shows counts only once the command has been accepted."""
    needs_answer: bool = False
    """Whether what telemetry shows counts only once the command has been accepted, or answered by an ignored result."""
    ignored_results: frozenset[int] = frozenset()
    """Answers that say nothing of whether the vehicle obeys."""
    is_optional: bool = False
    """Whether the command goes on where this step is refused, or not answered in time."""


class AutopilotDialect(ABC):
    """Modes, commands and message rates of one autopilot. Stateless: one instance serves all its vehicles."""

    name: ClassVar[str]
    shutter_report_id: ClassVar[int] = mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED
    """Message that reports an image of the autopilot's own camera."""
    modes_by_command: ClassVar[Mapping[type[Command], frozenset[str]]] = MappingProxyType({})
    """Modes, by the autopilot's own names, that each command leads to."""
    modes_after_takeoff: ClassVar[frozenset[str]] = frozenset()
    """Modes that the autopilot enters by itself at the top of a take-off; below, only a pilot does."""
    modes_with_target: ClassVar[frozenset[FlightMode]] = frozenset()
    """Modes in which it sends POSITION_TARGET_LOCAL_NED all the time, unless it flies an attitude."""
    quiet_message_ids: ClassVar[tuple[int, ...]] = ()
    """Unneeded streams that are on by default."""

    @property
    def stock_stream_ids(self) -> tuple[int, ...]:
        """Streams that are on by default, many times a second: a link is full of them until all are slowed down."""
        if not self.quiet_message_ids:
            return ()
        return mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT, mavlink.MAVLINK_MSG_ID_ATTITUDE, *self.quiet_message_ids

    setup: ClassVar[Setup | None] = None
    """Meaning of the parameters; None if unknown."""

    @abstractmethod
    def mode(self, heartbeat: mavlink.MAVLink_heartbeat_message) -> tuple[FlightMode, str]:
        """Return the mode across autopilots and the autopilot's own name of it."""

    def our_modes(self) -> frozenset[str]:
        """Return all modes that commands lead to; every other one was chosen by a pilot, or by the autopilot itself."""
        return frozenset().union(*self.modes_by_command.values())

    @abstractmethod
    def is_ready(self, telemetry: Telemetry, now_s: float) -> bool | None:
        """Return whether arming is possible; None while the autopilot has not said."""

    def estimator_problem(self, telemetry: Telemetry) -> str:
        """Return what is wrong with the estimated position, as a clause; empty while nothing is known to be."""
        del telemetry
        return ""

    @abstractmethod
    def steps(self, command: Command, target: Target, telemetry: Telemetry, now_s: float) -> list[Step]:
        """Return the steps to send, in order.

        Raises:
            CommandRefusedError: the command must not be sent.
        """

    def shutter_command(self, target: Target) -> CommandMessage:
        """Return the command that takes one image with the autopilot's own camera."""
        return command_long(target, mavlink.MAV_CMD_IMAGE_START_CAPTURE, 0.0, 0.0, 1.0)

    def stream_rates_hz(self, position_hz: float) -> Mapping[int, float]:
        """Return the wanted rate of each message, in the order of the requests; 0 switches one off.

        Messages that autopilots send many times a second by default come first: until they are slowed down or switched
        off, they fill a slow link.
        """
        fast = {mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: position_hz, mavlink.MAVLINK_MSG_ID_ATTITUDE: 1.0}
        others = {
            mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT: 2.0,
            mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: 2.0,
            mavlink.MAVLINK_MSG_ID_SYS_STATUS: 1.0,
            mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: 1.0,
            mavlink.MAVLINK_MSG_ID_SCALED_PRESSURE: 1.0,
            mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: 1.0,
        }
        return fast | dict.fromkeys(self.quiet_message_ids, 0.0) | others


def deviation(telemetry: Telemetry) -> str:
    """Return how far the estimated position is from the sensors; empty while the filter accepts them."""
    ratio = telemetry.horizontal_test_ratio
    return f"its position deviates from its sensors ({ratio:.1f} of 1.0)" if ratio is not None and ratio >= 1.0 else ""


def has_position_and_home(telemetry: Telemetry, now_s: float) -> bool:
    """Whether home is known and a 3D fix gives fresh positions."""
    return (
        telemetry.home is not None
        and telemetry.gps_fix is not None
        and telemetry.gps_fix >= mavlink.GPS_FIX_TYPE_3D_FIX
        and _is_fresh(telemetry.position_at_s, now_s)
    )


class MulticopterDialect(AutopilotDialect):
    """Commands that PX4 and ArduCopter share."""

    arming_mode: ClassVar[FlightMode]
    """Mode in which the vehicle is armed."""

    @abstractmethod
    def set_mode(self, mode: FlightMode, target: Target) -> Step:
        """Return the step that enters one of GUIDED, HOLD, RETURN and LAND."""

    def stop(self, target: Target, now_s: float) -> Step:
        """Return the step that stops the vehicle and has it hold its position."""
        del now_s
        return self.set_mode(FlightMode.HOLD, target)

    def goto(self, command: Goto, target: Target, telemetry: Telemetry, now_s: float) -> list[Step]:
        """Return the steps that make the vehicle fly to a position; its mode is known where the waypoint changes it."""
        evidence = GotoEvidence(command.position, telemetry, now_s)
        return [Step("goto", reposition(command, target), evidence, REPEAT_S)]

    @abstractmethod
    def takeoff(self, height_above_home_m: AboveHomeM, target: Target, home: GeodeticPosition) -> CommandMessage:
        """Return the command that climbs to a height above home."""

    def steps(self, command: Command, target: Target, telemetry: Telemetry, now_s: float) -> list[Step]:
        """See the base class."""
        match command:
            case Arm():
                return [*([] if telemetry.armed else self._enter(self.arming_mode, target, telemetry)), _arm(target)]
            case Disarm():
                return [_disarm(target, telemetry, now_s)]
            case Takeoff(height_above_home_m):
                return self._takeoff_steps(height_above_home_m, target, telemetry)
            case Goto():
                check_goto(command, target.system_id, telemetry)
                return self.goto(command, target, telemetry, now_s)
            case Hold():
                return [self.stop(target, now_s)]
            case ReturnToLaunch() | Land():
                return [self.set_mode(_MODE_OF[type(command)], target)]

    def _enter(self, mode: FlightMode, target: Target, telemetry: Telemetry) -> list[Step]:
        return [] if telemetry.mode is mode else [self.set_mode(mode, target)]

    def _takeoff_steps(self, height_above_home_m: AboveHomeM, target: Target, telemetry: Telemetry) -> list[Step]:
        if not math.isfinite(height_above_home_m) or height_above_home_m <= 0:
            raise CommandRefusedError(
                f"a takeoff height of {height_above_home_m} m is impossible: choose one above home"
            )
        if not telemetry.armed:
            raise CommandRefusedError(f"vehicle {target.system_id} is not armed: arm it before takeoff")
        if telemetry.home is None:
            raise CommandRefusedError(f"vehicle {target.system_id} has no home position yet: wait for its GPS")

        def is_done(state: Telemetry, _now_s: float) -> bool:
            height_m = state.height_above_home_m
            return height_m is not None and abs(height_m - height_above_home_m) <= HEIGHT_TOLERANCE_M

        message = self.takeoff(height_above_home_m, target, telemetry.home)
        climb = Step(f"take off to {height_above_home_m:.1f} m", message, is_done)
        return [*self._enter(self.arming_mode, target, telemetry), climb]


def ask_mode(target: Target, now_s: float) -> Step:
    """Return the step that waits for a heartbeat: a change of mode would overrule a pilot who took over since the last.

    One that comes sooner than an answer can may have been sent before the pilot's change. Heartbeats come once a second
    where the request is not understood.
    """

    def is_done(state: Telemetry, _now_s: float) -> bool:
        earliest_s = now_s + min(state.round_trip_s, _LONGEST_ROUND_TRIP_S)
        return state.heartbeat_at_s is not None and state.heartbeat_at_s > earliest_s

    message = command_long(target, mavlink.MAV_CMD_REQUEST_MESSAGE, float(mavlink.MAVLINK_MSG_ID_HEARTBEAT))
    ignored = frozenset(mavlink.enums["MAV_RESULT"]) - {mavlink.MAV_RESULT_ACCEPTED}
    return Step("report its mode", message, is_done, REPEAT_S, ignored_results=ignored)


def command_long(target: Target, command: int, *params: float) -> mavlink.MAVLink_command_long_message:
    """Return a COMMAND_LONG; parameters not given are 0."""
    values = [*params, *[0.0] * (7 - len(params))]
    return mavlink.MAVLink_command_long_message(target.system_id, target.component_id, command, 0, *values)


def version_request(target: Target) -> mavlink.MAVLink_command_long_message:
    """Return the request for version and identity of the board."""
    return command_long(target, mavlink.MAV_CMD_REQUEST_MESSAGE, float(mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION))


def reposition(command: Goto, target: Target, *, changes_mode: bool = True) -> mavlink.MAVLink_command_int_message:
    """Return the DO_REPOSITION that PX4 and ArduCopter understand alike, above mean sea level.

    The heading, in radians whatever the unit of MAVLink's definition, is PX4's; ArduCopter does not look at it.
    """
    position = command.position
    return mavlink.MAVLink_command_int_message(
        target.system_id,
        target.component_id,
        mavlink.MAV_FRAME_GLOBAL_INT,
        mavlink.MAV_CMD_DO_REPOSITION,
        0,
        0,
        command.speed_mps,
        mavlink.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE if changes_mode else 0,
        0.0,
        math.nan if command.heading_rad is None else command.heading_rad,  # NaN: by the autopilot's own rule
        round(position.latitude_deg * 1e7),
        round(position.longitude_deg * 1e7),
        position.altitude_amsl_m,
    )


def _is_fresh(at_s: float | None, now_s: float) -> bool:
    return at_s is not None and now_s - at_s <= _FRESH_S


def _arm(target: Target) -> Step:
    message = command_long(target, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)
    return Step("arm", message, lambda state, _now_s: state.armed)


def _disarm(target: Target, telemetry: Telemetry, now_s: float) -> Step:
    if telemetry.landed is not LandedState.ON_GROUND or not _is_fresh(telemetry.landed_at_s, now_s):
        raise CommandRefusedError(
            f"vehicle {target.system_id} does not report that it is on the ground: land it before disarming"
        )
    height_m = telemetry.height_above_home_m
    if telemetry.has_flown and height_m is not None and height_m > _LANDED_M:
        raise CommandRefusedError(
            f"vehicle {target.system_id} reports that it is on the ground, {height_m:.0f} m above its home: "
            "its motors are stopped by its autopilot or its pilot alone"
        )
    message = command_long(target, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0.0)
    return Step("disarm", message, lambda state, _now_s: not state.armed)
