"""Tiles that a download has so far, in a file beside the map that is to be made of them."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, Final

from aos_gcs.basemaps.archive import TileFormat
from aos_gcs.errors import InputDataError

Place = tuple[int, int, int]
"""Zoom, column and row of a tile; rows count from the north."""

ENDING: Final = ".download"
"""Added to the name of the map."""
_VERSION: Final = 1
_TABLES: Final = """
CREATE TABLE IF NOT EXISTS source (fingerprint TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS tiles (
  zoom INTEGER, x INTEGER, y INTEGER, kind TEXT, content BLOB, PRIMARY KEY (zoom, x, y)
) WITHOUT ROWID;
"""


class TileStore:
    """Tiles of one server. Each is kept as soon as it is added."""

    def __init__(self, connection: sqlite3.Connection, path: Path) -> None:
        self._connection, self._path = connection, path

    def require(self, fingerprint: str) -> None:
        """Refuse tiles of another server; a new store becomes one of this server.

        Args:
            fingerprint: what its template is known by.

        Raises:
            InputDataError: they are, or the file is damaged or in use.
        """
        list(self._run("PRAGMA locking_mode = EXCLUSIVE"))
        ((version,),) = self._run("PRAGMA user_version")
        if version not in {0, _VERSION}:
            raise InputDataError(f"{self._path} is of another version of the program: delete it to start anew.")
        try:
            self._connection.executescript(_TABLES + f"PRAGMA user_version = {_VERSION};")
        except sqlite3.Error as error:
            raise self._damaged(error) from error
        known = [row[0] for row in self._run("SELECT fingerprint FROM source")]
        if not known:
            list(self._run("INSERT INTO source VALUES (?)", (fingerprint,)))
        elif known != [fingerprint]:
            raise InputDataError(
                f"{self._path} holds tiles that another address in --tiles has sent: delete it to start anew, or give "
                "the map another name."
            )

    def places(self) -> set[Place]:
        """Return the tiles that the server was asked for, also those that it does not have."""
        return set(self._run("SELECT zoom, x, y FROM tiles"))

    def add(self, place: Place, kind: TileFormat | None, content: bytes) -> None:
        """Keep a tile; ``kind`` is None for one that the server does not have."""
        values = (*place, None if kind is None else kind.value, content)
        list(self._run("INSERT INTO tiles VALUES (?, ?, ?, ?, ?)", values))

    def tiles(self) -> Iterator[tuple[Place, TileFormat, bytes]]:
        """Yield the tiles that the server has."""
        for zoom, column, row, kind, content in self._run("SELECT * FROM tiles WHERE kind IS NOT NULL"):
            yield (zoom, column, row), TileFormat(kind), content

    def _run(self, statement: str, values: tuple[object, ...] = ()) -> Iterator[tuple[Any, ...]]:
        try:
            yield from self._connection.execute(statement, values)
        except sqlite3.Error as error:
            raise self._damaged(error) from error

    def _damaged(self, error: sqlite3.Error) -> InputDataError:
        return InputDataError(
            f"{self._path} cannot be used ({error}): another download uses it, its disk is full, or it is damaged; "
            "delete it to start anew."
        )


def store_of(out: Path) -> Path:
    """Return the file that keeps the tiles of a map until the map is complete."""
    return out.with_name(out.name + ENDING)


@contextmanager
def tile_store(out: Path, fingerprint: str) -> Iterator[TileStore]:
    """Open the tiles of a map so far; the file is deleted when the context is left without an error, or without a tile.

    Args:
        out: map that is to be made.
        fingerprint: what the server's template is known by.

    Raises:
        InputDataError: the file cannot be written, holds tiles of another server, is damaged or in use.
    """
    path = store_of(out)
    try:
        # Autocommit: a tile is kept at once. A lock of another download is not waited for.
        connection = sqlite3.connect(path, timeout=0.0, isolation_level=None)
    except sqlite3.Error as error:
        raise InputDataError(f"{path} cannot be written ({error}): check the folder.") from error
    with closing(connection):
        store = TileStore(connection, path)
        store.require(fingerprint)
        try:
            yield store
        except BaseException:
            if not store.places():
                path.unlink()
            raise
    path.unlink()
