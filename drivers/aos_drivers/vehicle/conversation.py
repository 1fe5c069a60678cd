"""Exchanges of several messages with an autopilot, such as reading parameters or uploading a fence."""

from __future__ import annotations

from typing import Protocol

from pymavlink.dialects.v20 import ardupilotmega as mavlink

_LONGEST_PAUSE_S = 4.0


def longer(pause_s: float) -> float:
    """Return the pause after one that has brought nothing new.

    Repeating faster than a link answers fills it up, with answers that nobody waits for any more.
    """
    return min(2.0 * pause_s, _LONGEST_PAUSE_S)


class Conversation(Protocol):
    """Sans-IO state of one exchange: messages and times in, messages out."""

    @property
    def name(self) -> str:
        """What the vehicle is asked to do, for messages to the user: "read its parameters"."""
        ...

    @property
    def due_s(self) -> float:
        """When ``poll`` wants to be called next."""
        ...

    @property
    def is_done(self) -> bool:
        """Whether nothing more is to be said."""
        ...

    def poll(self, now_s: float) -> list[mavlink.MAVLink_message]:
        """Return what is to be sent now.

        Raises:
            CommandRefusedError: the vehicle has refused.
        """
        ...

    def on_message(self, message: mavlink.MAVLink_message) -> None:
        """Take a message of the vehicle's autopilot over; others than those of this exchange are ignored."""
        ...
