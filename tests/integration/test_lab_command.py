"""``aos-gcs lab run`` and ``calibrate``: files, going on, and sentences for whoever mistypes."""

import sys
from pathlib import Path

import pytest

from aos_gcs.cluster import MAX_JOBS
from aos_gcs.lab.results import open_results
from tests.fakes.command_line import exit_status

SCENARIO = """
forest_side_m = 40
trees_per_ha = 100
drones = 3
duration_s = 9
start_distance_m = 12
"""


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "scenario.toml"
    path.write_text(SCENARIO)
    return path


def code_of(*arguments: object) -> int:
    return exit_status(["lab", *arguments])


def test_a_campaign_runs_and_runs_no_second_time(
    scenario: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ("run", "--strategies", "aos-pso,aos-apso(gamma=0.8)", "--initialisations", 2, "--scenario", scenario)
    assert code_of(*command, "--duration", 1, "--posture", "lying", "--out", tmp_path / "out") == 0
    rows = open_results(tmp_path / "out").read()
    assert f"{rows.num_rows} rows in {tmp_path / 'out'} (strategies: 2, initialisations: 2)" in capsys.readouterr().out
    assert open_results(tmp_path / "out").campaign.scenario.posture == "lying"
    assert max(rows["time_s"].to_pylist()) <= 1.0
    assert code_of(*command, "--duration", 1, "--posture", "lying", "--out", tmp_path / "out") == 0
    assert "2 of 2 initialisations are there already" in capsys.readouterr().err
    assert open_results(tmp_path / "out").read().equals(rows)
    assert code_of(*command, "--duration", 2, "--posture", "lying", "--out", tmp_path / "out") == 2
    assert "duration_s is 1.0 there and 2.0 here" in capsys.readouterr().err


def test_the_papers_initialisations_can_be_named(
    scenario: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ("--initialisations", "paper", "--scenario", scenario, "--duration", 0.5, "--out", tmp_path / "out")
    assert code_of("run", "--strategies", "aos-pso", *options) == 0
    assert "(strategies: 1, initialisations: 3)" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--strategies", "aos-pso,magic"), "no strategy 'magic'"),
        (("--strategies", "aos-pso(c_s_m=0.5)"), "c_s_m must be above c_c_m"),
        (("--density", "-5"), "trees_per_ha must lie within 0 and 2000"),
        (("--drones", "40"), "spacing_m does not fit"),
        (("--fidelity", "perfect"), "fidelity must be one of geometric, imaging"),
        (("--time-model", "slow"), "time_model must be one of paper, dynamics"),
        (("--initialisations", "0"), "number of initialisations must lie within"),
        (("--initialisations", "some.toml"), "Cannot read the initialisations some.toml"),
        (("--scenario", "absent.toml"), "Cannot read the scenario absent.toml"),
        (("--jobs", "0"), f"--jobs must lie within 1 and {MAX_JOBS}"),
        (("--scheduler", "tcp://127.0.0.1:9"), "scheduler tcp://127.0.0.1:9 cannot be reached"),
    ],
)
def test_bad_input_ends_with_a_sentence(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    options: tuple[str, ...],
    words: str,
) -> None:
    monkeypatch.setattr("aos_gcs.cluster.CONNECT_TIMEOUT_S", 0.3)
    assert code_of("run", "--strategies", "aos-pso", "--out", tmp_path / "out", *options) == 2
    error = capsys.readouterr().err
    assert words in error
    assert "Traceback" not in error


def test_without_its_extra_the_laboratory_says_how_to_get_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    assert code_of("run", "--strategies", "aos-pso", "--out", tmp_path / "out") == 2
    assert "aos-gcs[lab]" in capsys.readouterr().err


def test_the_forest_is_calibrated_by_what_views_see(capsys: pytest.CaptureFixture[str]) -> None:
    assert code_of("calibrate", "--densities", "0", "--worlds", 2, "--views", 5) == 0
    assert "1.000 +- 0.000" in capsys.readouterr().out
    assert code_of("calibrate", "--densities", "many") == 2
    assert "--densities must be numbers" in capsys.readouterr().err


@pytest.mark.parametrize("densities", ["300,5000", "-1", "nan", "300,300"])
@pytest.mark.parametrize("study", ["missions", "search", "effectiveness", "detectability"])
def test_densities_that_cannot_be_built_are_refused_before_anything_is_made(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], study: str, densities: str
) -> None:
    assert code_of(study, "--densities", densities, "--out", tmp_path / "study") == 2
    assert "--densities must " in capsys.readouterr().err
    assert not (tmp_path / "study").exists()


@pytest.mark.parametrize(
    ("study", "options", "words"),
    [
        ("missions", ("--strategy", "magic"), "no strategy 'magic'"),
        ("missions", ("--search", "hovering"), "--search must be one of"),
        ("missions", ("--conditions", "cool,cool"), "--conditions must name each one once"),
        ("missions", ("--document", "{folder}/binary/m.md"), "is a file, or closed"),
        ("missions", ("--document", "{folder}"), "is no text file that can be renewed"),
        ("missions", ("--document", "{folder}/binary"), "binary is no text file that can be renewed"),
        ("search", ("--document", "{folder}/binary/s.md"), "is a file, or closed"),
        ("search", ("--methods", "planned,planned"), "each once"),
        ("search", ("--images", "-1"), "images must be at least 0"),
        ("effectiveness", ("--strategy", "magic"), "no strategy 'magic'"),
    ],
)
def test_what_would_be_refused_after_the_work_is_refused_before(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], study: str, options: tuple[str, ...], words: str
) -> None:
    (tmp_path / "binary").write_bytes(b"\x81")
    given = (one.format(folder=tmp_path) for one in options)
    assert code_of(study, "--out", tmp_path / "study", *given) == 2
    assert words in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "study").exists()


def test_a_document_that_cannot_be_written_is_refused_before_the_studies(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    assert code_of("reproduce", "--out", tmp_path / "r", "--document", tmp_path / "file" / "r.md") == 2
    assert "is a file" in capsys.readouterr().err
    assert code_of("reproduce", "--out", tmp_path / "file") == 2
    assert "is a file" in capsys.readouterr().err


@pytest.mark.parametrize("study", ["run", "missions", "search", "effectiveness", "detectability", "reproduce"])
def test_more_processes_than_the_machine_bears_are_refused_before_anything_is_made(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], study: str
) -> None:
    strategies = ("--strategies", "aos-pso") if study == "run" else ()
    assert code_of(study, *strategies, "--jobs", 100000, "--out", tmp_path / "study") == 2
    assert f"--jobs must lie within 1 and {MAX_JOBS}, two per core, but is 100000" in capsys.readouterr().err
    assert not (tmp_path / "study").exists()
