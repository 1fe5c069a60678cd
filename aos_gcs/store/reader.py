"""Reads a mission folder: finished, killed, or still being written by another process."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from types import NoneType, TracebackType
from typing import Any, Self, TypeVar

from aos_gcs.errors import InputDataError
from aos_gcs.mission.model.actions import ActionRecord
from aos_gcs.mission.model.decisions import ConclusionRecord, DecisionRecord, SearchRecord
from aos_gcs.mission.model.events import Event, EventData, EventKind, NoticeRecord, PicturesRecord, PlanRecord
from aos_gcs.mission.model.phase import Outcome, OutcomeRecord, Phase
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import PictureKind, StepRecord
from aos_gcs.mission.model.vehicles import SettingsRecord
from aos_gcs.store.codec import decode
from aos_gcs.store.frame_entry import DAMAGE, FrameEntry, time_s, typed
from aos_gcs.store.opening import SQLITE_DAMAGE, open_database
from aos_gcs.store.schema import DATABASE_NAME, MANIFEST_NAME, picture_path
from aos_gcs.store.upgrade import FIRST_WITH_DECISIONS, FIRST_WITH_SETTINGS, upgraded

T = TypeVar("T")

EVENT_TYPES: dict[EventKind, type[EventData]] = {
    EventKind.SNAPSHOT: MissionSnapshot,
    EventKind.STEP: StepRecord,
    EventKind.NOTICE: NoticeRecord,
    EventKind.PICTURES: PicturesRecord,
    EventKind.PLAN: PlanRecord,
}


@dataclass(frozen=True, slots=True)
class EventEntry:
    """A recorded event, its content still on the disk."""

    seq: int
    utc_s: float
    kind: EventKind


class MissionReader:
    """A mission folder, opened for reading; a context manager.

    Every method shows what is committed at that moment.

    Args:
        folder: the mission's own folder, which holds ``mission.sqlite``.

    Raises:
        InputDataError: the folder holds no mission, or one that this version cannot read.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        if not (folder / DATABASE_NAME).is_file():
            raise InputDataError(f"{folder} is not a mission folder: it contains no {DATABASE_NAME}")
        self._connection, self._version = open_database(folder / DATABASE_NAME)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the database."""
        self._connection.close()

    @property
    def folder(self) -> Path:
        """The mission's folder."""
        return self._folder

    def manifest(self) -> dict[str, object]:
        """Return the configuration and versions that the mission was started with."""
        path = self._folder / MANIFEST_NAME
        try:
            manifest = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, *DAMAGE) as error:
            raise InputDataError(f"cannot read {path}: {error}") from error
        if not isinstance(manifest, dict):
            raise InputDataError(f"cannot read {path}: it is not a JSON object")
        return manifest

    def events(self, kind: EventKind | None = None) -> Iterator[Event]:
        """Go through the events, oldest first; those of one kind, or all."""
        query = "SELECT * FROM events WHERE ?1 IS NULL OR kind = ?1 ORDER BY seq"
        yield from self._events(query, None if kind is None else kind.value)

    def _events(self, query: str, *values: object) -> Iterator[Event]:
        for row in self._rows(query, *values):
            with self._explained(f"event {row['seq']}"):
                row_kind = EventKind(row["kind"])
                data = decode(EVENT_TYPES[row_kind], upgraded(self._version, row_kind, json.loads(row["data"])))
                event = Event(row["seq"], time_s(row), row_kind, data)
            yield event

    def event_index(self) -> tuple[EventEntry, ...]:
        """Return number, time and kind of all events, without their content."""
        rows = self._rows("SELECT seq, utc_s, kind FROM events ORDER BY seq")
        with self._explained("events"):
            return tuple(EventEntry(row["seq"], time_s(row), EventKind(row["kind"])) for row in rows)

    def event(self, seq: int) -> Event:
        """Return one event.

        Raises:
            InputDataError: there is none of that number.
        """
        for event in self._events("SELECT * FROM events WHERE seq = ?", seq):
            return event
        raise InputDataError(f"{self._folder} has no event {seq}")

    def phases(self) -> tuple[tuple[float, Phase], ...]:
        """Return when each phase began, as of the first recorded snapshot in it: UTC seconds."""
        query = "SELECT utc_s, json_extract(data, '$.phase') AS phase FROM events WHERE kind = ? ORDER BY seq"
        found: list[tuple[float, Phase]] = []
        for row in self._rows(query, EventKind.SNAPSHOT.value):
            with self._explained("phase"):
                utc_s, phase = time_s(row), Phase(row["phase"])
            if not found or found[-1][1] is not phase:
                found.append((utc_s, phase))
        return tuple(found)

    def picture(self, step: int, kind: PictureKind) -> bytes | None:
        """Return a raster as it was shown, a PNG; None where it was not recorded."""
        try:
            return (self._folder / picture_path(step, kind)).read_bytes()
        except OSError:
            return None

    def last_snapshot(self) -> MissionSnapshot | None:
        """Return the latest recorded state of the whole mission."""
        event = self.last_snapshot_event()
        return event.data if event is not None and isinstance(event.data, MissionSnapshot) else None

    def last_snapshot_event(self) -> Event | None:
        """Return the event with the latest recorded state of the whole mission."""
        query = "SELECT * FROM events WHERE kind = ? ORDER BY seq DESC LIMIT 1"
        return next(self._events(query, EventKind.SNAPSHOT.value), None)

    def steps(self) -> tuple[StepRecord, ...]:
        """Return all steps, oldest first."""
        return tuple(
            self._decoded(row["record"], StepRecord, f"step {row['step']}")
            for row in self._rows("SELECT step, record FROM steps ORDER BY step")
        )

    def step(self, step: int) -> StepRecord:
        """Return one step.

        Raises:
            InputDataError: there is none of that number.
        """
        record = self._first("SELECT record FROM steps WHERE step = ?", "record", StepRecord, step)
        if record is None:
            raise InputDataError(f"{self._folder} has no step {step}")
        return record

    def strategy_state(self, step: int) -> dict[str, object]:
        """Return what the strategy's decision of a step depends on, as plain data; ``codec.decode`` gives it its types.

        Raises:
            InputDataError: there is no such step.
        """
        state = self._first("SELECT strategy_state FROM steps WHERE step = ?", "strategy_state", dict[str, Any], step)
        if state is None:
            raise InputDataError(f"{self._folder} has no step {step}")
        return state

    @property
    def has_decisions(self) -> bool:
        """Whether the record holds what its decisions depended on: older ones do not."""
        return self._version >= FIRST_WITH_DECISIONS

    def search(self) -> SearchRecord | None:
        """Return what all steps have in common; None before the first step.

        Raises:
            InputDataError: the record is damaged, or older than these records.
        """
        return self._first("SELECT record FROM searches ORDER BY id DESC LIMIT 1", "record", SearchRecord)

    def decision(self, step: int) -> tuple[DecisionRecord, ConclusionRecord | None] | None:
        """Return a step's decision and what was concluded after it, each None where it is not in the record.

        Raises:
            InputDataError: the record is damaged, or older than these records.
        """
        for row in self._rows("SELECT record, conclusion FROM decisions WHERE step = ?", step):
            decision = self._decoded(row["record"], DecisionRecord, f"decision of step {step}")
            text = row["conclusion"]
            what = f"conclusion of step {step}"
            return decision, None if text is None else self._decoded(text, ConclusionRecord, what)
        return None

    def frames(self, step: int | None = None) -> tuple[FrameEntry, ...]:
        """Return the frames of a step or of the whole mission, by step and vehicle; images are read by ``load``."""
        query = "SELECT * FROM frames WHERE ?1 IS NULL OR step = ?1 ORDER BY step, vehicle_id, id"
        rows = self._rows(query, step)
        with self._explained("frames"):
            return tuple(self._frame(row) for row in rows)

    def newest_frames(self, after: int = 0, until_utc_s: float | None = None) -> tuple[FrameEntry, ...]:
        """Return the newest frame of each vehicle among those after a number, and exposed until a time if given."""
        query = (
            "SELECT * FROM frames WHERE id IN (SELECT max(id) FROM frames"
            " WHERE id > ?1 AND (?2 IS NULL OR utc_s <= ?2) GROUP BY vehicle_id) ORDER BY vehicle_id"
        )
        rows = self._rows(query, after, until_utc_s)
        with self._explained("frames"):
            return tuple(self._frame(row) for row in rows)

    def frame(self, number: int) -> FrameEntry:
        """Return one frame.

        Raises:
            InputDataError: there is none of that number.
        """
        for row in self._rows("SELECT * FROM frames WHERE id = ?", number):
            with self._explained("frame"):
                return self._frame(row)
        raise InputDataError(f"{self._folder} has no frame {number}")

    def _frame(self, row: sqlite3.Row) -> FrameEntry:
        names = row.keys()
        sigma_s = typed(row, "time_sigma_s", int, float, NoneType) if "time_sigma_s" in names else None
        digest = typed(row, "digest", str) if "digest" in names else None
        step, vehicle_id = typed(row, "step", int), typed(row, "vehicle_id", int)
        return FrameEntry(step, vehicle_id, self._path(row), sigma_s, digest, row)

    def _path(self, row: sqlite3.Row) -> Path:
        """Return the file of a frame, which lies in this folder whatever the row says."""
        relative = PurePosixPath(row["path"])
        if relative.is_absolute() or ".." in relative.parts:
            raise ValueError(f"the path {relative} leads out of the mission's folder")
        return self._folder / relative

    def settings(self) -> tuple[SettingsRecord, ...]:
        """Return which settings of vehicles were changed for the mission and set back, oldest first."""
        if self._version < FIRST_WITH_SETTINGS:
            return ()
        return tuple(
            self._decoded(row["record"], SettingsRecord, f"settings {row['id']}")
            for row in self._rows("SELECT id, record FROM settings ORDER BY id")
        )

    def actions(self) -> tuple[ActionRecord, ...]:
        """Return the audit log, oldest entry first."""
        return tuple(
            self._decoded(row["record"], ActionRecord, f"action {row['id']}")
            for row in self._rows("SELECT id, record FROM actions ORDER BY id")
        )

    def outcome(self) -> OutcomeRecord | None:
        """Return how the mission has ended; None while it goes on, and when its program was killed."""
        for row in self._rows("SELECT * FROM outcome"):
            with self._explained("outcome"):
                return OutcomeRecord(time_s(row), Outcome(row["outcome"]), json.loads(row["summary"]))
        return None

    def _first(self, query: str, column: str, hint: type[T], *values: object) -> T | None:
        for row in self._rows(query, *values):
            return self._decoded(row[column], hint, column)
        return None

    def _decoded(self, text: str, hint: type[T], what: str) -> T:
        with self._explained(what):
            return decode(hint, json.loads(text))

    def _rows(self, query: str, *values: object) -> list[sqlite3.Row]:
        try:
            return self._connection.execute(query, values).fetchall()
        except SQLITE_DAMAGE as error:
            raise InputDataError(f"{self._folder / DATABASE_NAME} is damaged: {error}") from error

    @contextmanager
    def _explained(self, what: str) -> Iterator[None]:
        try:
            yield
        except DAMAGE as error:
            raise InputDataError(f"{self._folder / DATABASE_NAME}: {what} cannot be read: {error}") from error
