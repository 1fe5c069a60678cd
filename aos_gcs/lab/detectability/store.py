"""The study of detectability in a folder: a line per forest."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from aos_gcs.groundmap.detection import Posture
from aos_gcs.lab.detectability.study import DetectabilitySettings, ForestKey, WatchedForest, WatchedPerson
from aos_gcs.lab.study_folder import ResultLines, read_lines

FORESTS_FILE = "forests.jsonl"


class DetectabilityFolder(ResultLines):
    """Settings and forests of a study; a forest of which a crash has cut the line is watched again."""

    def __init__(self, path: Path, settings: DetectabilitySettings) -> None:
        """Open a folder, or make it; see :class:`~aos_gcs.lab.study_folder.ResultLines`."""
        super().__init__(path, settings, FORESTS_FILE)

    def append(self, forest: WatchedForest) -> None:
        """Write down a forest."""
        self.append_line(forest)

    def forests(self) -> list[WatchedForest]:
        """Return the forests so far, in the order of their keys.

        Raises:
            InputDataError: a line is damaged.
        """
        forests = read_lines(self.path / FORESTS_FILE, _parse, lambda forest: forest.key)
        return sorted(forests.values(), key=lambda forest: forest.key)


def _parse(table: dict[str, Any]) -> WatchedForest:
    return WatchedForest(ForestKey(**table["key"]), tuple(map(_parse_person, table["persons"])))


def _parse_person(table: dict[str, Any]) -> WatchedPerson:
    nested = {name: tuple(map(tuple, table[name])) for name in ("tangents", "marked")}
    flat = {name: tuple(table[name]) for name in ("seen_m2", "whole_m2")}
    return WatchedPerson(**{**table, **nested, **flat, "posture": Posture(table["posture"])})
