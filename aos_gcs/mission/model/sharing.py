"""States of live sharing: what leaves the station for the systems of others."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class ChannelState(StrEnum):
    """State of the connection to another system."""

    CONNECTING = "connecting"
    CONNECTED = "connected"
    FAILED = "failed"
    """Not reached, or lost; it is tried again."""
    REFUSED = "refused"
    """Reached, but what we present is refused, or what it presents; a person has to change something."""


@dataclass(frozen=True, slots=True)
class ChannelStatus:
    """One system that data is shared with."""

    name: str
    """Name for operators, such as ``TAK``."""
    target: str
    """Address without anything secret."""
    state: ChannelState
    text: str
    """What is so and what to do, without a full stop."""
    sent: int = 0
    """Messages sent so far."""
    lost: int = 0
    """Messages that were given up."""
    sent_utc_s: float | None = None
    """Time of the latest message sent; None before the first."""
    received: int = 0
    """Marks and drawings of others that came as proposals for the plan."""
    refused: int = 0
    """Messages of others that could not be used."""
    refused_text: str = ""
    """Reason of the latest of these, without a full stop."""
