"""Exchanges of several messages with an autopilot, such as reading parameters or uploading a fence."""

from __future__ import annotations

from typing import Protocol

from pymavlink.dialects.v20 import ardupilotmega as mavlink


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
