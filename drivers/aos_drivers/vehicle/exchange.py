"""Exchanges of several messages with an autopilot, such as reading parameters or uploading a fence."""

from __future__ import annotations

from typing import Protocol

from pymavlink.dialects.v20 import ardupilotmega as mavlink

_LONGEST_PAUSE_S = 4.0


def longer_pause_s(pause_s: float) -> float:
    """Return the pause that follows one without any answer.

    Repeating faster than a link answers fills it with answers that are no longer needed.
    """
    return min(2.0 * pause_s, _LONGEST_PAUSE_S)


class Exchange(Protocol):
    """Sans-IO state of one exchange: messages and times in, messages out."""

    @property
    def name(self) -> str:
        """Request to the vehicle, for messages to the user: "report its parameters"."""
        ...

    @property
    def due_s(self) -> float:
        """Time of the next call of ``poll``."""
        ...

    @property
    def is_done(self) -> bool:
        """Whether the exchange has ended."""
        ...

    def poll(self, now_s: float) -> list[mavlink.MAVLink_message]:
        """Return the messages to send now.

        Raises:
            CommandRefusedError: the vehicle has refused.
        """
        ...

    def on_message(self, message: mavlink.MAVLink_message) -> None:
        """Process a message of the vehicle's autopilot; those that do not belong to this exchange are ignored."""
        ...
