"""Limits of waiting, loops and sums of durations in the tests themselves."""

import asyncio
from pathlib import Path

import pytest

from aos_gcs.runtime.simulated.virtual_time import VirtualTimeLoop
from tests import timing


@pytest.fixture(autouse=True)
def _measure_anew() -> None:
    timing.patience.cache_clear()


def test_patience_can_be_set(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(timing.VARIABLE, "3.5")
    assert timing.scaled_s(10.0) == 35.0


def test_measured_patience_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(timing.VARIABLE, raising=False)
    assert 2.0 <= timing.patience() <= 30.0


@pytest.mark.virtual
async def test_a_marked_test_runs_in_the_loop_of_simulated_missions(tmp_path: Path) -> None:
    assert isinstance(asyncio.get_running_loop(), VirtualTimeLoop)
    await asyncio.sleep(3600.0)
    assert tmp_path.name


def test_durations_add_up_per_folder() -> None:
    def report(nodeid: str, when: str, duration: float) -> pytest.TestReport:
        return pytest.TestReport(nodeid, ("", 0, ""), {}, "passed", None, when, duration=duration)  # type: ignore[arg-type]

    lines = timing.by_folder(
        [
            report("tests/unit/test_a.py::test_b[c/d::e]", "setup", 1.0),
            report("tests/unit/test_a.py::test_b[c/d::e]", "call", 2.0),
            report("tests/contract/test_f.py::test_g", "call", 4.0),
        ]
    )
    assert [line.split() for line in lines] == [
        ["4.0", "s", "1", "tests", "tests/contract"],
        ["3.0", "s", "1", "tests", "tests/unit"],
    ]
