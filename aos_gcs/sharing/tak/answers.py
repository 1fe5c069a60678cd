"""What a TAK server sends: only its answers to pings matter, for the life of the connection and its clock."""

from __future__ import annotations

from datetime import datetime
from xml.etree.ElementTree import ParseError

from defusedxml import ElementTree
from defusedxml.common import DefusedXmlException

_END = b"</event>"
_BEGIN = b"<event"
_PONG = b"t-x-c-t-r"
_MAX_BYTES = 65_536
"""Longest event; what is longer is thrown away."""


class Answers:
    """Finds answers to pings in a stream of events, of which at most 64 KiB are kept."""

    def __init__(self) -> None:
        self._buffer = b""

    def feed(self, data: bytes) -> list[float]:
        """Take bytes, and return the time, in seconds UTC, that each answer to a ping in them carries."""
        *events, rest = (self._buffer + data).split(_END)
        self._buffer = rest if len(rest) <= _MAX_BYTES else b""
        times = (_time_of(event) for event in events if _PONG in event)
        return [utc_s for utc_s in times if utc_s is not None]


def _time_of(event: bytes) -> float | None:
    """Return the time of an event; None if it is not readable."""
    start = event.rfind(_BEGIN)
    if start < 0:
        return None
    try:
        element = ElementTree.fromstring(event[start:] + _END, forbid_dtd=True)
        return datetime.fromisoformat(element.get("time", "")).timestamp()
    except (ParseError, DefusedXmlException, ValueError):
        return None
