"""The audit chain: who did what when, each entry with the digest of all before it.

An entry stands for the manifest, for an operator's action, or for a notice or a plan of the event stream: notices tell
what operators have decided and what the mission has reported. Its digest is SHA-256 of the previous digest and of the
text of what it stands for, exactly as it is stored. Who changes, removes or inserts something has to compute all later
digests anew: a digest that was noted elsewhere then no longer fits.
"""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from typing import Final

from aos_gcs.errors import InputDataError
from aos_gcs.mission.model.events import EventKind
from aos_gcs.store.opening import SQLITE_DAMAGE, open_database
from aos_gcs.store.schema import DATABASE_NAME, MANIFEST_NAME

CHAINED_EVENTS: Final = (EventKind.NOTICE, EventKind.PLAN)
"""Events that the chain covers."""
MANIFEST, ACTION, EVENT = "manifest", "action", "event"
"""Sources of entries; an action has its ``id``, an event its ``seq``."""
DIGEST_DIGITS: Final = 64
LEAST_DIGITS: Final = 16
"""Number of digits of a digest that nobody meets by chance."""
_DIGEST: Final = re.compile(rf"[0-9a-f]{{{LEAST_DIGITS},{DIGEST_DIGITS}}}")
_KINDS: Final = ", ".join(f"'{kind.value}'" for kind in CHAINED_EVENTS)
_NEWEST: Final = "SELECT digest FROM audit ORDER BY entry DESC LIMIT 1"


@dataclass(frozen=True, slots=True)
class AuditEntry:
    """An entry that was verified."""

    entry: int
    """Counts from 1."""
    source: str
    row: int
    utc_s: float | None
    """None for the manifest."""
    digest: str


@dataclass(frozen=True, slots=True)
class AuditReport:
    """Result of a verification."""

    entries: tuple[AuditEntry, ...]
    """Entries that fit, up to the first that does not."""
    fault: str | None
    """First thing that does not fit, in words; None: the chain is intact."""

    @property
    def digest(self) -> str:
        """Digest of the last entry that fits, to be noted elsewhere; empty if there is none."""
        return self.entries[-1].digest if self.entries else ""


def parse_digest(text: str) -> str:
    """Return a digest that somebody has typed from paper, or its beginning, as hexadecimal digits.

    Capitals, and blanks, colons and hyphens between groups, do not matter.

    Raises:
        InputDataError: it has too few or too many digits, or is none.
    """
    digits = re.sub(r"[\s:-]", "", text).lower()
    if not _DIGEST.fullmatch(digits):
        raise InputDataError(
            f"audit digest: give the {DIGEST_DIGITS} hexadecimal digits that were noted, or the first "
            f"{LEAST_DIGITS} at least, not {text[:80]!r}"
        )
    return digits


def noted_entry(report: AuditReport, noted: str) -> AuditEntry | None:
    """Return the entry whose digest was noted; None where none of those that fit has it.

    Args:
        report: verification of the chain.
        noted: digest or its beginning, of ``parse_digest``.
    """
    return next((entry for entry in report.entries if entry.digest.startswith(noted)), None)


def is_chained(connection: sqlite3.Connection) -> bool:
    """Return whether a database has a chain: those of older versions have none."""
    query = "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name = 'audit'"
    return bool(connection.execute(query).fetchone()[0])


def append_entry(connection: sqlite3.Connection, source: str, row: int, utc_s: float | None, content: str) -> None:
    """Append an entry, in the transaction that writes what it stands for."""
    newest = connection.execute(_NEWEST).fetchone()
    digest = entry_digest("" if newest is None else newest[0], source, row, utc_s, content)
    connection.execute("INSERT INTO audit (source, source_row, digest) VALUES (?, ?, ?)", (source, row, digest))


def entry_digest(previous: str, source: str, row: int, utc_s: float | None, content: str) -> str:
    """Return the digest of an entry, 64 hexadecimal digits; of the first one, the previous digest is empty."""
    moment = "" if utc_s is None else repr(float(utc_s))
    return sha256("\n".join((previous, source, str(row), moment, content)).encode()).hexdigest()


