"""Options of the simulator's commands that cannot be used: refused in a sentence before anything is simulated."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fakes.command_line import exit_status

SIM = ("sim", "--no-render")
SIM_CAMERA = ("sim-camera", "--no-render", "--link", "tcpout://127.0.0.1:9")


@pytest.mark.parametrize("command", [SIM, SIM_CAMERA], ids=lambda command: command[0])
@pytest.mark.parametrize("option", ["--world-file", "--report-file"])
@pytest.mark.parametrize("place", ["gone/w.json", ""])
def test_files_that_cannot_be_written_are_refused(
    command: tuple[str, ...], option: str, place: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert exit_status([*command, option, tmp_path / place]) == 2
    told = capsys.readouterr().err
    assert f"{option}: " in told
    assert ("there is no folder" if place else "is a folder; name a file in it") in told
    assert "Traceback" not in told


@pytest.mark.parametrize("start", ["nan", "inf", "-5", "1e18"])
def test_a_clock_that_starts_at_no_time_is_refused(start: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_status([*SIM, f"--clock-start={start}"]) == 2
    assert "--clock-start must be seconds since the Unix epoch" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--terrain-only",), "--terrain-only writes the ground and exits: name its --terrain-file"),
        (("--wind", "1e9"), "--wind must lie within 0 and 50 m/s"),
        (("--wind", "nan"), "--wind must lie within 0 and 50 m/s"),
        (("--vehicles", "5", "--link", "udpin://127.0.0.1:65533"), "has no port for vehicle 4: ports end at 65535"),
    ],
)
def test_what_cannot_be_simulated_is_refused(
    options: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert exit_status([*SIM, *options]) == 2
    assert words in capsys.readouterr().err
