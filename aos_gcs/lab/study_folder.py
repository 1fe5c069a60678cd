"""Folder of a study: its settings, and a line per finished result, so that a run that was broken off goes on."""

from __future__ import annotations

import json
from collections.abc import Callable, Hashable
from dataclasses import MISSING, asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from aos_gcs.errors import ConfigurationError, InputDataError

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Result = TypeVar("Result")

SETTINGS_FILE = "study.json"


class ResultLines:
    """One line per finished result is appended as it comes; a line that a crash has cut is computed again."""

    def __init__(self, path: Path, settings: DataclassInstance, lines_name: str) -> None:
        """Open a folder, or make it.

        Raises:
            ConfigurationError: if it holds a study with other settings, or something else, or cannot be written.
        """
        self.path = path
        self._lines = path / lines_name
        expected = json.dumps(asdict(settings), indent=1) + "\n"
        settings_file = path / SETTINGS_FILE
        try:
            path.mkdir(parents=True, exist_ok=True)
            if not settings_file.exists() and any(path.iterdir()):
                raise ConfigurationError(f"The folder {path} holds something else; name an empty or a new one.")
            if not settings_file.exists():
                settings_file.write_text(expected, encoding="utf-8")
            elif not _has_settings(settings_file.read_text(encoding="utf-8"), settings):
                raise ConfigurationError(f"The folder {path} holds a study with other settings; name another one.")
            _drop_cut_line(self._lines)
        except OSError as error:
            raise ConfigurationError(f"Cannot use the folder {path}: {error.strerror or error}.") from error

    def append_line(self, result: DataclassInstance) -> None:
        """Write down a finished result."""
        with self._lines.open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(result)) + "\n")


def _has_settings(text: str, settings: DataclassInstance) -> bool:
    """Whether a folder's settings are these; fields that older versions lack have had their defaults."""
    defaults = {field.name: field.default for field in fields(settings) if field.default is not MISSING}
    try:
        return bool({**defaults, **json.loads(text)} == json.loads(json.dumps(asdict(settings))))
    except (ValueError, TypeError):
        return False


def read_lines(
    file: Path, parse: Callable[[Any], Result], key_of: Callable[[Result], Hashable]
) -> dict[Hashable, Result]:
    """Return the results of a file of lines by their keys, the latest of each; none without the file.

    Args:
        file: written by :class:`ResultLines`.
        parse: makes a result of the parsed line.
        key_of: returns the key of a result.

    Raises:
        InputDataError: if a line cannot be read. A last one that a killed run has cut is left out.
    """
    if not file.exists():
        return {}
    results: dict[Hashable, Result] = {}
    for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(keepends=True), start=1):
        if not line.endswith("\n"):
            break
        try:
            result = parse(json.loads(line))
        except (ValueError, KeyError, TypeError) as error:
            raise InputDataError(f"Line {number} of {file} is damaged ({error}); delete it.") from error
        results[key_of(result)] = result
    return results


def _drop_cut_line(file: Path) -> None:
    """Cut off what a killed run has left of a line, so that what is appended stands in a line of its own."""
    if file.exists():
        content = file.read_bytes()
        file.write_bytes(content[: content.rfind(b"\n") + 1])
