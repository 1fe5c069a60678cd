"""One command on its way: sent, repeated when lost, answered."""

from __future__ import annotations

import math
from collections.abc import Set
from enum import Enum, auto
from typing import TypeAlias

from pymavlink.dialects.v20 import ardupilotmega as mavlink

CommandMessage: TypeAlias = mavlink.MAVLink_command_long_message | mavlink.MAVLink_command_int_message

ACK_TIMEOUT_S = 0.7
"""Pause before a command without an answer is sent again."""
BUSY_PAUSE_S = 1.0
"""Pause before a command that was temporarily rejected is sent again."""
PROGRESS_TIMEOUT_S = 5.0
"""Time for which one IN_PROGRESS keeps a command from being sent again."""


class Answer(Enum):
    """Latest answer of the autopilot."""

    NONE = auto()
    ACCEPTED = auto()
    REFUSED = auto()


class CommandTransaction:
    """Sans-IO state of one command (https://mavlink.io/en/services/command.html).

    The last acknowledgement counts: PX4 sends two for some commands, the second by the part that acts on it. A refusal
    after an acceptance does not count where the command was sent twice in between: ArduCopter refuses a second takeoff,
    being in the air by the first, whose acknowledgement came late.
    """

    def __init__(
        self,
        message: CommandMessage,
        repeat_s: float = math.inf,
        ack_timeout_s: float = ACK_TIMEOUT_S,
        *,
        ignored_results: Set[int] = frozenset(),
    ) -> None:
        """Prepare ``message``; it is sent again after ``ack_timeout_s`` without an answer.

        Once accepted, it is sent again every ``repeat_s`` until polling stops; after one of ``ignored_results`` it is,
        too, as if it had not been answered.
        """
        self._ignored_results = ignored_results
        self._message = message
        self._ack_timeout_s = ack_timeout_s
        self._repeat_s = repeat_s
        self.answer = Answer.NONE
        self.result: int | None = None
        self.due_s = -math.inf
        """Time of the next call of ``poll``."""
        self._sendings = 0

    def poll(self, now_s: float) -> CommandMessage | None:
        """Return the packet to send now, if one is due."""
        if now_s < self.due_s:
            return None
        message = self._message
        self._sendings += 1
        if self._sendings > 1 and message.get_msgId() == mavlink.MAVLINK_MSG_ID_COMMAND_LONG:
            message.confirmation = min(message.confirmation + 1, 255)
        self.due_s = now_s + self._ack_timeout_s
        return message

    def on_ack(self, ack: mavlink.MAVLink_command_ack_message, source: tuple[int, int], now_s: float) -> None:
        """Process an acknowledgement from ``source`` (system, component), if it is for this command."""
        message = self._message
        if ack.command != message.command or source != (message.target_system, message.target_component):
            return
        may_be_of_repetition = self.answer is Answer.ACCEPTED and self._sendings > 1 and math.isinf(self._repeat_s)
        if may_be_of_repetition and ack.result != mavlink.MAV_RESULT_ACCEPTED:
            return
        self.result = ack.result
        if ack.result == mavlink.MAV_RESULT_ACCEPTED:
            self.answer = Answer.ACCEPTED
            self.due_s = now_s + self._repeat_s
        elif ack.result == mavlink.MAV_RESULT_IN_PROGRESS:
            self.due_s = now_s + PROGRESS_TIMEOUT_S
        elif ack.result == mavlink.MAV_RESULT_TEMPORARILY_REJECTED or ack.result in self._ignored_results:
            self.due_s = now_s + BUSY_PAUSE_S
        else:
            self.answer = Answer.REFUSED
            self.due_s = math.inf


def result_text(result: int | None) -> str:
    """Return the name of a MAV_RESULT in words."""
    entry = mavlink.enums["MAV_RESULT"].get(result)
    name = str(entry.name).removeprefix("MAV_RESULT_") if entry is not None else f"result {result}"
    return name.lower().replace("_", " ")
