"""Plans that operators keep: one JSON file each."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from aos_gcs.errors import InputDataError, RecordingError

_NAME = re.compile(r"\w(?:[\w .-]{0,48}\w)?")
_SUFFIX = ".json"


@dataclass(frozen=True, slots=True)
class PlanEntry:
    """A plan in the folder."""

    name: str
    saved_utc_s: float


class PlanFolder:
    """A folder of plans; made when the first one is written.

    Args:
        folder: where they are.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def entries(self) -> tuple[PlanEntry, ...]:
        """Return what there is, by name."""
        found = (path for path in self._folder.glob(f"*{_SUFFIX}") if _NAME.fullmatch(path.stem))
        return tuple(PlanEntry(path.stem, path.stat().st_mtime) for path in sorted(found))

    def read(self, name: str) -> str | None:
        """Return the text of a plan; None if there is none of that name.

        Raises:
            InputDataError: the name is none for a plan, or its file cannot be read.
        """
        path = self._path(name)
        try:
            return path.read_text(encoding="utf-8")
        except FileNotFoundError:
            return None
        except (OSError, UnicodeDecodeError) as error:
            raise InputDataError(f"The plan {path} cannot be read: {error}.") from error

    def write(self, name: str, text: str) -> None:
        """Keep a plan; one of the same name is replaced, as a whole or not at all.

        Raises:
            InputDataError: the name is none for a plan.
            RecordingError: the folder cannot be written.
        """
        path = self._path(name)
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            part = path.with_name(f".{path.name}.part")
            part.write_text(text, encoding="utf-8")
            part.replace(path)
        except OSError as error:
            text = f"The plan cannot be saved as {path}: {error}; make room or check the disk."
            raise RecordingError(text) from error

    def delete(self, name: str) -> bool:
        """Remove a plan; return whether there was one.

        Raises:
            InputDataError: the name is none for a plan.
        """
        path = self._path(name)
        if not path.exists():
            return False
        path.unlink(missing_ok=True)
        return True

    def _path(self, name: str) -> Path:
        if not _NAME.fullmatch(name):
            raise InputDataError(
                f"'{name}' is no name for a plan; use up to 50 letters, digits, spaces, points, '-' and '_'."
            )
        return self._folder / f"{name}{_SUFFIX}"
