"""The rules of ArduCopter."""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import IntEnum
from typing import ClassVar

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.heights import SEA_LEVEL, AboveHomeM, AmslM
from aos_sim.vehicle.autopilot import SimulatedAutopilot
from aos_sim.vehicle.commands import AMSL_FRAMES, RELATIVE_FRAMES, TERRAIN_FRAMES, CommandRequest, Refusal
from aos_sim.vehicle.configuration import VehicleIdentity
from aos_sim.vehicle.data_streams import requested_intervals_us
from aos_sim.vehicle.fence import Fence
from aos_sim.vehicle.flight import FlightSettings, Manoeuvre
from aos_sim.vehicle.kinematics import Kinematics
from aos_sim.vehicle.parameters import Parameter, ParameterEncoding, ParameterType
from aos_sim.vehicle.targets import Surroundings, TargetRequest, UnsupportedTargetError, copter_motion
from aos_sim.vehicle.telemetry import COMMON_MESSAGES, MessageBuilder, ekf_status_report
from aos_sim.vehicle.true_state import sim_state


class CopterMode(IntEnum):
    """Custom modes of ArduCopter that the simulator knows."""

    STABILIZE = 0
    ALT_HOLD = 2
    AUTO = 3
    GUIDED = 4
    LOITER = 5
    RTL = 6
    LAND = 9
    POSHOLD = 16
    BRAKE = 17


MODES_WITH_POSITION = (CopterMode.GUIDED, CopterMode.LOITER, CopterMode.RTL, CopterMode.POSHOLD, CopterMode.BRAKE)
MODES_NOT_ARMABLE = (CopterMode.RTL, CopterMode.LAND, CopterMode.BRAKE)
MODES_GOING_HOME = (CopterMode.RTL, CopterMode.LAND)

RESULT_UNSUPPORTED_FRAME = 9
"""MAV_RESULT_COMMAND_UNSUPPORTED_MAV_FRAME of the common dialect, which this dialect lacks."""

INT8, INT16, INT32 = ParameterType.INT8, ParameterType.INT16, ParameterType.INT32


