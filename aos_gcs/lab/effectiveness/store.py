"""The study of effectiveness in a folder: results so far, so that a run that was broken off goes on."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from aos_gcs.imaging.persons.evidence import Evidence
from aos_gcs.imaging.persons.form import Form
from aos_gcs.lab.effectiveness.report import SceneDecision
from aos_gcs.lab.effectiveness.study import Anomaly, SceneKey, SceneResult, StudySettings, WarmBody
from aos_gcs.lab.scenes import PositionGrade, SceneBody
from aos_gcs.lab.study_folder import ResultLines, read_lines

SCENES_FILE = "scenes.jsonl"
DECISIONS_FILE = "decisions.csv"
SUMMARY_FILE = "summary.md"


class StudyFolder(ResultLines):
    """Settings, scenes and figures of a study; a scene of which a crash has cut the line is flown again."""

    def __init__(self, path: Path, settings: StudySettings) -> None:
        """Open a folder, or make it; see :class:`~aos_gcs.lab.study_folder.ResultLines`."""
        super().__init__(path, settings, SCENES_FILE)

    def append(self, result: SceneResult) -> None:
        """Write down a finished scene."""
        self.append_line(result)

    def results(self) -> list[SceneResult]:
        """Return the scenes so far, in the order of their density, seed and kind."""
        return read_results(self.path)

    def write_decisions(self, decisions: Sequence[SceneDecision]) -> None:
        """Write one row per scene and grade of positions."""
        with (self.path / DECISIONS_FILE).open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, [field.name for field in fields(SceneDecision)])
            writer.writeheader()
            writer.writerows(asdict(decision) for decision in decisions)

    def write_summary(self, text: str) -> None:
        """Write the table of figures."""
        (self.path / SUMMARY_FILE).write_text(text, encoding="utf-8")


def read_results(folder: Path) -> list[SceneResult]:
    """Return the scenes of a study's folder, in the order of their density, seed and kind; none without a study.

    Raises:
        InputDataError: if a line cannot be read. A last one that a killed run has cut is left out.
    """
    results = read_lines(folder / SCENES_FILE, _parse, lambda result: result.key)
    return sorted(results.values(), key=lambda result: result.key)


def missing(keys: Iterable[SceneKey], results: Iterable[SceneResult]) -> list[SceneKey]:
    """Return the keys of the scenes that are still to be flown."""
    done = {result.key for result in results}
    return [key for key in keys if key not in done]


def _parse(table: dict[str, Any]) -> SceneResult:
    warm = {
        PositionGrade(grade): tuple(
            WarmBody(_evidence(body["evidence"]), tuple(body["position_enu_m"]), body["sigma_m"]) for body in bodies
        )
        for grade, bodies in table["warm"].items()
    }
    anomalies = {
        PositionGrade(grade): tuple(
            None if one is None else Anomaly(one["area_m2"], tuple(one["position_enu_m"])) for one in steps
        )
        for grade, steps in table["anomalies"].items()
    }
    bodies = tuple(SceneBody(body["kind"], tuple(body["position_enu_m"])) for body in table["bodies"])
    return SceneResult(SceneKey(**table["key"]), bodies, table["approached"], anomalies, warm)


def _evidence(table: dict[str, Any]) -> Evidence:
    form = table.get("form")
    return Evidence(**{**table, "form": None if form is None else Form(**form)})
