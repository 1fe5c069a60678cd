"""The rules of PX4's multicopters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import ClassVar

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.heights import AboveHomeM, AmslM
from aos_sim.vehicle.autopilot import SECOND_US, SimulatedAutopilot
from aos_sim.vehicle.commands import CommandRequest, Refusal
from aos_sim.vehicle.configuration import VehicleIdentity
from aos_sim.vehicle.fence import Fence
from aos_sim.vehicle.flight import FlightEvent, FlightSettings
from aos_sim.vehicle.kinematics import Kinematics
from aos_sim.vehicle.parameters import Parameter, ParameterEncoding, ParameterType
from aos_sim.vehicle.px4_modes import (
    MODES_NOT_ARMABLE,
    OFFBOARD_LOSS_MODES,
    PILOT_MODES,
    Px4Mode,
    custom_mode_of,
    mode_name,
)
from aos_sim.vehicle.targets import Surroundings, TargetRequest, UnsupportedTargetError, px4_motion
from aos_sim.vehicle.telemetry import COMMON_MESSAGES, SENSORS, MessageBuilder, estimator_status, sys_status
from aos_sim.vehicle.true_state import hil_state_quaternion

INT32 = ParameterType.INT32

LINK_LOSS_RETURN = 2
LINK_LOSS_EXCEPT_HOLD = 2
"""Bit of COM_DLL_EXCEPT."""
BATTERY_RETURN = 3


class Px4(SimulatedAutopilot):
    """PX4 as a careful operator sets it up for a swarm: the failsafe for a lost ground station is on."""

    MAV_AUTOPILOT = mavlink.MAV_AUTOPILOT_PX4
    ENCODING = ParameterEncoding.BYTEWISE
    FLIGHT_SW_VERSION = 0x011000FF
    USUAL_START_UP_S = 5.0
    ACCEPTS_BROADCAST = False
    CAPABILITIES = (
        mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
        | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_INT
        | mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
        | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
        | mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    )
    MESSAGES: ClassVar[Mapping[int, MessageBuilder]] = {
        **COMMON_MESSAGES,
        mavlink.MAVLINK_MSG_ID_SYS_STATUS: partial(sys_status, present=SENSORS & ~mavlink.MAV_SYS_STATUS_PREARM_CHECK),
        mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS: estimator_status,
        mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION: hil_state_quaternion,
    }
    DEFAULT_INTERVALS_US: ClassVar[Mapping[int, int]] = {
        mavlink.MAVLINK_MSG_ID_SYS_STATUS: SECOND_US,
        mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: SECOND_US,
        mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: SECOND_US // 10,
        mavlink.MAVLINK_MSG_ID_ATTITUDE: SECOND_US // 50,
        mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: SECOND_US // 50,
        mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: SECOND_US // 50,
        mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: SECOND_US // 50,
        mavlink.MAVLINK_MSG_ID_VFR_HUD: SECOND_US // 10,
        mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT: SECOND_US // 10,
        mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: SECOND_US,
        mavlink.MAVLINK_MSG_ID_HOME_POSITION: 2 * SECOND_US,
        mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: SECOND_US // 2,
        mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS: SECOND_US,
    }
    PARAMETERS: ClassVar[tuple[Parameter, ...]] = (
        Parameter("MAV_SYS_ID", 1, INT32),
        Parameter("NAV_DLL_ACT", LINK_LOSS_RETURN, INT32),
        Parameter("COM_DL_LOSS_T", 10, INT32),
        Parameter("COM_DLL_EXCEPT", 0, INT32),
        Parameter("COM_FAIL_ACT_T", 5.0),
        Parameter("COM_OF_LOSS_T", 1.0),
        Parameter("COM_OBL_RC_ACT", 0, INT32),
        Parameter("COM_DISARM_LAND", 2.0),
        Parameter("COM_DISARM_PRFLT", 10.0),
        Parameter("COM_LOW_BAT_ACT", BATTERY_RETURN, INT32),
        Parameter("BAT_CRIT_THR", 0.15),
        Parameter("BAT1_CAPACITY", 10000.0),
        Parameter("GF_ACTION", 2, INT32),
        Parameter("GF_MAX_HOR_DIST", 500.0),
        Parameter("GF_MAX_VER_DIST", 120.0),
        Parameter("NAV_RCL_ACT", 2, INT32),
        Parameter("RTL_TYPE", 0, INT32),
        Parameter("RTL_RETURN_ALT", 30.0),
        Parameter("RTL_LAND_DELAY", 0.0),
        Parameter("MIS_TAKEOFF_ALT", 2.5),
        Parameter("MPC_XY_CRUISE", 10.0),
        Parameter("MPC_XY_VEL_MAX", 12.0),
        Parameter("MPC_ACC_HOR", 3.5),
        Parameter("MPC_Z_VEL_MAX_UP", 3.0),
        Parameter("MPC_Z_VEL_MAX_DN", 1.5),
        Parameter("MPC_LAND_SPEED", 0.7),
        Parameter("MPC_LAND_ALT2", 5.0),
        Parameter("CAL_GYRO0_ID", 1310988, INT32),
        Parameter("CAL_ACC0_ID", 1310988, INT32),
        Parameter("CAL_MAG0_ID", 197388, INT32),
        Parameter("SYS_HITL", 0, INT32),
    )
    FACTORY: ClassVar[Mapping[str, float]] = {
        "NAV_DLL_ACT": 0,
        "COM_LOW_BAT_ACT": 0,
        "GF_MAX_HOR_DIST": 0,
        "GF_MAX_VER_DIST": 0,
        "RTL_RETURN_ALT": 60,
    }

    def __init__(self, identity: VehicleIdentity, kinematics: Kinematics) -> None:
        super().__init__(identity, kinematics)
        self.parameters["MAV_SYS_ID"] = identity.system_id
        self._handlers["SET_POSITION_TARGET_LOCAL_NED"] = self._on_target
        self._handlers["SET_POSITION_TARGET_GLOBAL_INT"] = self._on_target
        self._commands[mavlink.MAV_CMD_MISSION_START] = self._start_mission
        self._target_at_s = -math.inf
        """Time of the latest target for OFFBOARD."""
        self._mode = Px4Mode.HOLD
        self._causes: frozenset[str] = frozenset()
        """Causes of failsafes, in the words of the status text."""
        self._failsafe_at_s: float | None = None
        self._user_took_over = False

    def flight_settings(self) -> FlightSettings:
        """Return the flight settings that the parameters say."""
        value = self.parameters
        return FlightSettings(
            speed_mps=value["MPC_XY_CRUISE"],
            climb_mps=value["MPC_Z_VEL_MAX_UP"],
            descent_mps=value["MPC_Z_VEL_MAX_DN"],
            land_speed_mps=value["MPC_LAND_SPEED"],
            land_slow_below_m=value["MPC_LAND_ALT2"],
            return_height_m=value["RTL_RETURN_ALT"],
            return_climb_m=0.0,
            return_loiter_s=max(0.0, value["RTL_LAND_DELAY"]),
            disarm_landed_s=value["COM_DISARM_LAND"],
            # As the patience with the link: a fast simulation gives the operator as much real time.
            disarm_idle_s=value["COM_DISARM_PRFLT"] * self.identity.speed,
            face_target=False,
        )

    def battery_capacity_mah(self) -> float:
        """Return the battery's capacity that the parameters say."""
        return self.parameters["BAT1_CAPACITY"]

    def fence(self) -> Fence:
        """Return the fence that the parameters say; 0 switches a limit off."""
        value = self.parameters
        if not value["GF_ACTION"]:
            return Fence()
        return self.fence_service.polygons(value["GF_MAX_HOR_DIST"] or math.inf, value["GF_MAX_VER_DIST"] or math.inf)

    def on_breach(self, limit: str) -> None:
        """Tell, and do what GF_ACTION says."""
        self.tell(mavlink.MAV_SEVERITY_CRITICAL, f"Geofence violation: {limit}")
        mode = {2: Px4Mode.HOLD, 3: Px4Mode.RETURN, 5: Px4Mode.LAND}.get(int(self.parameters["GF_ACTION"]))
        if mode is Px4Mode.HOLD:
            self._pause()
        elif mode is not None:
            self._enter(mode)

    def base_mode(self) -> int:
        """Return the heartbeat's base mode without the armed flag."""
        flags = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | mavlink.MAV_MODE_FLAG_STABILIZE_ENABLED
        if self._mode in PILOT_MODES:
            return int(flags | mavlink.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED)
        return int(flags | mavlink.MAV_MODE_FLAG_GUIDED_ENABLED | mavlink.MAV_MODE_FLAG_AUTO_ENABLED)

    def custom_mode(self) -> int:
        """Return the heartbeat's custom mode."""
        return int(self._mode)

    def land_mode(self) -> int:
        """Return the custom mode that lands."""
        return Px4Mode.LAND

    def return_mode(self) -> int:
        """Return the custom mode that returns home."""
        return Px4Mode.RETURN

    def requested_mode(self, request: CommandRequest) -> int:
        """Return the custom mode that a DO_SET_MODE asks for: main and sub mode."""
        return custom_mode_of(round(request.param(2)), round(request.param(3)))

    def select_mode(self, custom_mode: int) -> int:
        """Change the mode and begin its manoeuvre.

        Selecting the present mode changes nothing: HOLD does not stop a reposition, which is flown in HOLD already.
        A DO_REPOSITION without a place does.
        """
        has_no_stream = custom_mode == Px4Mode.OFFBOARD and self._offboard_is_lost()
        is_unavailable = custom_mode not in tuple(Px4Mode) or custom_mode == Px4Mode.MISSION or has_no_stream
        if is_unavailable or not self.position_known:
            self.tell(
                mavlink.MAV_SEVERITY_CRITICAL, f"Switching to {mode_name(custom_mode)} is currently not available"
            )
            return int(mavlink.MAV_RESULT_TEMPORARILY_REJECTED)
        self._user_took_over = True
        self._enter(Px4Mode(custom_mode))
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _enter(self, mode: Px4Mode) -> None:
        if mode is not self._mode:
            self._mode = mode
            self._begin_manoeuvre()

    def _begin_manoeuvre(self) -> None:
        if not self.flight.airborne:
            return
        match self._mode:
            case Px4Mode.RETURN:
                self.flight.return_home(self.kinematics, self.now.s)
            case Px4Mode.LAND:
                self.flight.land(self.kinematics, self.now.s)
            case _:
                self.flight.hold(self.kinematics, self.now.s)

    def acknowledge(self, request: CommandRequest, result: int) -> None:
        """Put out a COMMAND_ACK; a mode change is acknowledged by the receiver and then by the commander."""
        if request.command == mavlink.MAV_CMD_DO_SET_MODE:
            super().acknowledge(request, mavlink.MAV_RESULT_ACCEPTED)
        super().acknowledge(request, result)

    def tell(self, severity: int, text: str) -> None:
        """Put out a STATUSTEXT, once a ground station has been heard."""
        if self.operator_heard_s is not None:
            super().tell(severity, text)

    def mode_not_armable(self) -> Refusal | None:
        """Return why the vehicle cannot be armed in its present mode."""
        return Refusal("Arming denied: switch to another mode first") if self._mode in MODES_NOT_ARMABLE else None

    def not_ready(self) -> Refusal | None:
        """Return what the pre-arm checks find wrong, whatever the mode."""
        if not self.position_known:
            return Refusal("Arming denied: system health failures")
        if self.parameters["NAV_DLL_ACT"] and self.operator_silence_s() > self.parameters["COM_DL_LOSS_T"]:
            return Refusal("Arming denied: No connection to the ground station")
        if self._battery_is_critical():
            return Refusal("Arming denied: Low battery level")
        return None

    def refuse_arming(self, refusal: Refusal) -> int:
        """Tell why arming was refused."""
        self.tell(mavlink.MAV_SEVERITY_CRITICAL, refusal.text)
        return int(mavlink.MAV_RESULT_TEMPORARILY_REJECTED)

    def on_armed(self) -> None:
        """Begin a take-off that was asked for before arming."""
        if self._mode is Px4Mode.TAKEOFF:
            self.flight.take_off(AboveHomeM(self.parameters["MIS_TAKEOFF_ALT"]), self.kinematics, self.now.s)

    def take_off(self, request: CommandRequest) -> int:
        """Climb to the altitude above sea level of parameter 7, or by MIS_TAKEOFF_ALT where that is NaN."""
        altitude_amsl_m = request.finite_or_none(7)
        if self.flight.airborne or not self.position_known:
            return int(mavlink.MAV_RESULT_TEMPORARILY_REJECTED)
        self._mode = Px4Mode.TAKEOFF
        if self.flight.armed:
            ground_amsl_m = self.identity.frame.origin.altitude_amsl_m + self.flight.home_enu_m[2]
            least_m = self.parameters["MIS_TAKEOFF_ALT"]
            height_m = least_m if altitude_amsl_m is None else max(least_m, altitude_amsl_m - ground_amsl_m)
            self.flight.take_off(AboveHomeM(height_m), self.kinematics, self.now.s)
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def reposition(self, request: CommandRequest) -> int:
        """Fly to a place in HOLD.

        Parameter 2 must be exactly 1; without it, the command is refused, and flown all the same by who is in HOLD. The
        altitude is above sea level whatever the frame says; NaN keeps the altitude, the heading (parameter 4, radians)
        or the speed, and for the place means "stop here". A place outside the fence is acknowledged all the same: only
        a status text tells.
        """
        changes_mode = request.param(2) == mavlink.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE
        answer = int(mavlink.MAV_RESULT_ACCEPTED if changes_mode else mavlink.MAV_RESULT_UNSUPPORTED)
        if not self.position_known or not (request.place_valid() or request.keeps_place()):
            return int(mavlink.MAV_RESULT_DENIED)
        self._user_took_over = self._user_took_over or changes_mode
        if request.keeps_place():
            return self._pause() if changes_mode else answer
        altitude_m = request.finite_or_none(7)
        altitude_amsl_m = self.kinematics.geodetic.altitude_amsl_m if altitude_m is None else AmslM(altitude_m)
        east_m, north_m, up_m = self.identity.frame.to_enu(request.geodetic(altitude_amsl_m))
        target_enu_m = (float(east_m), float(north_m), float(up_m))
        if self.fence().breach(target_enu_m, self.flight.home_enu_m):
            self.tell(mavlink.MAV_SEVERITY_CRITICAL, "Reposition is outside geofence")
            return answer
        if changes_mode:
            self.select_mode(Px4Mode.HOLD)
        if self.flight.airborne and self._mode is Px4Mode.HOLD:
            speed_mps = request.finite_or_none(1)
            speed_mps = min(speed_mps, self.parameters["MPC_XY_VEL_MAX"]) if speed_mps and speed_mps > 0.0 else None
            heading_rad = request.finite_or_none(4)
            self.flight.fly_to(target_enu_m, self.kinematics, self.now.s, speed_mps, heading_rad)
        return answer

    def _start_mission(self, _: CommandRequest) -> int:
        """Refuse: there never is a mission here."""
        self.tell(mavlink.MAV_SEVERITY_CRITICAL, "Mission start denied! No valid mission")
        return int(mavlink.MAV_RESULT_DENIED)

    def _on_target(self, message: mavlink.MAVLink_message) -> None:
        """Note that a target has come, and fly it in OFFBOARD, without an answer."""
        around = Surroundings.of(self.identity, self.flight.home_enu_m, self.kinematics)
        try:
            motion = px4_motion(TargetRequest.of(message), around)
        except UnsupportedTargetError:
            self.tell(mavlink.MAV_SEVERITY_CRITICAL, f"{message.get_type()} invalid")
            return
        self._target_at_s = self.now.s
        if self._mode is Px4Mode.OFFBOARD and self.flight.armed:
            self.flight.follow(motion, self.kinematics, self.now.s)

    def _offboard_is_lost(self) -> bool:
        return self.now.s - self._target_at_s > self.parameters["COM_OF_LOSS_T"]

    def _pause(self) -> int:
        self._mode = Px4Mode.HOLD
        if self.flight.airborne:
            self.flight.hold(self.kinematics, self.now.s)
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def on_flight_event(self, event: FlightEvent) -> None:
        """Hold after the take-off."""
        super().on_flight_event(event)
        if event is FlightEvent.TAKEOFF_COMPLETE:
            self._mode = Px4Mode.HOLD

    def on_heartbeat(self, message: mavlink.MAVLink_message) -> None:
        """Count the heartbeats of every ground station."""
        if message.type == mavlink.MAV_TYPE_GCS:
            self.operator_heard_s = self.now.s

    def in_failsafe(self) -> bool:
        """Return whether a failsafe acts, or is about to; not once a user has taken over."""
        return self._failsafe_at_s is not None and not self._user_took_over

    def check_failsafes(self) -> None:
        """Hold for COM_FAIL_ACT_T and then return, on a lost link or a critical battery, unless a user takes over.

        A return goes on when its cause has ended. The same cause does not act again before it has ended.
        """
        if self._mode is Px4Mode.OFFBOARD and self._offboard_is_lost():
            self.tell(mavlink.MAV_SEVERITY_CRITICAL, "No offboard signal")
            self._enter(OFFBOARD_LOSS_MODES.get(int(self.parameters["COM_OBL_RC_ACT"]), Px4Mode.POSITION))
        causes = self._failsafe_causes()
        found, self._causes = causes - self._causes, causes
        for cause in found:
            self.tell(mavlink.MAV_SEVERITY_CRITICAL, cause)
        if not causes or not self.flight.airborne:
            self._failsafe_at_s, self._user_took_over = None, False
            return
        if found:
            self._failsafe_at_s, self._user_took_over = self.now.s, False
            if self._mode not in MODES_NOT_ARMABLE:
                delay_s = self.parameters["COM_FAIL_ACT_T"]
                self.tell(mavlink.MAV_SEVERITY_CRITICAL, f"Failsafe activated, entering Hold for {delay_s:.0f} seconds")
                self._pause()
        if self.in_failsafe() and self.now.s - (self._failsafe_at_s or 0.0) >= self.parameters["COM_FAIL_ACT_T"]:
            self._go_home()

    def _failsafe_causes(self) -> frozenset[str]:
        link_lost = self.flight.airborne and self.operator_silence_s() > self.parameters["COM_DL_LOSS_T"]
        is_excepted = self._mode is Px4Mode.HOLD and int(self.parameters["COM_DLL_EXCEPT"]) & LINK_LOSS_EXCEPT_HOLD
        causes = {
            "Connection to ground station lost": link_lost
            and self.parameters["NAV_DLL_ACT"] == LINK_LOSS_RETURN
            and not is_excepted,
            "Battery level critical": self._battery_is_critical(),
        }
        return frozenset(cause for cause, is_active in causes.items() if is_active)

    def _go_home(self) -> None:
        if self._mode not in MODES_NOT_ARMABLE:
            self._enter(Px4Mode.RETURN)

    def _battery_is_critical(self) -> bool:
        act = self.parameters["COM_LOW_BAT_ACT"] == BATTERY_RETURN
        return act and self.battery.remaining < self.parameters["BAT_CRIT_THR"]
