"""Asking a vehicle for the messages that tell its pose."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pymavlink.dialects.v20 import ardupilotmega as mavlink

POSE_HZ = 20.0
_SILENT_S = 2.0
"""A stream that brings nothing for this long is asked for (again), as often as this."""
_TRUTH_ATTEMPTS = 5
"""Only simulated autopilots tell their true pose; others that tell their position are soon left alone with it."""

_POSITION: int = mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT
_AUTOPILOT_COMPONENT = int(mavlink.MAV_COMP_ID_AUTOPILOT1)


@dataclass(slots=True)
class _Stream:
    message_id: int
    attempts: float
    heard_at_s: float = -math.inf
    asked_at_s: float = -math.inf


class PoseRequests:
    """The requests to one vehicle: for its poses whenever they stay away, for its home until it is known."""

    def __init__(self, system_id: int, autopilot: int) -> None:
        """``autopilot`` is its MAV_AUTOPILOT."""
        self._system_id = system_id
        is_ardupilot = autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
        truth = mavlink.MAVLINK_MSG_ID_SIM_STATE if is_ardupilot else mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION
        self._streams = {
            message_id: _Stream(message_id, self._attempts(message_id)) for message_id in (_POSITION, truth)
        }
        self._home_asked_at_s = -math.inf
        self._knows_home = False

    def hear(self, message_id: int, now_s: float) -> None:
        """Note a message of the autopilot."""
        if message_id in self._streams:
            self._streams[message_id].heard_at_s = now_s
            self._streams[message_id].attempts = self._attempts(message_id)
        elif message_id == mavlink.MAVLINK_MSG_ID_HOME_POSITION:
            self._knows_home = True

    def due(self, now_s: float) -> list[mavlink.MAVLink_command_long_message]:
        """Return the commands to be sent now."""
        commands = []
        is_alive = now_s - self._streams[_POSITION].heard_at_s < _SILENT_S
        for stream in self._streams.values():
            if stream.message_id != _POSITION and not is_alive:
                continue
            last_s = max(stream.heard_at_s, stream.asked_at_s)
            if stream.attempts > 0 and now_s - last_s >= _SILENT_S:
                stream.attempts -= 1
                stream.asked_at_s = now_s
                interval_us = 1e6 / POSE_HZ
                commands.append(self._command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, stream.message_id, interval_us))
        if not self._knows_home and now_s - self._home_asked_at_s >= _SILENT_S:
            self._home_asked_at_s = now_s
            commands.append(self._command(mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_HOME_POSITION))
        return commands

    @staticmethod
    def _attempts(message_id: int) -> float:
        return math.inf if message_id == _POSITION else _TRUTH_ATTEMPTS

    def _command(self, command: int, message_id: int, interval_us: float = 0.0) -> mavlink.MAVLink_command_long_message:
        rest = (interval_us, 0.0, 0.0, 0.0, 0.0, 0.0)
        return mavlink.MAVLink_command_long_message(
            self._system_id, _AUTOPILOT_COMPONENT, command, 0, float(message_id), *rest
        )
