"""Tells whether the record of a mission has changed, without opening it."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from aos_gcs.store.schema import DATABASE_NAME

_LOG_SUFFIX: Final = "-wal"
"""Ending of the file beside the database to which SQLite appends what is committed."""

_Mark = tuple[int, int]
"""Size in bytes and time of the last change in nanoseconds."""


class RecordChanges:
    """Compares sizes and times of a record's files with those that were seen before."""

    def __init__(self) -> None:
        self._seen: tuple[Path, _Mark | None, _Mark | None] | None = None
        self._is_settled = False

    def may_have_come(self, folder: Path) -> bool:
        """Return whether the record may hold more than it did at the calls before; ask before it is read.

        Once more after each change, too: what is written within the same tick of the file system's clock leaves the
        same time. Calls are therefore further apart than such a tick, 10 ms.
        """
        database = folder / DATABASE_NAME
        now = folder, _mark(database), _mark(database.with_name(database.name + _LOG_SUFFIX))
        has_changed = now != self._seen
        may_have_come = has_changed or not self._is_settled
        self._seen, self._is_settled = now, not has_changed
        return may_have_come


def _mark(path: Path) -> _Mark | None:
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_size, status.st_mtime_ns
