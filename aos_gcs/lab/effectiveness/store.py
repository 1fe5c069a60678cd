"""The study of effectiveness in a folder: results so far, so that a run that was broken off goes on."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.imaging.persons.evidence import Evidence
from aos_gcs.lab.effectiveness.report import Decision
from aos_gcs.lab.effectiveness.study import Anomaly, SceneKey, SceneResult, StudySettings, WarmBody
from aos_gcs.lab.scenes import Body, PositionGrade

SETTINGS_FILE = "study.json"
SCENES_FILE = "scenes.jsonl"
DECISIONS_FILE = "decisions.csv"
SUMMARY_FILE = "summary.md"


class StudyFolder:
    """One line per finished scene is appended as it comes; a line that a crash has cut is flown again."""

    def __init__(self, path: Path, settings: StudySettings) -> None:
        """Open a folder, or make it.

        Raises:
            ConfigurationError: if it holds a study with other settings, or something else, or cannot be written.
        """
        self.path = path
        expected = json.dumps(asdict(settings), indent=1) + "\n"
        settings_file = path / SETTINGS_FILE
        try:
            path.mkdir(parents=True, exist_ok=True)
            if not settings_file.exists() and any(path.iterdir()):
                raise ConfigurationError(f"The folder {path} holds something else; name an empty or a new one.")
            if not settings_file.exists():
                settings_file.write_text(expected, encoding="utf-8")
            elif settings_file.read_text(encoding="utf-8") != expected:
                raise ConfigurationError(f"The folder {path} holds a study with other settings; name another one.")
            _drop_cut_line(path / SCENES_FILE)
        except OSError as error:
            raise ConfigurationError(f"Cannot use the folder {path}: {error.strerror or error}.") from error

    def append(self, result: SceneResult) -> None:
        """Write down a finished scene."""
        with (self.path / SCENES_FILE).open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(result)) + "\n")

    def results(self) -> list[SceneResult]:
        """Return the scenes so far, in the order of their density, seed and kind."""
        return read_results(self.path)

    def write_decisions(self, decisions: Sequence[Decision]) -> None:
        """Write one row per scene and grade of positions."""
        with (self.path / DECISIONS_FILE).open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, [field.name for field in fields(Decision)])
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
    file = folder / SCENES_FILE
    if not file.exists():
        return []
    results = {}
    for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(keepends=True), start=1):
        if not line.endswith("\n"):
            break
        try:
            result = _parse(json.loads(line))
        except (ValueError, KeyError, TypeError) as error:
            raise InputDataError(f"Line {number} of {file} is damaged ({error}); delete it.") from error
        results[result.key] = result
    return [results[key] for key in sorted(results)]


def missing(keys: Iterable[SceneKey], results: Iterable[SceneResult]) -> list[SceneKey]:
    """Return the keys of the scenes that are still to be flown."""
    done = {result.key for result in results}
    return [key for key in keys if key not in done]


def _drop_cut_line(file: Path) -> None:
    """Cut off what a killed run has left of a line, so that what is appended stands in a line of its own."""
    if file.exists():
        content = file.read_bytes()
        file.write_bytes(content[: content.rfind(b"\n") + 1])


def _parse(table: dict[str, Any]) -> SceneResult:
    warm = {
        PositionGrade(grade): tuple(
            WarmBody(Evidence(**body["evidence"]), tuple(body["position_enu_m"]), body["sigma_m"]) for body in bodies
        )
        for grade, bodies in table["warm"].items()
    }
    anomalies = {
        PositionGrade(grade): tuple(
            None if one is None else Anomaly(one["area_m2"], tuple(one["position_enu_m"])) for one in steps
        )
        for grade, steps in table["anomalies"].items()
    }
    bodies = tuple(Body(body["kind"], tuple(body["position_enu_m"])) for body in table["bodies"])
    return SceneResult(SceneKey(**table["key"]), bodies, table["approached"], anomalies, warm)
