"""Opens the database of a mission folder for reading, whoever writes it."""

from __future__ import annotations

import sqlite3
from pathlib import Path
from typing import Final

from aos_gcs.errors import InputDataError
from aos_gcs.store.schema import SCHEMA_VERSION
from aos_gcs.store.upgrade import OLDEST_VERSION

SQLITE_DAMAGE: Final = (sqlite3.Error, UnicodeDecodeError)
"""What SQLite raises; its messages quote what is damaged, which Python may not be able to decode."""


def open_database(database: Path) -> tuple[sqlite3.Connection, int]:
    """Return a connection that only reads, its rows by name, and the version of the layout.

    Raises:
        InputDataError: the file is damaged, no mission, or one that this version cannot read.
    """
    try:
        return _checked(sqlite3.connect(f"{database.resolve().as_uri()}?mode=ro", uri=True))
    except sqlite3.OperationalError as error:
        # A mission that was not closed keeps a log beside the database, which even a reader must be able to lock.
        text = f"{database} cannot be opened in place ({error}); copy the mission's folder and try there"
        raise InputDataError(text) from error
    except SQLITE_DAMAGE as error:
        raise InputDataError(f"{database} is damaged or not a mission: {error}") from error


def _checked(connection: sqlite3.Connection) -> tuple[sqlite3.Connection, int]:
    """Return the connection with the version of its layout."""
    connection.row_factory = sqlite3.Row
    try:
        (version,) = connection.execute("PRAGMA user_version").fetchone()
        (tables,) = connection.execute("SELECT count(*) FROM sqlite_schema WHERE name = 'steps'").fetchone()
    except SQLITE_DAMAGE:
        connection.close()
        raise
    if not OLDEST_VERSION <= version <= SCHEMA_VERSION or not tables:
        connection.close()
        raise sqlite3.DatabaseError(f"expected a mission of version {SCHEMA_VERSION} or below, found version {version}")
    return connection, version
