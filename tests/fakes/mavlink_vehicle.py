"""A vehicle in memory that speaks MAVLink to a driver: packets in, packets out, no sockets and no physics."""

from __future__ import annotations

import math
from collections.abc import Callable

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.framing import FrameParser
from aos_gcs.geometry.geodesy import GeodeticPosition

HOME = GeodeticPosition(48.0, 14.0, 300.0)
OUR_SYSTEM, OUR_COMPONENT = 254, 190
EKF_READY = mavlink.EKF_POS_HORIZ_REL | mavlink.EKF_POS_HORIZ_ABS
SIGNING_EPOCH_UTC_S = 1_420_070_400
COPTER_STABILIZE, COPTER_GUIDED = 0, 4


class Encoder:
    """One (system, component) that packs messages with its own sequence."""

    def __init__(self, system_id: int, component_id: int) -> None:
        self._mav = mavlink.MAVLink(None, srcSystem=system_id, srcComponent=component_id)

    def pack(self, message: mavlink.MAVLink_message) -> bytes:
        packet = message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) % 256
        return packet

    def sign(self, key: bytes, utc_s: float) -> None:
        """Sign from now on, as pymavlink does."""
        signing = self._mav.signing
        signing.secret_key, signing.sign_outgoing = key, True
        signing.timestamp = round((utc_s - SIGNING_EPOCH_UTC_S) * 1e5)

    def skip(self, packets: int) -> None:
        """Lose packets on the way."""
        self._mav.seq = (self._mav.seq + packets) % 256


