"""The folder of a study: going on after an interruption, and refusing what does not belong to it."""

from pathlib import Path

import pytest

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.imaging.persons.evidence import Evidence
from aos_gcs.lab.effectiveness.store import SCENES_FILE, StudyFolder, missing, read_results
from aos_gcs.lab.effectiveness.study import Anomaly, SceneKey, SceneResult, StudySettings, WarmBody, scene_keys
from aos_gcs.lab.scenes import PositionGrade, SceneBody

SETTINGS = StudySettings()


def result(seed: int = 1) -> SceneResult:
    body = WarmBody(Evidence(5, 3, 0.2, 0.5, 13.0, 17.0), (1.5, 2.5), 0.3)
    return SceneResult(
        key=SceneKey(300.0, seed, has_person=True),
        bodies=(SceneBody("person lying", (1.0, 2.0)),),
        approached=None,
        anomalies={PositionGrade.GNSS: (Anomaly(0.2, (1.0, 2.5)), None), PositionGrade.RTK: (None, None)},
        warm={PositionGrade.GNSS: (body,), PositionGrade.RTK: ()},
    )


def test_results_come_back_as_they_were_and_in_order(tmp_path: Path) -> None:
    folder = StudyFolder(tmp_path / "study", SETTINGS)
    for seed in (3, 1):
        folder.append(result(seed))
    assert folder.results() == [result(1), result(3)]


def test_a_study_goes_on_where_it_was_killed(tmp_path: Path) -> None:
    StudyFolder(tmp_path, SETTINGS).append(result(1))
    with (tmp_path / SCENES_FILE).open("a", encoding="utf-8") as file:
        file.write('{"key": {"trees_per')
    assert read_results(tmp_path) == [result(1)]
    folder = StudyFolder(tmp_path, SETTINGS)
    folder.append(result(2))
    assert folder.results() == [result(1), result(2)]
    assert missing([result(2).key, result(3).key], folder.results()) == [result(3).key]


def test_a_damaged_line_is_named(tmp_path: Path) -> None:
    folder = StudyFolder(tmp_path, SETTINGS)
    (tmp_path / SCENES_FILE).write_text("nonsense\n", encoding="utf-8")
    with pytest.raises(InputDataError, match=r"Line 1 of .*scenes\.jsonl is damaged"):
        folder.results()


def test_folders_of_other_studies_and_other_things_are_refused(tmp_path: Path) -> None:
    StudyFolder(tmp_path / "study", SETTINGS)
    with pytest.raises(ConfigurationError, match="other settings"):
        StudyFolder(tmp_path / "study", StudySettings(vehicles=5))
    with pytest.raises(ConfigurationError, match="something else"):
        StudyFolder(tmp_path, SETTINGS)
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(ConfigurationError, match="Cannot use"):
        StudyFolder(tmp_path / "file", SETTINGS)


def test_no_two_scenes_share_a_seed_and_densities_share_them() -> None:
    keys = scene_keys([300.0, 500.0], first_seed=5, scenes=3)
    assert len(keys) == len(set(keys)) == 12
    assert sum(key.has_person for key in keys) == 6
    of_one = [key.seed for key in keys if key.trees_per_ha == 300.0]
    assert len(set(of_one)) == 6


@pytest.mark.parametrize(("field", "value"), [("vehicles", 1), ("image_size_px", 8), ("imaging_steps", 0)])
def test_settings_out_of_range_are_named(field: str, value: int) -> None:
    with pytest.raises(ConfigurationError, match=field):
        StudySettings(**{field: value})