class ArduCopter(SimulatedAutopilot):
    """ArduCopter as a careful operator sets it up for a swarm.

    Unlike the factory settings, the failsafe for a lost ground station is on and listens to system ids 254 and 255, the
    return height clears a forest, and the heading is kept so that images stay aligned.
    """

    MAV_AUTOPILOT = mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
    ENCODING = ParameterEncoding.CAST
    FLIGHT_SW_VERSION = 0x04070000
    USUAL_START_UP_S = 12.0
    ACCEPTS_BROADCAST = True
    DEFAULT_INTERVALS_US: ClassVar[Mapping[int, int]] = {}
    CAPABILITIES = (
        mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT
        | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_INT
        | mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
        | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
        | mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    )
    MESSAGES: ClassVar[Mapping[int, MessageBuilder]] = {
        **COMMON_MESSAGES,
        mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT: ekf_status_report,
        mavlink.MAVLINK_MSG_ID_SIM_STATE: sim_state,
    }
    PARAMETERS: ClassVar[tuple[Parameter, ...]] = (
        Parameter("MAV_SYSID", 1, INT16),
        Parameter("MAV_GCS_SYSID", 254, INT16),
        Parameter("MAV_GCS_SYSID_HI", 255, INT16),
        Parameter("FS_GCS_ENABLE", 1, INT8),
        Parameter("FS_GCS_TIMEOUT", 5),
        Parameter("FS_OPTIONS", 0, INT32),
        Parameter("FENCE_ENABLE", 1, INT8),
        Parameter("FENCE_TYPE", 7, INT8),
        Parameter("FENCE_ACTION", 1, INT8),
        Parameter("FENCE_ALT_MAX", 120),
        Parameter("FENCE_RADIUS", 500),
        Parameter("RTL_ALT", 3000, INT32),
        Parameter("RTL_ALT_FINAL", 0, INT16),
        Parameter("RTL_CLIMB_MIN", 0, INT16),
        Parameter("RTL_LOIT_TIME", 3000, INT32),
        Parameter("WPNAV_SPEED", 1000),
        Parameter("WPNAV_SPEED_UP", 250),
        Parameter("WPNAV_SPEED_DN", 150),
        Parameter("WPNAV_ACCEL", 350),
        Parameter("WP_YAW_BEHAVIOR", 0, INT8),
        Parameter("LAND_SPEED", 50, INT16),
        Parameter("LAND_ALT_LOW", 1000, INT16),
        Parameter("DISARM_DELAY", 10, INT8),
        Parameter("GUID_TIMEOUT", 3.0),
        Parameter("ARMING_CHECK", 1, INT32),
        Parameter("FS_EKF_ACTION", 1, INT8),
        Parameter("FS_EKF_THRESH", 0.8),
        Parameter("FS_THR_ENABLE", 1, INT8),
        Parameter("BATT_MONITOR", 4, INT8),
        Parameter("BATT_CAPACITY", 10000, INT32),
        Parameter("BATT_LOW_VOLT", 0),
        Parameter("BATT_LOW_MAH", 2000),
        Parameter("BATT_FS_LOW_ACT", 2, INT8),
        Parameter("INS_GYROFFS_X", 0.001),
        Parameter("INS_ACCOFFS_X", 0.001),
        Parameter("COMPASS_OFS_X", 1.0),
        Parameter("CAM1_TYPE", 0, INT8),
        Parameter("FRAME_CLASS", 1, INT8),
    )
    FACTORY: ClassVar[Mapping[str, float]] = {
        "MAV_GCS_SYSID": 255,
        "MAV_GCS_SYSID_HI": 0,
        "FS_GCS_ENABLE": 0,
        "FENCE_ENABLE": 0,
        "FENCE_ALT_MAX": 100,
        "FENCE_RADIUS": 300,
        "RTL_ALT": 1500,
        "BATT_FS_LOW_ACT": 0,
        "BATT_LOW_MAH": 0,
    }

    def __init__(self, identity: VehicleIdentity, kinematics: Kinematics) -> None:
        super().__init__(identity, kinematics)
        self._handlers["REQUEST_DATA_STREAM"] = self._on_request_data_stream
        self._handlers["SET_POSITION_TARGET_LOCAL_NED"] = self._on_target
        self._handlers["SET_POSITION_TARGET_GLOBAL_INT"] = self._on_target
        self._commands[mavlink.MAV_CMD_MISSION_START] = self._start_mission
        self._commands[mavlink.MAV_CMD_CONDITION_YAW] = self._turn
        self.parameters["MAV_SYSID"] = identity.system_id
        self._mode = CopterMode.STABILIZE
        self._link_lost = False
        self._low_battery = 0
        """Number of the battery that was low; 0: none was."""

    def flight_settings(self) -> FlightSettings:
        """Return the flight settings that the parameters say."""
        value = self.parameters
        return FlightSettings(
            speed_mps=value["WPNAV_SPEED"] / 100,
            climb_mps=value["WPNAV_SPEED_UP"] / 100,
            descent_mps=value["WPNAV_SPEED_DN"] / 100,
            land_speed_mps=value["LAND_SPEED"] / 100,
            land_slow_below_m=value["LAND_ALT_LOW"] / 100,
            return_height_m=value["RTL_ALT"] / 100,
            return_climb_m=value["RTL_CLIMB_MIN"] / 100,
            return_loiter_s=value["RTL_LOIT_TIME"] / 1000,
            disarm_landed_s=0.0,
            # As the patience with the link: a fast simulation gives the operator as much real time.
            disarm_idle_s=value["DISARM_DELAY"] * self.identity.speed,
            face_target=value["WP_YAW_BEHAVIOR"] != 0,
        )

    def battery_capacity_mah(self) -> float:
        """Return the battery's capacity that the parameters say."""
        return self.parameters["BATT_CAPACITY"]

    def fence(self) -> Fence:
        """Return the fence that the parameters say."""
        value = self.parameters
        kinds = int(value["FENCE_TYPE"]) if value["FENCE_ENABLE"] else 0
        radius_m = value["FENCE_RADIUS"] if kinds & 2 else math.inf
        ceiling_m = value["FENCE_ALT_MAX"] if kinds & 1 else math.inf
        return self.fence_service.polygons(radius_m, ceiling_m) if kinds & 4 else Fence(radius_m, ceiling_m)

    def on_breach(self, limit: str) -> None:
        """Tell, and return home unless the fence is for reports only."""
        self.tell(mavlink.MAV_SEVERITY_NOTICE, f"{limit} fence breached")
        if self.parameters["FENCE_ACTION"] and self._mode not in MODES_GOING_HOME:
            self.select_mode(CopterMode.RTL)

    def base_mode(self) -> int:
        """Return the heartbeat's base mode without the armed flag."""
        guided = mavlink.MAV_MODE_FLAG_GUIDED_ENABLED if self._mode in MODES_WITH_POSITION else 0
        return int(mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | mavlink.MAV_MODE_FLAG_STABILIZE_ENABLED | guided)

    def custom_mode(self) -> int:
        """Return the heartbeat's custom mode."""
        return int(self._mode)

    def land_mode(self) -> int:
        """Return the custom mode that lands."""
        return CopterMode.LAND

    def return_mode(self) -> int:
        """Return the custom mode that returns home."""
        return CopterMode.RTL

    def requested_mode(self, request: CommandRequest) -> int:
        """Return the custom mode that a DO_SET_MODE asks for."""
        return round(request.param(2))

    def select_mode(self, custom_mode: int) -> int:
        """Change the mode and begin its manoeuvre; selecting the present one changes nothing."""
        try:
            mode = CopterMode(custom_mode)
        except ValueError:
            self.tell(mavlink.MAV_SEVERITY_WARNING, f"Mode change failed: mode {custom_mode} not available")
            return int(mavlink.MAV_RESULT_FAILED)
        if mode in MODES_WITH_POSITION and not self.position_known:
            self.tell(mavlink.MAV_SEVERITY_WARNING, f"Mode change to {mode.name} failed: requires position")
            return int(mavlink.MAV_RESULT_FAILED)
        if mode is CopterMode.AUTO:
            self.tell(mavlink.MAV_SEVERITY_WARNING, "Mode change to AUTO failed: init failed")
            return int(mavlink.MAV_RESULT_FAILED)
        if mode is not self._mode:
            self._mode = mode
            self._begin_manoeuvre()
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _start_mission(self, request: CommandRequest) -> int:
        """Refuse: there never is a mission here, and ArduCopter always begins with its first item."""
        if request.param(1) or request.param(2):
            return int(mavlink.MAV_RESULT_DENIED)
        return self.select_mode(CopterMode.AUTO)

    def _begin_manoeuvre(self) -> None:
        if not self.flight.airborne:
            return
        self.flight.restore_speeds()
        match self._mode:
            case CopterMode.RTL:
                self.flight.return_home(self.kinematics, self.now.s)
            case CopterMode.LAND:
                self.flight.land(self.kinematics, self.now.s)
            case _:
                self.flight.hold(self.kinematics, self.now.s)

    def not_ready(self) -> Refusal | None:
        """Return what the pre-arm checks find wrong, whatever the mode."""
        if not self.position_known:
            return Refusal("Arm: Need Position Estimate")
        return Refusal("Arm: Battery 1 low capacity failsafe") if self._battery_is_low() else None

    def mode_not_armable(self) -> Refusal | None:
        """Return why the vehicle cannot be armed in its present mode."""
        return Refusal(f"Arm: {self._mode.name} mode not armable") if self._mode in MODES_NOT_ARMABLE else None

    def refuse_arming(self, refusal: Refusal) -> int:
        """Tell why arming was refused."""
        self.tell(mavlink.MAV_SEVERITY_CRITICAL, refusal.text)
        return int(mavlink.MAV_RESULT_FAILED)

    def take_off(self, request: CommandRequest) -> int:
        """Climb to parameter 7 above home; only on the ground, armed, in GUIDED."""
        height_m = request.finite_or_none(7)
        allowed = self.flight.armed and not self.flight.airborne and self._mode is CopterMode.GUIDED
        if not allowed or height_m is None or height_m <= 0.0:
            return int(mavlink.MAV_RESULT_FAILED)
        self.flight.restore_speeds()
        self.flight.take_off(AboveHomeM(height_m), self.kinematics, self.now.s)
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def reposition(self, request: CommandRequest) -> int:
        """Fly to a place in GUIDED.

        Only as COMMAND_INT; parameter 2 must ask for the mode change unless the vehicle is in GUIDED. The speed in
        parameter 1 is ignored. A place outside the fence is refused without a text.
        """
        if request.frame is None:
            return int(mavlink.MAV_RESULT_UNSUPPORTED)
        change_mode = int(request.finite_or_none(2) or 0) & mavlink.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE
        altitude_m = request.finite_or_none(7)
        if not (change_mode or self._mode is CopterMode.GUIDED) or altitude_m is None or not request.place_valid():
            return int(mavlink.MAV_RESULT_DENIED)
        altitude_amsl_m = self._altitude_amsl_m(request, altitude_m)
        if altitude_amsl_m is None:
            return int(RESULT_UNSUPPORTED_FRAME)
        east_m, north_m, up_m = self.identity.frame.to_enu(request.geodetic(altitude_amsl_m))
        target_enu_m = (float(east_m), float(north_m), float(up_m))
        if self.fence().breach(target_enu_m, self.flight.home_enu_m):
            return int(mavlink.MAV_RESULT_FAILED)
        if self.select_mode(CopterMode.GUIDED) != mavlink.MAV_RESULT_ACCEPTED:
            return int(mavlink.MAV_RESULT_FAILED)
        if self.flight.airborne:
            self.flight.fly_to(target_enu_m, self.kinematics, self.now.s)
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _turn(self, request: CommandRequest) -> int:
        """Turn the short way to a heading (parameter 1, degrees), or by an angle where parameter 4 is 1.

        It lasts until the next place; rate and sense of rotation are not looked at.
        """
        angle_deg, relative = request.finite_or_none(1), request.param(4)
        if angle_deg is None or not 0.0 <= angle_deg <= 360.0 or relative not in (0.0, 1.0):
            return int(mavlink.MAV_RESULT_FAILED)
        if self._mode is not CopterMode.GUIDED or not self.flight.airborne:
            return int(mavlink.MAV_RESULT_FAILED)
        self.flight.turn_to(math.radians(angle_deg) + (self.kinematics.heading_rad if relative else 0.0))
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _on_target(self, message: mavlink.MAVLink_message) -> None:
        """Fly a target in GUIDED, without an answer; a velocity lasts GUID_TIMEOUT, what is not understood stops."""
        if self._mode is not CopterMode.GUIDED or not self.flight.airborne:
            return
        around = Surroundings.of(self.identity, self.flight.home_enu_m, self.kinematics)
        try:
            motion = copter_motion(TargetRequest.of(message), around)
        except UnsupportedTargetError:
            self.flight.hold(self.kinematics, self.now.s)
            return
        place_enu_m = motion.place_enu_m
        if place_enu_m is None or self.fence().breach(place_enu_m, self.flight.home_enu_m) is None:
            self.flight.follow(motion, self.kinematics, self.now.s, max(self.parameters["GUID_TIMEOUT"], 0.1))

    def send(self, message: mavlink.MAVLink_message) -> None:
        """Put a message out; ArduCopter reports no target while it follows a velocity."""
        follows = self.flight.manoeuvre is Manoeuvre.FOLLOW
        if not (follows and message.get_msgId() == mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT):
            super().send(message)

    def _altitude_amsl_m(self, request: CommandRequest, altitude_m: float) -> AmslM | None:
        if request.frame in AMSL_FRAMES:
            return AmslM(altitude_m)
        if request.frame in RELATIVE_FRAMES:
            return AmslM(self.identity.frame.origin.altitude_amsl_m + self.flight.home_enu_m[2] + altitude_m)
        if request.frame not in TERRAIN_FRAMES:
            return None
        around = Surroundings.of(self.identity, self.flight.home_enu_m, self.kinematics)
        place = request.geodetic(SEA_LEVEL)
        return AmslM(around.ground_amsl_m(place.latitude_deg, place.longitude_deg) + altitude_m)

    def _on_request_data_stream(self, message: mavlink.MAVLink_message) -> None:
        for message_id, interval_us in requested_intervals_us(message):
            self.set_interval(message_id, interval_us)

    def on_heartbeat(self, message: mavlink.MAVLink_message) -> None:
        """Count heartbeats of the operator's system ids only."""
        lowest = self.parameters["MAV_GCS_SYSID"]
        highest = max(lowest, self.parameters["MAV_GCS_SYSID_HI"])
        if lowest <= message.get_srcSystem() <= highest:
            self.operator_heard_s = self.now.s
            self._link_lost = False

    def in_failsafe(self) -> bool:
        """Return whether a failsafe was triggered: by a link until it is back, by a battery until it is changed."""
        return self._link_lost or self._low_battery == self.battery.number

    def check_failsafes(self) -> None:
        """Return home on a lost link or a low battery, each once."""
        if self._operator_is_silent() and not self._link_lost:
            self._link_lost = True
            self._fail_safe("GCS Failsafe")
        if self._battery_is_low() and self._low_battery != self.battery.number:
            self._low_battery = self.battery.number
            self._fail_safe("Battery Failsafe")

    def _operator_is_silent(self) -> bool:
        """Whether a ground station was heard once and is not any more."""
        if not self.parameters["FS_GCS_ENABLE"] or self.operator_heard_s is None:
            return False
        return self.operator_silence_s() > self.parameters["FS_GCS_TIMEOUT"]

    def _battery_is_low(self) -> bool:
        if not self.parameters["BATT_FS_LOW_ACT"]:
            return False
        left_mah = self.battery.capacity_mah - self.battery.consumed_mah
        return left_mah < self.parameters["BATT_LOW_MAH"]

    def _fail_safe(self, name: str) -> None:
        self.tell(mavlink.MAV_SEVERITY_CRITICAL, name)
        if not self.flight.airborne:
            self.flight.disarm(self.kinematics, self.now.s)
        elif self._mode not in MODES_GOING_HOME:
            self.select_mode(CopterMode.RTL)
