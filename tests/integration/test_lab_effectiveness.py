"""The study of effectiveness from the command line, with a small swarm in a sparse forest."""

import csv
from pathlib import Path

import pytest
from typer.testing import CliRunner

from aos_gcs.cli.lab.commands import lab
from aos_gcs.errors import AosError, ConfigurationError
from aos_gcs.imaging.persons.classifier import fit_person_model, person_confidence, read_model
from aos_gcs.imaging.persons.evidence import Evidence
from aos_gcs.lab.effectiveness.report import ClaimResult, Rule, decide, labelled_bodies
from aos_gcs.lab.effectiveness.store import DECISIONS_FILE, SCENES_FILE, SUMMARY_FILE, StudyFolder, read_results
from aos_gcs.lab.effectiveness.study import SceneKey, SceneResult, StudySettings, WarmBody, study_scene, study_scenes
from aos_gcs.lab.scenes import PositionGrade, SceneBody

SMALL = StudySettings(vehicles=4, image_size_px=256, imaging_steps=1)
WITH, WITHOUT = SceneKey(20.0, 1, has_person=True), SceneKey(20.0, 2, has_person=False)


def test_a_person_in_a_sparse_forest_is_found_where_it_is_by_a_model_of_such_scenes() -> None:
    """The program's own model belongs to cameras that neither blur nor drift; docs/effectiveness.md has the figures."""
    others = [study_scene(SceneKey(20.0, seed, has_person=True), SMALL) for seed in (3, 4, 5, 6)]
    model = fit_person_model(*labelled_bodies(others))
    result = study_scene(WITH, SMALL)
    assert result.approached is not None
    assert result.approached.startswith("person")
    decision = decide(result, PositionGrade.RTK, Rule.PERSON, model)
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


def test_the_command_fits_a_model_of_persons_to_several_studies(tmp_path: Path) -> None:
    studies, model = (tmp_path / "day", tmp_path / "night"), tmp_path / "model.json"
    person, deer = Evidence(9, 8, 0.6, 0.8, 15.0, 20.0), Evidence(3, 2, 2.5, 0.1, 12.0, 14.0)
    folders = [StudyFolder(study, SMALL) for study in studies]
    for seed in range(6):
        place = (float(seed), 2.0)
        bodies = (WarmBody(person, place, 0.5), WarmBody(deer, (place[0] + 20.0, 2.0), 0.5))
        folders[seed % 2].append(
            SceneResult(
                key=SceneKey(300.0, seed, has_person=True),
                bodies=(SceneBody("person standing", place), SceneBody("deer", (place[0] + 20.0, 2.0))),
                approached=None,
                anomalies=dict.fromkeys(PositionGrade, ()),
                warm={PositionGrade.GNSS: (), PositionGrade.RTK: bodies},
            )
        )
    command = ["fit-person", *(word for study in studies for word in ("--study", str(study))), "--out", str(model)]
    done = CliRunner().invoke(lab, command, catch_exceptions=False)
    assert done.stdout == f"{model}: fitted to 6 persons and 6 other bodies\n"
    fitted = read_model(model)
    assert fitted.fitted_to == "6 scenes at 300 trees/ha, seeds 0 to 5"
    assert fitted.fitted_on
    assert person_confidence(person, fitted) > 0.7
    assert person_confidence(deer, fitted) < 0.2
    judged = CliRunner().invoke(lab, [*command, "--folds", "3"], catch_exceptions=False)
    assert judged.stdout.startswith(done.stdout)
    assert "| person | 300 | rtk | 6, 0 | 100.0 %" in judged.stdout


@pytest.mark.parametrize("folds", ["1", "-2"])
def test_one_part_alone_has_no_others_to_be_judged_by(folds: str, tmp_path: Path) -> None:
    command = ["fit-person", "--study", str(tmp_path), "--out", str(tmp_path / "model.json"), "--folds", folds]
    with pytest.raises(ConfigurationError, match="--folds"):
        CliRunner().invoke(lab, command, catch_exceptions=False)


def test_no_model_is_fitted_to_a_study_without_scenes(tmp_path: Path) -> None:
    command = ["fit-person", "--study", str(tmp_path / "none"), "--out", str(tmp_path / "model.json")]
    with pytest.raises(AosError, match=r"--study .*none holds no scenes: give the --out of aos-gcs lab effectiveness"):
        CliRunner().invoke(lab, command, catch_exceptions=False)
    assert not (tmp_path / "model.json").exists()
