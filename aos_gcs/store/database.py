"""Blocking writes into a mission folder; called from the recorder's thread alone."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from aos_gcs.mission.model.actions import ActionRecord
from aos_gcs.mission.model.decisions import ConclusionRecord, DecisionRecord, SearchRecord
from aos_gcs.mission.model.events import Event
from aos_gcs.mission.model.phase import OutcomeRecord
from aos_gcs.mission.model.steps import Picture, StepRecord
from aos_gcs.mission.model.vehicles import SettingsRecord
from aos_gcs.store.audit import ACTION, CHAINED_EVENTS, EVENT, MANIFEST, append_entry, is_chained
from aos_gcs.store.codec import dump
from aos_gcs.store.frame_files import FrameRow
from aos_gcs.store.lasting_files import replace_file
from aos_gcs.store.schema import (
    DATABASE_NAME,
    FRAMES_NAME,
    MANIFEST_NAME,
    MAVLINK_NAME,
    PICTURES_NAME,
    SCHEMA_VERSION,
    TABLES,
    picture_path,
)

Write = Callable[["MissionDatabase"], None]


class MissionDatabase:
    """The files of one mission, being written."""

    def __init__(self, folder: Path, manifest: Mapping[str, object]) -> None:
        folder.mkdir(parents=True)
        try:
            for name in (FRAMES_NAME, PICTURES_NAME, MAVLINK_NAME):
                (folder / name).mkdir()
            content = dump(manifest, indent=2) + "\n"
            replace_file(folder / MANIFEST_NAME, content.encode())
            self._connect(folder)
            self._connection.executescript(f"BEGIN; {TABLES} PRAGMA user_version = {SCHEMA_VERSION}; COMMIT;")
            self._is_chained = True
            append_entry(self._connection, MANIFEST, 0, None, content)
        except BaseException:
            # A folder without its tables is no mission, and would be in the way of the next attempt.
            shutil.rmtree(folder, ignore_errors=True)
            raise

    @classmethod
    def reopen(cls, folder: Path, last_step: int) -> MissionDatabase:
        """Return the files of a mission that is in the folder already, to be continued after a step.

        What was recorded of later steps, which nobody was told of, is removed.

        Raises:
            sqlite3.Error: the database cannot be opened.
        """
        database = cls.open_ended(folder)
        database.write([lambda opened: opened.remove_after(last_step)])
        return database

    @classmethod
    def open_ended(cls, folder: Path) -> MissionDatabase:
        """Return the files of a mission that is in the folder already, with all that was recorded.

        Raises:
            sqlite3.Error: the database cannot be opened.
        """
        database = cls.__new__(cls)
        database._connect(folder)  # noqa: SLF001 - its own
        return database

    def _connect(self, folder: Path) -> None:
        self._folder = folder
        self._connection = sqlite3.connect(folder / DATABASE_NAME, isolation_level=None)
        # WAL: readers never wait and a killed writer leaves every committed row; FULL: a field laptop may lose power
        self._connection.execute("PRAGMA journal_mode = WAL")
        self._connection.execute("PRAGMA synchronous = FULL")
        # The record of an older version that is continued has no chain, and does not get one for its second half.
        self._is_chained = is_chained(self._connection)

    def write(self, writes: Sequence[Write]) -> None:
        """Carry the writes out in one transaction.

        Raises:
            OSError: a file cannot be written.
            sqlite3.Error: the database cannot be written; none of the rows is there.
        """
        self._connection.execute("BEGIN")
        try:
            for write in writes:
                write(self)
            self._connection.execute("COMMIT")
        except BaseException:
            if self._connection.in_transaction:  # SQLite has rolled back itself when the disk is full
                self._connection.execute("ROLLBACK")
            raise

    def add_event(self, event: Event) -> None:
        """Add a row to the events."""
        data = dump(event.data)
        self._execute("INSERT INTO events (seq, utc_s, kind, data)", event.seq, event.utc_s, event.kind.value, data)
        if event.kind in CHAINED_EVENTS:
            self._chain(EVENT, event.seq, event.utc_s, data)

    def add_step(self, record: StepRecord, strategy_state: Mapping[str, object]) -> None:
        """Add a row to the steps, or replace the one of the same step."""
        self._execute(
            "INSERT OR REPLACE INTO steps (step, record, strategy_state)",
            record.step,
            dump(record),
            dump(strategy_state),
        )

    def add_search(self, record: SearchRecord) -> None:
        """Add a row to the searches."""
        self._execute("INSERT INTO searches (record)", dump(record))

    def add_decision(self, record: DecisionRecord) -> None:
        """Add a row to the decisions, or replace the one of the same step."""
        self._execute("INSERT OR REPLACE INTO decisions (step, record)", record.step, dump(record))

    def add_conclusion(self, record: ConclusionRecord) -> None:
        """Complete a row of the decisions."""
        self._connection.execute("UPDATE decisions SET conclusion = ? WHERE step = ?", (dump(record), record.step))

    def add_action(self, record: ActionRecord) -> None:
        """Add a row to the audit log."""
        content = dump(record)
        number = self._execute("INSERT INTO actions (utc_s, record)", record.utc_s, content)
        self._chain(ACTION, number, record.utc_s, content)

    def add_settings(self, record: SettingsRecord) -> None:
        """Add a row to the settings of vehicles that were changed or set back."""
        self._execute("INSERT INTO settings (utc_s, record)", record.utc_s, dump(record))

    def add_outcome(self, record: OutcomeRecord) -> None:
        """Set the outcome, which is written once."""
        self._execute(
            "INSERT INTO outcome (id, utc_s, outcome, summary)",
            1,
            record.utc_s,
            record.outcome.value,
            dump(record.summary),
        )

    def add_frame(self, row: FrameRow) -> None:
        """Add a row to the frames, whose image file is on the disk already."""
        self._execute(
            "INSERT INTO frames (step, vehicle_id, image_index, utc_s, time_sigma_s, latitude_deg, longitude_deg,"
            " altitude_amsl_m, q_cam2enu_wxyz, R_cam2enu, camera, bands, dtype, path, digest)",
            *row.values,
        )

    def add_picture(self, picture: Picture) -> None:
        """Write the file of a raster; the event that has announced it says where it lies on the ground."""
        replace_file(self._folder / picture_path(picture.step, picture.kind), picture.png)

    def remove_after(self, step: int) -> None:
        """Remove the rows of later steps and their frames."""
        self._connection.execute("DELETE FROM frames WHERE step > ?", (step,))
        self._connection.execute("DELETE FROM steps WHERE step > ?", (step,))

    def close(self) -> None:
        """Make the database one plain file, which opens on a read-only medium too."""
        with suppress(sqlite3.OperationalError):  # somebody reads it at present; then it stays in WAL mode
            self._connection.execute("PRAGMA journal_mode = DELETE")
        self._connection.close()

    def _execute(self, insert_into: str, *values: object) -> int:
        """Insert a row and return its number."""
        marks = ", ".join("?" * len(values))
        return self._connection.execute(f"{insert_into} VALUES ({marks})", values).lastrowid or 0

    def _chain(self, source: str, row: int, utc_s: float, content: str) -> None:
        if self._is_chained:
            append_entry(self._connection, source, row, utc_s, content)
