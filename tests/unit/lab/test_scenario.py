"""Scenarios as data: defaults, files, and what is refused with which words."""

from pathlib import Path

import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.groundmap.detection import Posture
from aos_gcs.lab.scenario import Fidelity, Scenario, TimeModel, load_scenario, parse_scenario


def test_the_defaults_are_the_papers() -> None:
    scenario = parse_scenario({})
    assert (scenario.drones, scenario.altitude_m, scenario.layer_spacing_m, scenario.duration_s) == (10, 35, 1, 20)
    assert (scenario.trees_per_ha, scenario.threshold, scenario.speed_mps, scenario.fov_deg) == (300, 0.163, 10, 50)
    assert scenario.camera.width_px == scenario.camera.height_px == 512


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("s.toml", 'posture = "lying"\ndrones = 6\nfidelity = "imaging"\nduration_s = 8'),
        ("s.json", '{"posture": "lying", "drones": 6, "fidelity": "imaging", "duration_s": 8}'),
    ],
)
def test_a_file_says_what_differs(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text)
    scenario = parse_scenario({**load_scenario(tmp_path / name), "time_model": "dynamics"})
    assert scenario == Scenario(
        posture=Posture.LYING, drones=6, fidelity=Fidelity.IMAGING, duration_s=8.0, time_model=TimeModel.DYNAMICS
    )


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"trees": 300}, "no field trees"),
        ({"terrain": "hills"}, "terrain must be one of flat"),
        ({"posture": "flying"}, "posture must be one of standing, sitting, lying"),
        ({"errors": "exact"}, "errors must be one of none, rtk, gnss, but is 'exact'"),
        ({"drones": 2.5}, "drones must be a whole number"),
        ({"drones": 1}, "drones must lie within 2 and 100"),
        ({"drones": "ten"}, "drones must be a number"),
        ({"duration_s": True}, "duration_s must be a number"),
        ({"duration_s": float("nan")}, "duration_s must lie within"),
        ({"trees_per_ha": -1}, "trees_per_ha must lie within"),
        ({"altitude_m": 15}, "altitude_m must lie within 20"),
        ({"drones": 30, "spacing_m": 4.2}, "spacing_m does not fit"),
        ({"start_distance_m": 60}, "start_distance_m must be at most half of forest_side_m"),
        ({"posture": "lying", "target_speed_mps": 1.5}, "target_speed_mps must be 0 for a lying target"),
    ],
)
def test_refusals_name_the_field(settings: dict[str, object], words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        parse_scenario(settings)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("absent.toml", None, "Cannot read the scenario"),
        ("s.toml", "drones = ", "neither TOML nor"),
        ("s.json", "[1, 2]", "must be a table"),
        ("s.json", "{", "neither TOML nor"),
    ],
)
def test_refusals_name_the_file(tmp_path: Path, name: str, text: str | None, words: str) -> None:
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(ConfigurationError, match=words) as caught:
        load_scenario(tmp_path / name)
    assert name in str(caught.value)
