"""Base of the simulated autopilots, without I/O: messages and time in, messages and set-points out.

Each flavour is a subclass that states its modes, parameters and rules. The behaviour follows what ArduCopter 4.7 and
PX4 1.16 were measured to do in software-in-the-loop runs.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import ClassVar

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_sim.clock import SimTime
from aos_sim.vehicle.battery import Battery
from aos_sim.vehicle.commands import CommandRequest, Refusal
from aos_sim.vehicle.configuration import VehicleIdentity
from aos_sim.vehicle.fence import Fence
from aos_sim.vehicle.fence_service import FenceService
from aos_sim.vehicle.file_transfer import refusal
from aos_sim.vehicle.flight import FlightController, FlightEvent, FlightSettings, Manoeuvre, Setpoint
from aos_sim.vehicle.kinematics import Kinematics
from aos_sim.vehicle.parameter_service import ParameterService
from aos_sim.vehicle.parameters import Parameter, ParameterEncoding, ParameterTable
from aos_sim.vehicle.streams import StreamSchedule
from aos_sim.vehicle.telemetry import MessageBuilder, Readings, autopilot_version

FORCE_MAGIC = 21196
"""Second parameter of an arm or disarm command that overrides the checks."""

SECOND_US = 1_000_000

VERSION = mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION

FENCE_TICKS = 10
"""Interval of the fence checks."""

LANDED_STATES: Mapping[Manoeuvre, int] = {
    Manoeuvre.GROUNDED: mavlink.MAV_LANDED_STATE_ON_GROUND,
    Manoeuvre.TAKEOFF: mavlink.MAV_LANDED_STATE_TAKEOFF,
    Manoeuvre.LAND: mavlink.MAV_LANDED_STATE_LANDING,
}


class SimulatedAutopilot(ABC):
    """One vehicle's autopilot, component 1.

    Call :meth:`handle` for each message that arrives and :meth:`update` once per tick, then take what is to be sent
    from :meth:`drain` and what is to be flown from :attr:`setpoint`.

    Raises:
        ConfigurationError: a parameter in the identity does not exist.
    """

    MAV_AUTOPILOT: ClassVar[int]
    PARAMETERS: ClassVar[tuple[Parameter, ...]]
    FACTORY: ClassVar[Mapping[str, float]]
    """The manufacturer's values where ``PARAMETERS`` has a careful operator's."""
    ENCODING: ClassVar[ParameterEncoding]
    MESSAGES: ClassVar[Mapping[int, MessageBuilder]]
    DEFAULT_INTERVALS_US: ClassVar[Mapping[int, int]]
    CAPABILITIES: ClassVar[int]
    FLIGHT_SW_VERSION: ClassVar[int]
    USUAL_START_UP_S: ClassVar[float]
    ACCEPTS_BROADCAST: ClassVar[bool]
    """Whether commands to system 0 count as addressed to this vehicle."""

    def __init__(self, identity: VehicleIdentity, kinematics: Kinematics) -> None:
        self.identity = identity
        self.parameters = ParameterTable(self.PARAMETERS)
        self.parameters.override(identity.parameters)
        self.battery = Battery(self.battery_capacity_mah())
        self.flight = FlightController(self.flight_settings(), kinematics)
        self.kinematics = kinematics
        self.now = SimTime(0)
        self.operator_heard_s: float | None = None
        self._outbox: list[mavlink.MAVLink_message] = []
        self._streams = StreamSchedule(
            {mavlink.MAVLINK_MSG_ID_HEARTBEAT: SECOND_US, **self.DEFAULT_INTERVALS_US}, phase_ticks=identity.system_id
        )
        self._parameter_service = ParameterService(self.parameters, self.ENCODING, self.send, self._on_parameter_set)
        self.fence_service = FenceService(identity.frame, self.send)
        self._position_announced = False
        self._breached = False
        self._handlers: dict[str, Callable[[mavlink.MAVLink_message], None]] = {
            "HEARTBEAT": self.on_heartbeat,
            "COMMAND_LONG": self._on_command,
            "COMMAND_INT": self._on_command,
            "SET_MODE": self._on_set_mode,
            "PARAM_REQUEST_LIST": self._parameter_service.on_request_list,
            "PARAM_REQUEST_READ": self._parameter_service.on_request_read,
            "PARAM_SET": self._parameter_service.on_set,
            "MISSION_REQUEST_LIST": self.fence_service.on_request_list,
            "MISSION_REQUEST_INT": self.fence_service.on_request,
            "MISSION_COUNT": lambda message: self.fence_service.on_count(message, self.now.s),
            "MISSION_ITEM_INT": lambda message: self.fence_service.on_item(message, self.now.s),
            "MISSION_CLEAR_ALL": lambda message: self.fence_service.on_clear(message, self.now.s),
            "FILE_TRANSFER_PROTOCOL": lambda message: self.send(refusal(message)),
            "TIMESYNC": self._on_timesync,
        }
        self._commands: dict[int, Callable[[CommandRequest], int]] = {
            mavlink.MAV_CMD_COMPONENT_ARM_DISARM: self._arm_or_disarm,
            mavlink.MAV_CMD_NAV_TAKEOFF: self.take_off,
            mavlink.MAV_CMD_NAV_LAND: lambda _: self.select_mode(self.land_mode()),
            mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH: lambda _: self.select_mode(self.return_mode()),
            mavlink.MAV_CMD_DO_REPOSITION: self.reposition,
            mavlink.MAV_CMD_DO_SET_MODE: lambda request: self.select_mode(self.requested_mode(request)),
            mavlink.MAV_CMD_DO_CHANGE_SPEED: self._change_speed,
            mavlink.MAV_CMD_SET_MESSAGE_INTERVAL: self._set_message_interval,
            mavlink.MAV_CMD_GET_MESSAGE_INTERVAL: self._get_message_interval,
            mavlink.MAV_CMD_REQUEST_MESSAGE: self._request_message,
            mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: lambda _: self._send_now(VERSION),
            mavlink.MAV_CMD_GET_HOME_POSITION: lambda _: self._send_now(mavlink.MAVLINK_MSG_ID_HOME_POSITION),
        }

    # --- what a flavour states -------------------------------------------------------------------------------------

    @abstractmethod
    def flight_settings(self) -> FlightSettings:
        """Return the flight settings that the parameters say."""

    @abstractmethod
    def battery_capacity_mah(self) -> float:
        """Return the battery's capacity that the parameters say."""

    @abstractmethod
    def fence(self) -> Fence:
        """Return the fence that the parameters say."""

    @abstractmethod
    def on_breach(self, limit: str) -> None:
        """Act on having left the fence, once each time."""

    @abstractmethod
    def base_mode(self) -> int:
        """Return the heartbeat's base mode without the armed flag."""

    @abstractmethod
    def custom_mode(self) -> int:
        """Return the heartbeat's custom mode."""

    @abstractmethod
    def requested_mode(self, request: CommandRequest) -> int:
        """Return the custom mode that a DO_SET_MODE asks for."""

    @abstractmethod
    def select_mode(self, custom_mode: int) -> int:
        """Change the mode and begin its manoeuvre; return a MAV_RESULT."""

    @abstractmethod
    def land_mode(self) -> int:
        """Return the custom mode that lands."""

    @abstractmethod
    def return_mode(self) -> int:
        """Return the custom mode that returns home."""

    @abstractmethod
    def not_ready(self) -> Refusal | None:
        """Return what the pre-arm checks find wrong, whatever the mode."""

    @abstractmethod
    def mode_not_armable(self) -> Refusal | None:
        """Return why the vehicle cannot be armed in its present mode."""

    @abstractmethod
    def refuse_arming(self, refusal: Refusal) -> int:
        """Tell why arming was refused; return a MAV_RESULT."""

    @abstractmethod
    def take_off(self, request: CommandRequest) -> int:
        """Carry out NAV_TAKEOFF; return a MAV_RESULT."""

    @abstractmethod
    def reposition(self, request: CommandRequest) -> int:
        """Carry out DO_REPOSITION; return a MAV_RESULT."""

    @abstractmethod
    def on_heartbeat(self, message: mavlink.MAVLink_message) -> None:
        """Note that somebody is there."""

    @abstractmethod
    def in_failsafe(self) -> bool:
        """Return whether the heartbeat reports a failsafe (MAV_STATE_CRITICAL)."""

    @abstractmethod
    def check_failsafes(self) -> None:
        """Act on a lost link or a low battery."""

    # --- in and out --------------------------------------------------------------------------------------------------

    @property
    def setpoint(self) -> Setpoint:
        """Set-point for the dynamics."""
        return self.flight.setpoint

    @property
    def position_known(self) -> bool:
        """Whether the estimator has a position."""
        start_up_s = self.identity.start_up_s
        return self.now.s >= (self.USUAL_START_UP_S if start_up_s is None else start_up_s)

    def handle(self, message: mavlink.MAVLink_message, kinematics: Kinematics, now: SimTime) -> None:
        """Take in a message that is addressed to this vehicle's autopilot."""
        self.kinematics, self.now = kinematics, now
        handler = self._handlers.get(message.get_type())
        if handler is not None:
            handler(message)

    def update(self, kinematics: Kinematics, now: SimTime) -> None:
        """Advance to ``now``, at least one tick later than before."""
        duration_s = now.s - self.now.s
        self.kinematics, self.now = kinematics, now
        self.battery.drain(self.flight.armed, self.flight.airborne, duration_s)
        if self.position_known and not self._position_announced:
            self._position_announced = True
            self.send(self._build(mavlink.MAVLINK_MSG_ID_HOME_POSITION))
        if self.flight.armed:
            self.check_failsafes()
            if now.tick % FENCE_TICKS == 0:
                self._check_fence()
        self.fence_service.update(now.s)
        for event in self.flight.update(kinematics, now.s):
            self.on_flight_event(event)
        for message_id in self._streams.due(now.tick):
            self.send(self._build(message_id))
        self._parameter_service.send_some()

    def drain(self) -> list[mavlink.MAVLink_message]:
        """Return the messages to be sent and forget them."""
        messages, self._outbox = self._outbox, []
        return messages

    def send(self, message: mavlink.MAVLink_message) -> None:
        """Put a message out."""
        self._outbox.append(message)

    def tell(self, severity: int, text: str) -> None:
        """Put out a STATUSTEXT."""
        self.send(mavlink.MAVLink_statustext_message(severity, text.encode()[:50]))

    def on_flight_event(self, event: FlightEvent) -> None:
        """React to what the flight controller did by itself."""
        if event is FlightEvent.DISARMED:
            self.tell(mavlink.MAV_SEVERITY_INFO, "Disarming motors")

    def acknowledge(self, request: CommandRequest, result: int) -> None:
        """Put out a COMMAND_ACK."""
        self.send(
            mavlink.MAVLink_command_ack_message(
                request.command, result, 0, 0, request.source_system, request.source_component
            )
        )

    # --- messages ----------------------------------------------------------------------------------------------------

    def _on_command(self, message: mavlink.MAVLink_message) -> None:
        request = CommandRequest.of(message)
        command = self._commands.get(request.command)
        self.acknowledge(request, mavlink.MAV_RESULT_UNSUPPORTED if command is None else command(request))

    def _on_set_mode(self, message: mavlink.MAVLink_message) -> None:
        self.select_mode(message.custom_mode)

    def _check_fence(self) -> None:
        limit = self.fence().breach(self.kinematics.position_enu_m, self.flight.home_enu_m)
        if limit is not None and self.flight.airborne and not self._breached:
            self.on_breach(limit)
        self._breached = limit is not None

    def _on_timesync(self, message: mavlink.MAVLink_message) -> None:
        if message.tc1 == 0:
            self.send(mavlink.MAVLink_timesync_message(tc1=self.now.boot_us * 1000, ts1=message.ts1))

    def _on_parameter_set(self) -> None:
        self.flight.settings = self.flight_settings()

    # --- commands ----------------------------------------------------------------------------------------------------

    def _arm_or_disarm(self, request: CommandRequest) -> int:
        forced = request.param(2) == FORCE_MAGIC
        if request.param(1) > 0.5:
            return self._arm(forced)
        if self.flight.airborne and not forced:
            return self.refuse_arming(Refusal("Disarm: vehicle is in the air"))
        if self.flight.armed:
            self.flight.disarm(self.kinematics, self.now.s)
            self.on_flight_event(FlightEvent.DISARMED)
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _arm(self, forced: bool) -> int:
        if self.flight.armed:
            return int(mavlink.MAV_RESULT_ACCEPTED)
        refusal = self.not_ready() or self.mode_not_armable()
        if refusal is not None and not forced:
            return self.refuse_arming(refusal)
        self.flight.arm(self.kinematics, self.now.s)
        self.tell(mavlink.MAV_SEVERITY_INFO, "Arming motors")
        self.send(self._build(mavlink.MAVLINK_MSG_ID_HOME_POSITION))
        self.on_armed()
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def on_armed(self) -> None:  # noqa: B027 - optional for a flavour
        """React to having been armed."""

    def _change_speed(self, request: CommandRequest) -> int:
        kind, speed_mps = round(request.param(1)), request.param(2)
        if not speed_mps > 0.0:
            return int(mavlink.MAV_RESULT_DENIED)
        match kind:
            case mavlink.SPEED_TYPE_AIRSPEED | mavlink.SPEED_TYPE_GROUNDSPEED:
                self.flight.change_speed(speed_mps=speed_mps)
            case mavlink.SPEED_TYPE_CLIMB_SPEED:
                self.flight.change_speed(climb_mps=speed_mps)
            case mavlink.SPEED_TYPE_DESCENT_SPEED:
                self.flight.change_speed(descent_mps=speed_mps)
            case _:
                return int(mavlink.MAV_RESULT_DENIED)
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _set_message_interval(self, request: CommandRequest) -> int:
        message_id = round(request.param(1))
        if message_id != mavlink.MAVLINK_MSG_ID_HEARTBEAT and message_id not in self.MESSAGES:
            return int(mavlink.MAV_RESULT_FAILED)
        self.set_interval(message_id, round(request.param(2)))
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def operator_silence_s(self) -> float:
        """Return the real time, not the simulation's, since the operator's latest heartbeat; infinite before one."""
        heard_s = -math.inf if self.operator_heard_s is None else self.operator_heard_s
        return (self.now.s - heard_s) / self.identity.speed

    def set_interval(self, message_id: int, interval_us: int) -> None:
        """Send a message in this interval; see :meth:`StreamSchedule.set_interval`."""
        self._streams.set_interval(message_id, interval_us, self.now.tick)

    def _get_message_interval(self, request: CommandRequest) -> int:
        message_id = round(request.param(1))
        interval_us = self._streams.interval_us(message_id)
        self.send(mavlink.MAVLink_message_interval_message(message_id, interval_us))
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _request_message(self, request: CommandRequest) -> int:
        return self._send_now(round(request.param(1)))

    def _send_now(self, message_id: int) -> int:
        one_off = (mavlink.MAVLINK_MSG_ID_HEARTBEAT, VERSION)
        if message_id not in self.MESSAGES and message_id not in one_off:
            return int(mavlink.MAV_RESULT_FAILED)
        if message_id == mavlink.MAVLINK_MSG_ID_HOME_POSITION and not self.position_known:
            return int(mavlink.MAV_RESULT_FAILED)
        self.send(self._build(message_id))
        return int(mavlink.MAV_RESULT_ACCEPTED)

    # --- telemetry ---------------------------------------------------------------------------------------------------

    def _build(self, message_id: int) -> mavlink.MAVLink_message:
        if message_id == mavlink.MAVLINK_MSG_ID_HEARTBEAT:
            return self._heartbeat()
        if message_id == VERSION:
            return autopilot_version(self.CAPABILITIES, self.FLIGHT_SW_VERSION, self.identity.uid)
        return self.MESSAGES[message_id](self._readings())

    def _heartbeat(self) -> mavlink.MAVLink_message:
        armed = self.flight.armed
        usual_status = mavlink.MAV_STATE_ACTIVE if armed else mavlink.MAV_STATE_STANDBY
        return mavlink.MAVLink_heartbeat_message(
            type=mavlink.MAV_TYPE_QUADROTOR,
            autopilot=self.MAV_AUTOPILOT,
            base_mode=self.base_mode() | (mavlink.MAV_MODE_FLAG_SAFETY_ARMED if armed else 0),
            custom_mode=self.custom_mode(),
            system_status=mavlink.MAV_STATE_CRITICAL if armed and self.in_failsafe() else usual_status,
            mavlink_version=3,
        )

    def _readings(self) -> Readings:
        flight, battery = self.flight, self.battery
        return Readings(
            now=self.now,
            kinematics=self.kinematics,
            home_enu_m=flight.home_enu_m,
            target_enu_m=flight.target_enu_m,
            frame=self.identity.frame,
            airborne=flight.airborne,
            landed_state=LANDED_STATES.get(flight.manoeuvre, mavlink.MAV_LANDED_STATE_IN_AIR),
            ready_to_arm=self.not_ready() is None,
            position_known=self.position_known,
            fence_breached=self._breached,
            voltage_v=battery.voltage_v,
            current_a=battery.current_a,
            consumed_mah=battery.consumed_mah,
            remaining=battery.remaining,
        )
