"""Saved plans: one JSON file each."""

from __future__ import annotations

import os
import re
import threading
import unicodedata
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from aos_gcs.errors import AosError, InputDataError, RecordingError

_NAME = re.compile(r"\w(?:[\w .-]{0,48}\w)?")
_SUFFIX = ".json"
NOTHING: Final = "none"
"""Version of a plan that does not exist."""


class PlanChangedError(AosError):
    """Another operator has saved, or removed, a plan in the meantime."""


@dataclass(frozen=True, slots=True)
class PlanEntry:
    """A plan in the folder."""

    name: str
    saved_utc_s: float
    version: str
    """Changes whenever the plan is saved."""


class PlanFolder:
    """A folder of plans; made when the first one is written.

    Args:
        folder: path of the folder.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._writing = threading.Lock()

    def entries(self) -> tuple[PlanEntry, ...]:
        """Return the plans, by name."""
        found = (path for path in self._folder.glob(f"*{_SUFFIX}") if _NAME.fullmatch(path.stem))
        return tuple(_entry(path.stem, path.stat()) for path in sorted(found))

    def read(self, name: str) -> str | None:
        """Return the text of a plan; None if there is none of that name.

        Raises:
            InputDataError: the name is not a valid plan name, or its file cannot be read.
        """
        path = self._path(name)
        try:
            return path.read_text(encoding="utf-8")
        except FileNotFoundError:
            return None
        except (OSError, UnicodeDecodeError) as error:
            raise InputDataError(f"The plan {path} cannot be read: {error}.") from error

    def write(self, name: str, text: str, replaces: str | None = None) -> None:
        """Save a plan; one of the same name is replaced, as a whole or not at all.

        Args:
            name: name of the plan.
            text: text of the plan.
            replaces: version of the plan that may be replaced, ``NOTHING`` for a new name; None: whatever is there.

        Raises:
            InputDataError: the name is not a valid plan name.
            PlanChangedError: there is another version than may be replaced.
            RecordingError: the folder cannot be written.
        """
        path = self._path(name)
        part = path.with_name(f".{path.name}.part")
        try:
            with self._writing:
                if replaces is not None:
                    _check_version(path, replaces)
                self._folder.mkdir(parents=True, exist_ok=True)
                part.write_text(text, encoding="utf-8")
                part.replace(path)
        except OSError as error:
            with suppress(OSError):
                part.unlink(missing_ok=True)
            text = f"The plan cannot be saved as {path}: {error}; free some space or check the disk."
            raise RecordingError(text) from error

    def delete(self, name: str) -> bool:
        """Remove a plan; return whether there was one.

        Raises:
            InputDataError: the name is not a valid plan name.
        """
        path = self._path(name)
        if not path.exists():
            return False
        path.unlink(missing_ok=True)
        return True

    def _path(self, name: str) -> Path:
        # The same letters, however they were typed: an umlaut may be one character or two.
        name = unicodedata.normalize("NFC", name)
        if not _NAME.fullmatch(name):
            raise InputDataError(
                f"'{name}' is not a valid plan name; use up to 50 letters, digits, spaces, points, '-' and '_'."
            )
        return self._folder / f"{name}{_SUFFIX}"


def _entry(name: str, status: os.stat_result) -> PlanEntry:
    return PlanEntry(name, status.st_mtime, f"{status.st_mtime_ns:x}-{status.st_size:x}")


def _check_version(path: Path, version: str) -> None:
    try:
        present = _entry(path.stem, path.stat()).version
    except FileNotFoundError:
        present = NOTHING
    if present == version:
        return
    if version == NOTHING:
        raise PlanChangedError(f"A plan named '{path.stem}' already exists. Choose another name, or replace it.")
    done = "removed" if present == NOTHING else "saved"
    raise PlanChangedError(
        f"The plan '{path.stem}' was {done} by another operator in the meantime. Review it, or save again."
    )