class FakeVehicle:
    """State that tests set directly, commands that it obeys at once, and all that was sent to it.

    ``obeys`` decides per command: True acts and accepts, an int is the MAV_RESULT of a refusal, None keeps silent.
    """

    def __init__(self, system_id: int = 1, autopilot: int = mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA) -> None:
        self.system_id = system_id
        self.autopilot = autopilot
        self.custom_mode = COPTER_STABILIZE
        self.armed = False
        self.landed = mavlink.MAV_LANDED_STATE_ON_GROUND
        self.height_m = 0.0
        self.latitude_deg, self.longitude_deg = HOME.latitude_deg, HOME.longitude_deg
        self.target: tuple[int, int, float] | None = None
        self.velocity_ned_cmps = (0, 0, 0)
        self.uid = 1000 + system_id
        self.boot_ms = 10_000
        self.encoder = Encoder(system_id, 1)
        self.camera = Encoder(system_id, 100)
        self.commands: list[mavlink.MAVLink_message] = []
        self.heard_heartbeats = 0
        self.obeys: Callable[[mavlink.MAVLink_message], bool | int | None] = lambda _command: True
        self._parser = FrameParser()

    # --- what it says -----------------------------------------------------------------------------------------------

    def heartbeat(self) -> bytes:
        armed = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if self.armed else 0
        base_mode = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | armed
        return self.encoder.pack(
            mavlink.MAVLink_heartbeat_message(
                mavlink.MAV_TYPE_QUADROTOR, self.autopilot, base_mode, self.custom_mode, mavlink.MAV_STATE_STANDBY, 3
            )
        )

    def position(self) -> bytes:
        return self.encoder.pack(
            mavlink.MAVLink_global_position_int_message(
                self.boot_ms,
                round(self.latitude_deg * 1e7),
                round(self.longitude_deg * 1e7),
                round((HOME.altitude_amsl_m + self.height_m) * 1000),
                round(self.height_m * 1000),
                *self.velocity_ned_cmps,
                9000,
            )
        )

    def home(self) -> bytes:
        return self.encoder.pack(
            mavlink.MAVLink_home_position_message(
                round(HOME.latitude_deg * 1e7),
                round(HOME.longitude_deg * 1e7),
                round(HOME.altitude_amsl_m * 1000),
                0,
                0,
                0,
                [1, 0, 0, 0],
                0,
                0,
                0,
            )
        )

    def sys_status(self, healthy: bool = True) -> bytes:
        prearm = mavlink.MAV_SYS_STATUS_PREARM_CHECK
        health = prearm if healthy else 0
        return self.encoder.pack(
            mavlink.MAVLink_sys_status_message(prearm, prearm, health, 0, 15_800, -1, 83, 0, 0, 0, 0, 0, 0)
        )

    def gps(self, fix: int = 3) -> bytes:
        return self.encoder.pack(mavlink.MAVLink_gps_raw_int_message(0, fix, 0, 0, 0, 100, 100, 0, 0, 14))

    def ekf(self, flags: int = EKF_READY) -> bytes:
        return self.encoder.pack(mavlink.MAVLink_ekf_status_report_message(flags, 0, 0, 0, 0, 0))

    def estimator(self, flags: int) -> bytes:
        """Return the state of PX4's estimator."""
        return self.encoder.pack(
            mavlink.MAVLink_estimator_status_message(self.boot_ms * 1000, flags, 0, 0, 0, 0, 0, 0, 0.3, 0.3)
        )

    def extended_state(self) -> bytes:
        return self.encoder.pack(mavlink.MAVLink_extended_sys_state_message(0, self.landed))

    def target_echo(self) -> bytes:
        latitude_e7, longitude_e7, altitude_m = self.target or (0, 0, 0.0)
        return self.encoder.pack(
            mavlink.MAVLink_position_target_global_int_message(
                self.boot_ms, mavlink.MAV_FRAME_GLOBAL, 0xFF8, latitude_e7, longitude_e7, altitude_m, *[0.0] * 8
            )
        )

    def version(self) -> bytes:
        return self.encoder.pack(
            mavlink.MAVLink_autopilot_version_message(0, 0, 0, 0, 0, [0] * 8, [0] * 8, [0] * 8, 0, 0, self.uid)
        )

    def status_text(self, text: str, severity: int = mavlink.MAV_SEVERITY_CRITICAL) -> bytes:
        return self.encoder.pack(mavlink.MAVLink_statustext_message(severity, text.encode()))

    def ack(self, command: int, result: int, target_system: int = OUR_SYSTEM, component: int = OUR_COMPONENT) -> bytes:
        return self.encoder.pack(mavlink.MAVLink_command_ack_message(command, result, 0, 0, target_system, component))

    def telemetry(self) -> bytes:
        """Everything a ready vehicle reports."""
        self.boot_ms += 100
        parts = [
            self.heartbeat(),
            self.position(),
            self.home(),
            self.sys_status(),
            self.gps(),
            self.ekf(),
            self.extended_state(),
        ]
        return b"".join([*parts, self.target_echo()] if self.target is not None else parts)

    def camera_heartbeat(self) -> bytes:
        return self.camera.pack(
            mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_CAMERA, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4, 3)
        )

    # --- what it hears ----------------------------------------------------------------------------------------------

    def hear(self, packets: bytes) -> bytes:
        """Take the driver's packets and return the answers."""
        answers = b""
        for message in self._parser.feed(packets):
            if message.get_msgId() == mavlink.MAVLINK_MSG_ID_HEARTBEAT:
                self.heard_heartbeats += 1
            elif message.get_msgId() in (mavlink.MAVLINK_MSG_ID_COMMAND_LONG, mavlink.MAVLINK_MSG_ID_COMMAND_INT):
                answers += self._on_command(message)
        return answers

    def sent(self, command: int) -> list[mavlink.MAVLink_message]:
        """Return the packets of one command that were heard."""
        return [message for message in self.commands if message.command == command]

    def _on_command(self, message: mavlink.MAVLink_message) -> bytes:
        self.commands.append(message)
        if message.target_system != self.system_id or message.target_component != 1:
            return b""
        answer = self.obeys(message)
        if answer is None:
            return b""
        if answer is not True:
            return self.ack(message.command, int(answer))
        self._act(message)
        return self.ack(message.command, mavlink.MAV_RESULT_ACCEPTED)

    def _act(self, message: mavlink.MAVLink_message) -> None:
        match message.command:
            case mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
                self.armed = message.param1 == 1
            case mavlink.MAV_CMD_DO_SET_MODE:
                is_px4 = self.autopilot == mavlink.MAV_AUTOPILOT_PX4
                custom = int(message.param2) << 16 | int(message.param3) << 24 if is_px4 else int(message.param2)
                self.custom_mode = custom
            case mavlink.MAV_CMD_NAV_TAKEOFF:
                self.landed = mavlink.MAV_LANDED_STATE_IN_AIR
                self.height_m = message.param7
                if self.autopilot == mavlink.MAV_AUTOPILOT_PX4:
                    self.height_m -= HOME.altitude_amsl_m
            case mavlink.MAV_CMD_DO_REPOSITION if message.get_type() == "COMMAND_LONG":
                assert self.autopilot == mavlink.MAV_AUTOPILOT_PX4
                assert all(math.isnan(value) for value in (message.param5, message.param6, message.param7))
                self.custom_mode, self.velocity_ned_cmps = 4 << 16 | 3 << 24, (0, 0, 0)
            case mavlink.MAV_CMD_DO_REPOSITION:
                assert not math.isnan(message.z)
                self.target = (message.x, message.y, message.z)
