"""The world file: written by one program, shown again by another, and clear about what is wrong with it."""

from __future__ import annotations

from pathlib import Path

import pytest

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_sim.world.scene import SceneParameters, build_scene
from aos_sim.world_file import read_world_file, write_world_file
from aos_sim.world_options import world_of
from tests.fakes.command_line import exit_status

ORIGIN = GeodeticPosition(48.3, 14.3, 260.0)


def test_a_world_is_the_same_when_it_is_read_back(tmp_path: Path) -> None:
    parameters = SceneParameters(seed=7, trees_per_ha=20.0, animals=1, stones=2, cloths=3)
    path = tmp_path / "world.json"
    write_world_file(path, world_of(build_scene(parameters)), ORIGIN, {1: (0.0, 0.0, 0.0)}, 1e9)
    assert read_world_file(path) == (parameters, ORIGIN)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    "content",
    ["", "[]", "{}", '{"origin": 3, "seed": 1}', '{"origin": {"latitude_deg": 48.3}, "seed": 1, "trees_per_ha": 1}'],
)
def test_what_is_no_world_file_is_named(tmp_path: Path, content: str) -> None:
    path = tmp_path / "other.json"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(InputDataError, match=r"other\.json is not a world file"):
        read_world_file(path)
    with pytest.raises(InputDataError, match="cannot be read"):
        read_world_file(tmp_path / "missing.json")


def test_a_world_out_of_range_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "world.json"
    write_world_file(path, world_of(build_scene(SceneParameters(trees_per_ha=0.0))), ORIGIN, {}, 1e9)
    path.write_text(path.read_text(encoding="utf-8").replace('"seed": 1', '"seed": -1'), encoding="utf-8")
    with pytest.raises(ConfigurationError, match="seed"):
        read_world_file(path)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--link", "tcpout:5762"], "KIND://HOST:PORT"),
        (["--link", "udpout://127.0.0.1:14550"], "wait to hear a vehicle"),
        (["--link", "udpin://127.0.0.1:14540", "--world", "missing.json"], "missing.json cannot be read"),
        (["--link", "udpin://127.0.0.1:14540", "--origin", "48,14"], "LAT,LON,ALT"),
        (["--link", "udpin://127.0.0.1:14540", "--image-size", "3"], "--image-size"),
        (["--link", "udpin://127.0.0.1:14540", "--fov", "180"], "--fov"),
        (["--link", "udpin://127.0.0.1:14540", "--http-port", "70000"], "--http-port"),
    ],
)
def test_sim_camera_refuses_wrong_input_with_a_sentence(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert exit_status(["sim-camera", *arguments]) == 2
    error = capsys.readouterr().err
    assert sentence in error
    assert "Traceback" not in error
