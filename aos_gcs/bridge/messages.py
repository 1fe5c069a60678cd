"""Messages between the flight's process and the interface's: a name and JSON, behind their length.

No message can make the reader run code: JSON becomes the dataclasses that the table of forms names, or is refused.
"""

from __future__ import annotations

import asyncio
import struct
from collections.abc import Mapping
from functools import cache
from typing import Any, Final

from pydantic import ConfigDict, TypeAdapter, ValidationError

from aos_gcs.errors import AosError
from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.mission.model.actions import Action, ActionResult, Seen
from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.model.events import EventKind, NoticeRecord, PicturesRecord, PlanRecord
from aos_gcs.mission.model.findings import Finding, FindingChange
from aos_gcs.mission.model.proposals import Proposal, ProposalRecord, ProposalUse
from aos_gcs.mission.model.sharing import ChannelStatus
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import Picture, StepRecord
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.settings import MissionSettings

MAX_REQUEST_BYTES: Final = 4 * 2**20
"""Several times the largest plan."""
_LENGTH: Final = struct.Struct("!I")

REQUESTS: Final[dict[str, Any]] = {
    "act": tuple[int, Action, tuple[int, ...] | None, float | None, str, Seen | None],
    "override_check": tuple[int, int, str, str | None, str, Seen | None],
    "acknowledge": tuple[int, tuple[int, ...], str],
    "announce": tuple[int, str, str],
    "add_finding": tuple[int, EnuPoint, str, str],
    "change_finding": tuple[int, int, FindingChange, str],
    "decide_proposal": tuple[int, int, ProposalUse, str],
    "apply_plan": tuple[int, MissionPlan, str, Seen | None],
    "alive": tuple[bool],
}
"""Messages of the interface: commands with their numbers, and whether it serves clients, twice a second."""

SHARING_REQUESTS: Final[dict[str, Any]] = {
    "alive": tuple[bool],
    "sharing": tuple[tuple[ChannelStatus, ...]],
    "proposals": tuple[str, tuple[Proposal, ...], tuple[str, ...]],
}
"""Messages of live sharing, which commands nothing: that it works, the states of its connections, and what others have
proposed or deleted."""

REPORTS: Final[dict[str, Any]] = {
    "welcome": tuple[float, MissionSnapshot, MissionSettings, tuple[NoticeRecord, ...]],
    "step": tuple[StepRecord],
    "picture": tuple[Picture],
    "ready": tuple[int],
    "settings": tuple[MissionSettings],
    "state": tuple[float, MissionSnapshot],
    f"event {EventKind.SNAPSHOT}": tuple[int, float, MissionSnapshot, float],
    f"event {EventKind.STEP}": tuple[int, float, StepRecord],
    f"event {EventKind.NOTICE}": tuple[int, float, NoticeRecord],
    f"event {EventKind.PICTURES}": tuple[int, float, PicturesRecord],
    f"event {EventKind.PLAN}": tuple[int, float, PlanRecord],
    "done act": tuple[int, tuple[ActionResult, ...]],
    "done override_check": tuple[int, PreflightCheck],
    "done acknowledge": tuple[int, None],
    "done announce": tuple[int, None],
    "done add_finding": tuple[int, Finding],
    "done change_finding": tuple[int, Finding],
    "done decide_proposal": tuple[int, ProposalRecord],
    "done apply_plan": tuple[int, None],
    "refused": tuple[int, str, str],
}
"""Messages of the flight. A welcome, the steps and pictures so far and ``ready`` tell an interface everything anew;
then come states, events and, by their numbers, what became of commands."""

_FORMS: Final = REQUESTS | SHARING_REQUESTS | REPORTS
_CONFIG: Final = ConfigDict(ser_json_inf_nan="strings", ser_json_bytes="base64", val_json_bytes="base64")


class MalformedMessageError(AosError):
    """Bytes that are no message of the other process."""


def pack(name: str, *values: object) -> bytes:
    """Return a message, with its length in front."""
    return framed(name.encode() + b"\n" + _adapter(name).dump_json(values))


def framed(payload: bytes) -> bytes:
    """Return a payload with its length in front."""
    return _LENGTH.pack(len(payload)) + payload


def unpack(payload: bytes, forms: Mapping[str, Any]) -> tuple[str, tuple[Any, ...]]:
    """Return the name and the values of a message of one of these forms.

    Raises:
        MalformedMessageError: it is none.
    """
    head, _, body = payload.partition(b"\n")
    name = head.decode(errors="replace")
    if name not in forms:
        raise MalformedMessageError(f"unknown message {name[:40]!r}")
    try:
        values: tuple[Any, ...] = _adapter(name).validate_json(body)
    except (ValidationError, AosError) as error:
        raise MalformedMessageError(f"message {name}: {error}") from error
    return name, values


async def read_message(reader: asyncio.StreamReader, max_bytes: int) -> bytes | None:
    """Return the payload of the next message; None when the other side has gone.

    Raises:
        MalformedMessageError: it is longer than allowed.
    """
    try:
        (length,) = _LENGTH.unpack(await reader.readexactly(_LENGTH.size))
        if length > max_bytes:
            raise MalformedMessageError(f"a message of {length} bytes, more than {max_bytes}")
        return await reader.readexactly(length)
    except (asyncio.IncompleteReadError, ConnectionError):
        return None


@cache
def _adapter(name: str) -> TypeAdapter[Any]:
    return TypeAdapter(_FORMS[name], config=_CONFIG)
