"""Content of a hand-over, read from a mission folder."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import Final

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.handover.flights import FlightLog
from aos_gcs.handover.model import Handover, LogEntry, Raster, ReportedFinding
from aos_gcs.handover.searched import LEGENDS
from aos_gcs.mission.model.actions import ActionRecord
from aos_gcs.mission.model.events import EventKind, NoticeRecord, PicturesRecord
from aos_gcs.mission.model.findings import Finding, FindingStatus
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import PictureKind
from aos_gcs.store.audit import verify_audit
from aos_gcs.store.reader import MissionReader

_RANKS: Final = {FindingStatus.CONFIRMED: 0, FindingStatus.NEW: 1, FindingStatus.REJECTED: 2}


def read_handover(reader: MissionReader) -> Handover:
    """Return what is handed over of a mission: finished, interrupted, or still in flight.

    Raises:
        InputDataError: a part of the record is damaged, or it holds no state of the mission.
    """
    flights, decisions = FlightLog(), _Decisions()
    first_utc_s: float | None = None
    last: tuple[float, MissionSnapshot] | None = None
    for event in reader.events(EventKind.SNAPSHOT):
        if isinstance(event.data, MissionSnapshot):
            first_utc_s = event.utc_s if first_utc_s is None else first_utc_s
            last = event.utc_s, event.data
            flights.add(*last)
            decisions.add(*last)
    if last is None or first_utc_s is None:
        raise InputDataError(f"{reader.folder} holds no state of the mission to hand over: it ended before it began")
    last_utc_s, final = last
    # Older records do not say when the mission began to count its time.
    started_utc_s = last_utc_s - final.elapsed_s if final.started_utc_s is None else final.started_utc_s
    closed = flights.finish()
    manifest, outcome, actions = reader.manifest(), reader.outcome(), reader.actions()
    sortie = manifest.get("sortie")
    return Handover(
        operation=str(manifest.get("operation") or final.mission_id),
        sortie=sortie if isinstance(sortie, int) else 1,
        version=str(manifest.get("aos_gcs", "")),
        start_utc_s=first_utc_s,
        end_utc_s=last_utc_s,
        outcome=None if outcome is None else outcome.outcome,
        final=final,
        findings=_reported(final, started_utc_s, decisions),
        merged=tuple(finding for finding in final.findings if finding.merged_into is not None),
        flights=tuple(flight for flight, _ in closed),
        tracks_enu_m=_tracks([(flight.vehicle_id, way) for flight, way in closed]),
        frames=_frame_counts(reader),
        operators=_operators(actions, final),
        log=_log(reader, actions),
        audit=_audit(reader.folder),
        searched=_searched(reader),
    )


class _Decisions:
    """Times at which findings have appeared, and at which operators have decided on them."""

    def __init__(self) -> None:
        self._known: dict[int, float] = {}
        """Time of the first state that has each finding."""
        self._since: dict[int, tuple[tuple[FindingStatus, str], float | None]] = {}
        """Status and operator of each finding, and since when; None for those that an earlier sortie has left."""

    def add(self, utc_s: float, snapshot: MissionSnapshot) -> None:
        """Take in a state of the mission."""
        for finding in snapshot.findings:
            self._known.setdefault(finding.finding_id, utc_s)
            decision = finding.status, finding.operator
            former = self._since.get(finding.finding_id)
            if former is None:
                self._since[finding.finding_id] = decision, None if finding.found_in else utc_s
            elif former[0] != decision:
                self._since[finding.finding_id] = decision, utc_s

    def known_utc_s(self, finding: Finding) -> float:
        """Return the time of the first state that has a finding: at most about a second after it was marked by hand."""
        return self._known[finding.finding_id]

    def decided_utc_s(self, finding: Finding) -> float | None:
        """Return since when a finding is judged as it is; None while nobody has, or since an earlier sortie."""
        return self._since[finding.finding_id][1] if finding.decided_by else None


def _reported(final: MissionSnapshot, start_utc_s: float, decisions: _Decisions) -> tuple[ReportedFinding, ...]:
    """Return the findings that count with their times; in surveys, these would be the times of the examination."""
    counting = [finding for finding in final.findings if finding.merged_into is None]
    ordered = sorted(counting, key=lambda one: (_RANKS[one.status], not one.is_claimed, one.finding_id))

    def clock_time(finding: Finding, at_s: float) -> float | None:
        if not final.vehicles or finding.found_in:
            return None
        # Marked before the start of the mission's time: not started yet, or of an older record.
        is_undated = finding.track_id is None and finding.sightings == 0 and at_s == 0.0
        return decisions.known_utc_s(finding) if is_undated else start_utc_s + at_s

    return tuple(
        ReportedFinding(
            finding,
            found_utc_s=clock_time(finding, finding.found_at_s),
            seen_utc_s=clock_time(finding, finding.seen_at_s),
            decided_utc_s=decisions.decided_utc_s(finding),
        )
        for finding in ordered
    )


def _tracks(ways: list[tuple[int, tuple[EnuPoint, ...]]]) -> dict[int, tuple[tuple[EnuPoint, ...], ...]]:
    return {vehicle_id: tuple(way for _, way in group) for vehicle_id, group in groupby(ways, key=lambda one: one[0])}


def _frame_counts(reader: MissionReader) -> dict[int, int]:
    counts: dict[int, int] = {}
    for entry in reader.frames():
        counts[entry.vehicle_id] = counts.get(entry.vehicle_id, 0) + 1
    return counts


def _operators(actions: tuple[ActionRecord, ...], final: MissionSnapshot) -> tuple[str, ...]:
    names = [*(action.operator for action in actions), *(finding.operator for finding in final.findings)]
    return tuple(dict.fromkeys(name for name in names if name))


def _log(reader: MissionReader, actions: tuple[ActionRecord, ...]) -> tuple[LogEntry, ...]:
    """Return the notices, which tell what operators have done, and what was refused of their actions."""
    entries = [*_notices(reader), *(entry for action in actions for entry in _refusals(action))]
    return tuple(sorted(entries, key=lambda entry: entry.utc_s))


def _notices(reader: MissionReader) -> Iterator[LogEntry]:
    for event in reader.events(EventKind.NOTICE):
        if isinstance(event.data, NoticeRecord):
            source = "" if event.data.vehicle_id is None else f"Vehicle {event.data.vehicle_id}"
            yield LogEntry(event.data.utc_s or event.utc_s, event.data.severity.value, source, event.data.text)


def _refusals(action: ActionRecord) -> Iterator[LogEntry]:
    """Yield why the mission has refused an action, or which vehicles have."""
    what = f"{action.operator or 'operator'}: {action.action.value}"
    if action.refusal is not None:
        whom = "" if action.vehicle_ids is None else f" (vehicles {', '.join(map(str, action.vehicle_ids))})"
        yield LogEntry(action.utc_s, "warning", "", f"{what}{whom} refused: {action.refusal}")
    for result in action.results:
        if not result.accepted:
            yield LogEntry(action.utc_s, "warning", f"Vehicle {result.vehicle_id}", f"{what} refused: {result.text}")


def _audit(folder: Path) -> str:
    try:
        report = verify_audit(folder)
    except InputDataError:
        return "Audit log: recorded without a chain by an older version."
    if report.fault is not None:
        return f"Audit log: CHANGED, {report.fault}."
    return f"Audit log: intact, {len(report.entries)} entries, digest {report.digest}."


def _searched(reader: MissionReader) -> Raster | None:
    """Return the latest raster of the searched ground that says most; None where none was recorded."""
    announced: dict[PictureKind, PicturesRecord] = {}
    for event in reader.events(EventKind.PICTURES):
        if isinstance(event.data, PicturesRecord):
            announced |= dict.fromkeys(event.data.kinds, event.data)
    for kind in LEGENDS:
        found = announced.get(kind)
        png = None if found is None else reader.picture(found.step, kind)
        if found is not None and png is not None:
            return Raster(kind, png, found.west_m, found.south_m, found.east_m, found.north_m)
    return None