def verify_audit(folder: Path) -> AuditReport:
    """Compute the chain of a mission folder again, also of one that is being written.

    Raises:
        InputDataError: the folder holds no mission, its database is damaged, or it has no chain.
    """
    if not (folder / DATABASE_NAME).is_file():
        raise InputDataError(f"{folder} is not a mission folder: it contains no {DATABASE_NAME}")
    connection, _ = open_database(folder / DATABASE_NAME)
    try:
        connection.execute("BEGIN")  # of one moment, while somebody writes
        if not is_chained(connection):
            raise InputDataError(
                f"{folder} has no audit chain: an older version has recorded it; whether its audit log was changed "
                "cannot be told"
            )
        return _verified(connection, folder)
    except SQLITE_DAMAGE as error:
        raise InputDataError(f"{folder / DATABASE_NAME} is damaged: {error}") from error
    finally:
        connection.close()


def _verified(connection: sqlite3.Connection, folder: Path) -> AuditReport:
    entries: list[AuditEntry] = []
    try:
        for entry in _walk(connection, folder):
            entries.append(entry)
        _check_covered(connection)
    except _FaultError as fault:
        return AuditReport(tuple(entries), str(fault))
    return AuditReport(tuple(entries), None)


class _FaultError(Exception):
    """The chain does not fit; the text says where."""


def _walk(connection: sqlite3.Connection, folder: Path) -> Iterator[AuditEntry]:
    previous, expected = "", 1
    for row in connection.execute("SELECT entry, source, source_row, digest FROM audit ORDER BY entry"):
        if row["entry"] != expected:
            raise _FaultError(f"entry {expected} was removed")
        name = f"entry {expected} ({row['source']} {row['source_row']})"
        utc_s, content = _content(connection, folder, row["source"], row["source_row"], name)
        digest = entry_digest(previous, row["source"], row["source_row"], utc_s, content)
        if digest != row["digest"]:
            when = "" if utc_s is None else f" of {utc_text(utc_s)}"
            raise _FaultError(f"{name}{when} was changed, or its digest")
        yield AuditEntry(expected, row["source"], row["source_row"], utc_s, digest)
        previous, expected = digest, expected + 1
    if expected == 1:
        raise _FaultError("all entries were removed")


def _content(
    connection: sqlite3.Connection, folder: Path, source: str, number: int, name: str
) -> tuple[float | None, str]:
    """Return the time and the text of what an entry stands for, as they are stored."""
    if source == MANIFEST:
        try:
            return None, (folder / MANIFEST_NAME).read_text(encoding="utf-8")
        except (OSError, ValueError) as error:
            raise _FaultError(f"{name}: {MANIFEST_NAME} is missing or damaged") from error
    queries = {
        ACTION: "SELECT utc_s, record AS content FROM actions WHERE id = ?",
        EVENT: "SELECT utc_s, data AS content FROM events WHERE seq = ?",
    }
    if source not in queries:
        raise _FaultError(f"{name} was changed: there is no such source")
    row = connection.execute(queries[source], (number,)).fetchone()
    if row is None:
        raise _FaultError(f"{name}: what it stands for was removed")
    if not isinstance(row["utc_s"], float | int) or not isinstance(row["content"], str):
        raise _FaultError(f"{name} was changed: it has no time or no text")
    return row["utc_s"], row["content"]


def _check_covered(connection: sqlite3.Connection) -> None:
    """Refuse actions, notices and plans for which no entry stands, or more than one."""
    for source, table, number, condition in (
        (ACTION, "actions", "id", "1"),
        (EVENT, "events", "seq", f"kind IN ({_KINDS})"),
    ):
        query = (
            f"SELECT {number} AS number, (SELECT count(*) FROM audit WHERE source = ? AND source_row = {number}) AS "  # noqa: S608 - names of our own
            f"entries FROM {table} WHERE {condition} AND entries != 1 ORDER BY {number} LIMIT 1"
        )
        row = connection.execute(query, (source,)).fetchone()
        if row is not None:
            told = "was inserted: no entry stands for it" if row["entries"] == 0 else "stands in several entries"
            raise _FaultError(f"{source} {row['number']} {told}")


def utc_text(utc_s: float) -> str:
    """Return a time as operators read it, whatever a damaged record holds."""
    try:
        return f"{datetime.fromtimestamp(utc_s, UTC):%Y-%m-%d %H:%M:%S} UTC"
    except (ValueError, OverflowError, OSError):
        return "an impossible time"
