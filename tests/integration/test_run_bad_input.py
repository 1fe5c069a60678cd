"""Bad input to ``aos-gcs demo`` and ``aos-gcs run``: one sentence, exit code 2, and nothing left behind."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from aos_gcs.lab.worlds import ErrorGrade
from aos_gcs.runtime.simulated import demo
from aos_sim.errors.model import error_model
from aos_sim.swarm import SwarmOptions
from aos_sim.world.scene import SceneParameters
from tests.fakes.command_line import exit_status
from tests.fakes.program import unused_port

HOST = "127.0.0.1"
CONFIGURATION = """
[link]
urls = ["udpin://127.0.0.1:{port}"]
[mission]
vehicles = 2
any_vehicles = true
auto_start = true
area_enu_m = [[-10, 0], [10, 0], [10, 50], [-10, 50]]
[api]
enabled = false
[record]
folder = "{folder}"
"""


@contextmanager
def taken_port(kind: socket.SocketKind) -> Iterator[int]:
    with socket.socket(socket.AF_INET, kind) as taken:
        taken.bind((HOST, 0))
        if kind is socket.SOCK_STREAM:
            taken.listen()
        yield taken.getsockname()[1]


@pytest.fixture
def free_port() -> int:
    return unused_port()


@pytest.fixture
def refusal(threaded_workers: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]):  # noqa: ARG001 - for its effect
    """Run a command that must be refused, and return the one sentence that it says."""

    def run(*arguments: str) -> str:
        status = exit_status(["--log-level", "error", *arguments])
        output = capsys.readouterr()
        assert status == 2
        assert output.out == ""
        assert not [path for path in (tmp_path / "missions").glob("*") if path.is_dir()]
        (sentence,) = output.err.splitlines()
        assert sentence.startswith("aos-gcs: ")
        return sentence

    return run


@pytest.fixture
def refusal_of_file(tmp_path: Path, free_port: int, refusal):
    """Run ``aos-gcs run`` with the valid configuration changed: ``new`` for ``old``, ``end`` appended."""

    def run(old: str = "", new: str = "", end: str = "") -> str:
        valid = CONFIGURATION.format(port=free_port, folder=tmp_path / "missions")
        assert old in valid
        file = tmp_path / "mission.toml"
        file.write_text((valid.replace(old, new) if old else valid) + end, encoding="utf-8")
        return refusal("run", str(file))

    return run


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--vehicles", "0"), "--vehicles must lie within 1 and 100, but is 0"),
        (("--search", "hovering"), "--search must be one of continuous, stops, but is 'hovering'"),
        (("--vehicles", "101"), "--vehicles must lie within 1 and 100, but is 101"),
        (("--strategy", "hope"), "no strategy 'hope'; choose one of aos-apso"),
        (("--speed", "0"), "--speed must be above 0"),
        (("--speed", "nan"), "--speed must be above 0"),
        (("--errors", "foo"), "--errors must be one of none, rtk, gnss, but is 'foo'"),
        (("--autopilot", "foo"), "--autopilot must be one of arducopter, px4, but is 'foo'"),
        (("--trees-per-ha", "-1"), "--trees-per-ha must lie within 0 and 2000"),
        (("--trees-per-ha", "nan"), "--trees-per-ha must lie within 0 and 2000"),
        (("--image-size", "8"), "--image-size must lie within 16 and 4096, but is 8"),
        (("--animals", "101"), "--animals must lie within 0 and 100"),
        (("--stones", "-1"), "--stones must lie within 0 and 100"),
        (("--origin", "48.3,14.3"), "--origin must be LAT,LON,ALT (three numbers), got '48.3,14.3'"),
        (("--origin", "nan,14.3,0"), "--origin must be LAT,LON,ALT (three numbers), got 'nan,14.3,0'"),
    ],
)
def test_options_of_the_demo(
    tmp_path: Path, refusal, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], sentence: str
) -> None:
    """Bad arguments are refused at once: nothing is started for them."""
    if arguments[0] != "--strategy":
        monkeypatch.delattr(demo, "open_demo")
    assert sentence in refusal("demo", "--headless", "--json", "--folder", str(tmp_path / "missions"), *arguments)


@pytest.mark.parametrize(
    ("terrain", "sentence"),
    [
        ("valley", "--terrain must be flat, hills, slope:PERCENT or a GeoTIFF or ASC file"),
        ("gone.tif", "gone.tif does not exist"),
    ],
)
def test_a_terrain_that_the_demo_cannot_use(tmp_path: Path, refusal, terrain: str, sentence: str) -> None:
    pytest.importorskip("rasterio")
    assert sentence in refusal("demo", "--headless", "--folder", str(tmp_path / "missions"), "--terrain", terrain)


def test_a_port_in_use_is_named(tmp_path: Path, refusal) -> None:
    with taken_port(socket.SOCK_STREAM) as port:
        sentence = refusal("demo", "--port", str(port), "--folder", str(tmp_path / "missions"))
    assert f"port {port} is in use" in sentence
    assert "--port" in sentence


@pytest.mark.parametrize("image_size_px", [demo.MIN_IMAGE_SIZE_PX, demo.MAX_IMAGE_SIZE_PX])
@pytest.mark.parametrize("bodies", [0, demo.MAX_BODIES])
def test_the_demo_offers_what_the_simulator_has(image_size_px: int, bodies: int) -> None:
    for autopilot in demo.AUTOPILOTS:
        SwarmOptions(autopilot=autopilot, image_size_px=image_size_px)
    for grade in ErrorGrade:
        error_model(grade)
    SceneParameters(seed=1, trees_per_ha=demo.MAX_TREES_PER_HA, animals=bodies, stones=bodies)


def test_what_the_simulator_refuses_is_said_in_its_words(
    tmp_path: Path, refusal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(demo, "MIN_IMAGE_SIZE_PX", 8)
    sentence = refusal("demo", "--headless", "--image-size", "8", "--folder", str(tmp_path / "missions"))
    assert sentence == "aos-gcs: --image-size must lie within 16 and 4096, got 8."


def test_a_mission_folder_that_cannot_be_made(tmp_path: Path, refusal) -> None:
    (tmp_path / "file").touch()
    sentence = refusal("demo", "--headless", "--folder", str(tmp_path / "file" / "missions"))
    assert str(tmp_path / "file" / "missions") in sentence
    assert "cannot be made" in sentence


def test_a_missing_file(tmp_path: Path, refusal) -> None:
    assert "Cannot read the configuration" in refusal("run", str(tmp_path / "none.toml"))


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--headless", "--open"), "--headless runs without the dashboard: leave --open out, or --headless."),
        (("--headless", "--port", "8080"), "--headless runs without the dashboard: leave --port out"),
        (("--tls", "--tls-cert", "c.pem"), "--tls makes a certificate, and --tls-cert names one: give one of them."),
        (("--tls-key", "k.pem"), "--tls-key needs --tls-cert."),
        (("--tls-cert", "c.pem"), "api.tls_cert: the certificate c.pem does not exist; check the path."),
    ],
)
def test_options_that_contradict_each_other(
    tmp_path: Path, free_port: int, refusal, options: tuple[str, ...], sentence: str
) -> None:
    file = tmp_path / "mission.toml"
    text = CONFIGURATION.format(port=free_port, folder=tmp_path / "missions").replace("enabled = false", "port = 0")
    file.write_text(text, encoding="utf-8")
    assert sentence in refusal("run", str(file), *options)


@pytest.mark.parametrize("port", ["-1", "65536"])
def test_a_port_that_does_not_exist(tmp_path: Path, capsys: pytest.CaptureFixture[str], port: str) -> None:
    file = tmp_path / "mission.toml"
    file.write_text(CONFIGURATION.format(port=1, folder=tmp_path / "missions"), encoding="utf-8")
    assert exit_status(["run", str(file), "--port", port]) == 2
    assert "Invalid value for '--port': it must be at " in capsys.readouterr().err


def test_binary_in_place_of_text(tmp_path: Path, refusal) -> None:
    (tmp_path / "c.toml").write_bytes(bytes(range(128, 256)))
    assert "c.toml is no text file (UTF-8): name the TOML file." in refusal("run", str(tmp_path / "c.toml"))


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--swap", "5"), "--swap is the time for another battery: it needs --batteries."),
        (("--headless", "--wait"), "--wait leaves the launch to the dashboard, which --headless does without"),
        (("--headless", "--operator-code-file", "code"), "leave --operator-code-file out"),
    ],
)
def test_options_of_the_demo_that_contradict_each_other(refusal, options: tuple[str, ...], sentence: str) -> None:
    assert sentence in refusal("demo", *options)


def test_invalid_toml(tmp_path: Path, refusal) -> None:
    file = tmp_path / "broken.toml"
    file.write_text("[link", encoding="utf-8")
    assert "is not valid TOML" in refusal("run", str(file))


@pytest.mark.parametrize(
    ("end", "sentence"),
    [
        ("[weather]\nwind = 3", "weather"),
        ("[flight]\nspeed = 3", "flight.speed is unknown; known are: lowest_layer_m"),
        ("[flight]\nlowest_layer_m = -3", "flight: lowest_layer_m must be a finite number above 0"),
        ("[imaging]\nplane_height_m = 40", "imaging.plane_height_m (40) must be below flight.lowest_layer_m (35)"),
        ("[swarm]\nstrategy = 'hope'", "no strategy 'hope'"),
        ("[swarm.parameters]\nc9 = 1", "no parameter c9"),
        ("[safety]\ngap_m = 1", "safety.gap_m is unknown"),
        ("[safety]\nseparation_m = 'wide'", "safety.separation_m"),
        ("[safety]\nseparation_m = -1", "separation_m must be above 0"),
        ("[safety]\nfloor_m = 36", "the altitude layers, 35 to 37.5 m, must lie between floor_m and ceiling_m"),
        ("[safety]\nceiling_m = 36", "the altitude layers, 35 to 37.5 m, must lie between floor_m and ceiling_m"),
        ("[safety]\nfence_deg = [[48, 14], [48, 15], [49, 15]]", "safety.fence_deg needs mission.origin_deg"),
        ("[safety]\nfence_deg = [[48, 214]]", "safety.fence_deg[0][1] must be at most 180"),
        ("[link.options]\nbaud = 9600", "link.options.baud is unknown"),
    ],
)
def test_fields_of_the_file(refusal_of_file, end: str, sentence: str) -> None:
    assert sentence in refusal_of_file(end=end)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("vehicles = 2", "vehicles = 0", "mission.vehicles"),
        ("udpin:", "carrier-pigeon:", "carrier-pigeon"),
        ("[link]", "[link]\ndriver = 'telepathy'", "unknown driver 'telepathy'; known are: mavlink"),
        ("area_enu_m = [[-10, 0], ", "area_deg = [[10.0, 0], ", "mission.area_deg needs mission.origin_deg"),
        ("[10, 50], [-10, 50]", "[-10, 50], [10, 50]", "mission.area_enu_m must not cross"),
        ("auto_start = true", "", "Without the dashboard nobody starts the mission: set mission.auto_start to true."),
        ("area_enu_m", "scan_heading_deg = 400\narea_enu_m", "mission.scan_heading_deg"),
    ],
)
def test_links_and_areas(refusal_of_file, old: str, new: str, sentence: str) -> None:
    assert sentence in refusal_of_file(old, new)


def test_a_link_port_in_use(refusal_of_file, free_port: int) -> None:
    with taken_port(socket.SOCK_DGRAM) as port:
        assert f"port {port} is in use" in refusal_of_file(str(free_port), str(port))


def test_a_plan_without_a_forest_names_the_section(tmp_path: Path, refusal, free_port: int) -> None:
    file = tmp_path / "mission.toml"
    file.write_text(CONFIGURATION.format(port=free_port, folder=tmp_path / "missions"), encoding="utf-8")
    assert "[forest]" in refusal("run", str(file), "--plan")


def test_a_plan_says_how_the_aperture_suits_the_forest(
    tmp_path: Path, free_port: int, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "mission.toml"
    forest = "[forest]\ncanopy_height_m = 18\ncrown_base_m = 6\n"
    file.write_text(CONFIGURATION.format(port=free_port, folder=tmp_path / "missions") + forest, encoding="utf-8")
    assert exit_status(["--log-level", "error", "run", str(file), "--plan"]) == 0
    output = capsys.readouterr().out
    assert output.startswith("c4 4.2 m (useful from 4.4 m), 2 vehicles")
    assert "10 reach 95%" in output
    assert not (tmp_path / "missions").exists()
