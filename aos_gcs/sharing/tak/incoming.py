"""What comes from TAK: single events of a stream, of which at most 64 KiB are kept, parsed as from strangers."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Final
from xml.etree.ElementTree import Element, ParseError

from defusedxml import ElementTree
from defusedxml.common import DefusedXmlException

from aos_gcs.errors import InputDataError
from aos_gcs.input_values import shown
from aos_gcs.sharing.tak.events import PING_TYPE, ping_uid

MAX_EVENT_BYTES: Final = 65_536
"""Longest event; what is longer is thrown away."""
_END: Final = b"</event>"
_BEGIN: Final = b"<event"
MAX_ANSWER_BYTES: Final = 2_048
"""Longest answer to a ping."""
_PONG_TYPE: Final = f"{PING_TYPE}-r"
"""Type of a server's answer to a ping; some servers return the ping itself."""


class EventSplitter:
    """Cuts a stream of bytes into events."""

    def __init__(self) -> None:
        self._buffer = b""

    def feed(self, data: bytes) -> list[bytes]:
        """Take bytes, and return the events that are complete with them."""
        *events, rest = (self._buffer + data).split(_END)
        self._buffer = rest if len(rest) <= MAX_EVENT_BYTES else b""
        starts = ((event, event.rfind(_BEGIN)) for event in events)
        return [event[start:] + _END for event, start in starts if start >= 0]


def parse_event(event: bytes) -> Element:
    """Return an event as an element.

    Raises:
        InputDataError: it is too long, no XML, or declares entities.
    """
    if len(event) > MAX_EVENT_BYTES:
        raise InputDataError(f"an event of more than {MAX_EVENT_BYTES // 1024} KiB")
    try:
        element: Element = ElementTree.fromstring(event, forbid_dtd=True)
    except DefusedXmlException as error:
        raise InputDataError("an event that declares a document type or entities") from error
    except (ParseError, ValueError) as error:
        raise InputDataError("an event that is no XML") from error
    if element.tag != "event":
        raise InputDataError("XML that is no event")
    return element


def time_of(element: Element, field: str) -> float:
    """Return a time of an event in seconds UTC.

    Raises:
        InputDataError: it is none.
    """
    text = element.get(field, "")
    try:
        time = datetime.fromisoformat(text)
        return (time if time.tzinfo else time.replace(tzinfo=UTC)).timestamp()
    except (ValueError, OverflowError):
        raise InputDataError(f"{field} {shown(text)} is no time") from None


def may_answer(event: bytes) -> bool:
    """Return whether an event may be the answer to a ping, before it is parsed."""
    return len(event) <= MAX_ANSWER_BYTES and PING_TYPE.encode() in event


def is_answer(element: Element, name: str) -> bool:
    """Return whether an event answers a ping of the station of this name: with an answer, or with the ping itself."""
    kind = element.get("type")
    return kind == _PONG_TYPE or (kind == PING_TYPE and element.get("uid") == ping_uid(name))


def pong_utc_s(element: Element) -> float | None:
    """Return the server's time if an event is its answer to a ping, and readable; else None."""
    if element.get("type") != _PONG_TYPE:
        return None
    try:
        return time_of(element, "time")
    except InputDataError:
        return None
