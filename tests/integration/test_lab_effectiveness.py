"""The study of effectiveness from the command line, with a small swarm in a sparse forest."""

import csv
from pathlib import Path

import pytest
from typer.testing import CliRunner

from aos_gcs.cli.lab import lab
from aos_gcs.errors import ConfigurationError
from aos_gcs.lab.effectiveness.report import ClaimResult, Rule, decide
from aos_gcs.lab.effectiveness.store import DECISIONS_FILE, SCENES_FILE, SUMMARY_FILE, read_results
from aos_gcs.lab.effectiveness.study import SceneKey, StudySettings, study_scene, study_scenes
from aos_gcs.lab.scenes import PositionGrade

SMALL = StudySettings(vehicles=4, image_size_px=256, imaging_steps=1)
WITH, WITHOUT = SceneKey(20.0, 1, has_person=True), SceneKey(20.0, 2, has_person=False)


def test_a_person_in_a_sparse_forest_is_found_where_it_is() -> None:
    result = study_scene(WITH, SMALL)
    assert result.approached is not None
    assert result.approached.startswith("person")
    decision = decide(result, PositionGrade.RTK, Rule.PERSON)
    assert decision.claim_result is ClaimResult.HIT
    assert decision.error_m < 2.0


def test_without_a_person_none_is_claimed() -> None:
    assert decide(study_scene(WITHOUT, SMALL), PositionGrade.GNSS, Rule.PERSON).claim_result is ClaimResult.CLEAR


@pytest.mark.slow
def test_processes_change_nothing() -> None:
    alone = {result.key: result for result in study_scenes([WITH, WITHOUT], SMALL, jobs=1)}
    together = {result.key: result for result in study_scenes([WITH, WITHOUT], SMALL, jobs=2)}
    assert alone == together


def test_the_command_writes_its_results_and_goes_on(tmp_path: Path) -> None:
    out = tmp_path / "study"
    arguments = ["effectiveness", "--out", str(out), "--densities", "20", "--vehicles", "2", "--image-size", "128"]
    first = CliRunner().invoke(lab, [*arguments, "--scenes", "1"], catch_exceptions=False)
    assert first.exit_code == 0
    lines = (out / SCENES_FILE).read_text(encoding="utf-8")
    again = CliRunner().invoke(lab, [*arguments, "--scenes", "1"], catch_exceptions=False)
    assert again.exit_code == 0
    assert (out / SCENES_FILE).read_text(encoding="utf-8") == lines
    assert (out / SUMMARY_FILE).read_text(encoding="utf-8") in again.stdout
    with (out / DECISIONS_FILE).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2 * len(Rule) * len(PositionGrade)
    assert {(row["seed"], row["grade"], row["rule"]) for row in rows} >= {
        ("0", "gnss", "person"),
        ("1", "rtk", "anomaly"),
    }
    assert len(read_results(out)) == 2


@pytest.mark.parametrize(
    ("option", "value", "named"), [("--scenes", "0", "--scenes"), ("--densities", "many", "--densities")]
)
def test_bad_options_are_named(option: str, value: str, named: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=named):
        CliRunner().invoke(
            lab, ["effectiveness", "--out", str(tmp_path / "study"), option, value], catch_exceptions=False
        )
    assert not (tmp_path / "study").exists()
