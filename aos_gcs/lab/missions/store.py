"""The study of missions in a folder: a line per mission that has ended."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from aos_gcs.errors import ConfigurationError
from aos_gcs.lab.missions.model import MissionKey, MissionResult, MissionsSettings
from aos_gcs.lab.study_folder import SETTINGS_FILE, ResultLines, read_lines

MISSIONS_FILE = "missions.jsonl"
SUMMARY_FILE = "summary.md"


class MissionsFolder(ResultLines):
    """Settings, missions and figures of a study; a mission of which a crash has cut the line is flown again."""

    def __init__(self, path: Path, settings: MissionsSettings) -> None:
        """Open a folder, or make it; see :class:`~aos_gcs.lab.study_folder.ResultLines`."""
        super().__init__(path, settings, MISSIONS_FILE)

    def append(self, result: MissionResult) -> None:
        """Write down a mission that has ended."""
        self.append_line(result)

    def results(self) -> list[MissionResult]:
        """Return the missions so far, in the order of their keys.

        Raises:
            InputDataError: a line is damaged.
        """
        return _results(self.path)

    def write_summary(self, text: str) -> None:
        """Write the table of figures."""
        (self.path / SUMMARY_FILE).write_text(text, encoding="utf-8")


def reference_missions(path: Path, settings: MissionsSettings) -> tuple[str, list[MissionResult]]:
    """Return the name and the missions of another study, with which one of these settings can be compared.

    Raises:
        ConfigurationError: it holds no study, or one of other settings than these.
        InputDataError: a line is damaged.
    """
    try:
        reference = MissionsSettings(**json.loads((path / SETTINGS_FILE).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError) as error:
        raise ConfigurationError(f"--reference {path} holds no study of missions ({error}).") from error
    varied = {name: getattr(settings, name) for name in ("strategy", "search_mode", "surface", "looks", "legs")}
    if replace(reference, **varied) != settings:
        raise ConfigurationError(
            f"--reference {path} was flown with other settings ({reference}); only strategy, search mode, "
            "surface, looks and legs may differ."
        )
    return reference.name, _results(path)


def _results(path: Path) -> list[MissionResult]:
    results = read_lines(path / MISSIONS_FILE, _parse, lambda result: result.key)
    return sorted(results.values(), key=lambda result: result.key)


def _parse(table: dict[str, Any]) -> MissionResult:
    lists = {name: tuple(value) for name, value in table.items() if isinstance(value, list)}
    return MissionResult(**{**table, **lists, "key": MissionKey(**table["key"])})
