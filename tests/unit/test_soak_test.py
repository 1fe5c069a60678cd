"""The script behind ``make soak-test``, with a stand-in for pytest."""

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.realtime

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "soak_test.py"

FLICKERING = """
import pathlib, sys
runs = pathlib.Path(sys.argv[1])
runs.write_text(runs.read_text() + "x" if runs.exists() else "x")
if len(runs.read_text()) == 2:
    print("FAILED tests/unit/test_a.py::test_b[c d] - assert 1 == 2")
    sys.exit(1)
"""


def soak(folder: Path, *options: str, program: str) -> subprocess.CompletedProcess[str]:
    options = ("--busy", "1", "--logs", str(folder), *options)
    command = (sys.executable, "-c", program, str(folder / "state"))
    return subprocess.run(  # noqa: S603
        [sys.executable, SCRIPT, *options, "--", *command], capture_output=True, text=True, check=False
    )


def test_a_test_that_fails_in_one_of_the_runs_is_reported(tmp_path: Path) -> None:
    result = soak(tmp_path, "--runs", "3", program=FLICKERING)
    assert result.returncode == 1
    *runs, failure, summary = result.stdout.splitlines()
    assert ["passed" in run for run in runs] == [True, False, True]
    assert failure == "failed 1 of 3 times: tests/unit/test_a.py::test_b[c d]"
    assert summary == "2 of 3 runs passed beside 1 busy processes"
    assert "assert 1 == 2" in (tmp_path / "run-02.log").read_text()


def test_runs_that_all_pass_are_a_success(tmp_path: Path) -> None:
    result = soak(tmp_path, "--runs", "2", program="print('fine')")
    assert result.returncode == 0
    assert result.stdout.splitlines()[-1] == "2 of 2 runs passed beside 1 busy processes"


def test_a_run_that_does_not_end_is_ended_and_has_failed(tmp_path: Path) -> None:
    result = soak(tmp_path, "--runs", "1", "--limit-min", "0.01", program="import time; time.sleep(600)")
    assert result.returncode == 1
    assert "FAILED (0 tests" in result.stdout
