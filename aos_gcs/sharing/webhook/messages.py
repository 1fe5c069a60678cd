"""Messages of the web hook, version 1: what has happened to findings, and alerts."""

from __future__ import annotations

import hashlib
import hmac
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from enum import StrEnum
from typing import Any, Final

from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.notations import mgrs_text
from aos_gcs.mission.model.events import NoticeRecord
from aos_gcs.mission.model.findings import Finding, FindingStatus
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.sharing.wording import finding_title, finding_uid

VERSION: Final = 1
_MOVED_M: Final = 2.0
"""Distance that a finding has moved since it was last told of, from which that counts as a change."""
_MAX_TEXT: Final = 2000


class HookEvent(StrEnum):
    """What a message is about."""

    STARTED = "station.started"
    FINDING_NEW = "finding.new"
    FINDING_CHANGED = "finding.changed"
    FINDING_CONFIRMED = "finding.confirmed"
    FINDING_REJECTED = "finding.rejected"
    FINDING_MERGED = "finding.merged"
    """Finding that has turned out to be another one, ``same_as``."""
    ALERT = "alert"


@dataclass(frozen=True, slots=True)
class HookMessage:
    """One message."""

    event: HookEvent
    message_id: str
    """The same for the same message, however often it arrives."""
    body: bytes

    def headers(self, secret: str, utc_s: float) -> dict[str, str]:
        """Return the headers of one attempt to deliver it.

        The signature is that of the time, a dot and the body, so that nobody can send it again much later.
        """
        timestamp = str(int(utc_s))
        signed = hmac.new(secret.encode(), timestamp.encode() + b"." + self.body, hashlib.sha256)
        return {
            "Content-Type": "application/json",
            "User-Agent": "aos-gcs",
            "Idempotency-Key": self.message_id,
            "X-AOS-Event": self.event.value,
            "X-AOS-Timestamp": timestamp,
            "X-AOS-Signature": f"sha256={signed.hexdigest()}",
        }


class FindingChanges:
    """Compares the findings of a state with those that were told of before."""

    def __init__(self) -> None:
        self._told: dict[int, Finding] = {}

    def since(self, snapshot: MissionSnapshot) -> Iterator[tuple[HookEvent, Finding]]:
        """Yield what has happened to findings since the last call; nothing before the mission's origin is known."""
        if snapshot.origin is None:
            return
        for finding in snapshot.findings:
            former = self._told.get(finding.finding_id)
            if former is None:
                yield HookEvent.FINDING_NEW, finding
                # What was decided before the first look is told, too: the message of a new one may be known already.
                former = replace(finding, status=FindingStatus.NEW, merged_into=None)
                self._told[finding.finding_id] = finding
            if (event := _change(former, finding)) is not None:
                self._told[finding.finding_id] = finding
                yield event, finding


def _change(former: Finding, finding: Finding) -> HookEvent | None:
    if finding.merged_into is not None and former.merged_into is None:
        return HookEvent.FINDING_MERGED
    if finding.status is not former.status:
        told = {
            FindingStatus.CONFIRMED: HookEvent.FINDING_CONFIRMED,
            FindingStatus.REJECTED: HookEvent.FINDING_REJECTED,
        }
        return told.get(finding.status, HookEvent.FINDING_CHANGED)
    words = [(one.kind, one.comment, one.assignee, one.merged_into) for one in (former, finding)]
    moved_m = math.dist(former.position_enu_m[:2], finding.position_enu_m[:2])
    return HookEvent.FINDING_CHANGED if words[0] != words[1] or moved_m >= _MOVED_M else None


def finding_message(event: HookEvent, finding: Finding, snapshot: MissionSnapshot, utc_s: float) -> HookMessage:
    """Return a message about a finding of a mission whose origin is known."""
    assert snapshot.origin is not None  # noqa: S101 - for the type checker; ``FindingChanges`` sees to it
    fields = _finding_fields(finding, snapshot, LocalFrame(snapshot.origin).to_geodetic(finding.position_enu_m))
    name = f"{finding_uid(finding, snapshot.mission_id)}.{event.value.partition('.')[2]}"
    if event is not HookEvent.FINDING_NEW:
        name += "." + hashlib.sha256(json.dumps(fields, sort_keys=True).encode()).hexdigest()[:12]
    return _message(event, name, snapshot.mission_id, utc_s, {"finding": fields})


def alert_message(notice: NoticeRecord, mission_id: str, utc_s: float) -> HookMessage:
    """Return a message about a notice."""
    fields = {
        "severity": notice.severity.value,
        "text": notice.text[:_MAX_TEXT],
        "vehicle_id": notice.vehicle_id,
        "utc": _iso(notice.utc_s),
    }
    return _message(HookEvent.ALERT, f"{mission_id}.notice.{notice.notice_id}", mission_id, utc_s, {"alert": fields})


def started_message(mission_id: str, utc_s: float) -> HookMessage:
    """Return the first message of a mission, which shows that the hook works."""
    return _message(HookEvent.STARTED, f"{mission_id}.started", mission_id, utc_s, {})


def _finding_fields(finding: Finding, snapshot: MissionSnapshot, position: GeodeticPosition) -> dict[str, Any]:
    ellipse, start_utc_s = finding.ellipse, snapshot.started_utc_s
    is_dated = start_utc_s is not None and not finding.found_in
    return {
        "uid": finding_uid(finding, snapshot.mission_id),
        "number": finding.finding_id,
        "title": finding_title(finding),
        "kind": finding.kind.value,
        "status": finding.status.value,
        "latitude_deg": round(position.latitude_deg, 7),
        "longitude_deg": round(position.longitude_deg, 7),
        "altitude_amsl_m": round(position.altitude_amsl_m, 1),
        "mgrs": mgrs_text(position.latitude_deg, position.longitude_deg),
        "sigma_m": _finite(finding.sigma_m),
        "ellipse_semi_major_m": None if ellipse is None else _finite(ellipse.semi_major_m),
        "ellipse_semi_minor_m": None if ellipse is None else _finite(ellipse.semi_minor_m),
        "ellipse_heading_deg": None if ellipse is None else round(math.degrees(ellipse.heading_rad), 1),
        "person_confidence": _finite(finding.person_confidence),
        "sightings": finding.sightings,
        "found_utc": _iso(start_utc_s + finding.found_at_s) if is_dated and start_utc_s is not None else None,
        "seen_utc": _iso(start_utc_s + finding.seen_at_s) if is_dated and start_utc_s is not None else None,
        "reasons": list(finding.reasons),
        "comment": finding.comment[:_MAX_TEXT],
        "assignee": finding.assignee,
        "judged_by": finding.decided_by,
        "same_as": finding.merged_into,
    }


def _message(
    event: HookEvent, message_id: str, mission_id: str, utc_s: float, content: Mapping[str, Any]
) -> HookMessage:
    document = {
        "version": VERSION,
        "id": message_id,
        "event": event.value,
        "mission": mission_id,
        "utc": _iso(utc_s),
        **content,
    }
    return HookMessage(event, message_id, json.dumps(document, ensure_ascii=False, allow_nan=False).encode())


def _iso(utc_s: float) -> str:
    return datetime.fromtimestamp(utc_s, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else round(value, 3)
