import io
import os
import stat
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from aos_gcs.cli.display.report import _result
from aos_gcs.cli.output import PLAIN_INTERVAL_S, progress
from aos_gcs.errors import ConfigurationError
from aos_gcs.exports.files import check_writable, written_whole
from aos_gcs.mission.model.actions import Action, ActionRecord, ActionResult


def ticking(step_s: float) -> Iterator[float]:
    now_s = 0.0
    while True:
        yield now_s
        now_s += step_s


def test_short_work_stays_silent_where_there_is_no_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    clock = ticking(0.01)
    with progress("Working", 10, lambda: next(clock)) as advance:
        for _ in range(10):
            advance(1)
    assert capsys.readouterr() == ("", "")


def test_long_work_says_now_and_then_how_far_it_is(capsys: pytest.CaptureFixture[str]) -> None:
    clock = ticking(PLAIN_INTERVAL_S / 4)
    with progress("Working", 10, lambda: next(clock)) as advance:
        for _ in range(10):
            advance(1)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.splitlines() == [
        "Working: 4/10 (40 %)",
        "Working: 8/10 (80 %)",
        "Working: 10/10 (100 %)",
    ]


def test_a_terminal_gets_a_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    with progress("Working", 3) as advance:
        advance(3)
    assert "Working" in terminal.getvalue()
    assert "3/3" in terminal.getvalue()


def test_a_file_appears_as_a_whole(tmp_path: Path) -> None:
    path = tmp_path / "result.npy"
    path.write_bytes(b"old")
    with written_whole(path) as file:
        file.write(b"new")
        assert path.read_bytes() == b"old"
    assert path.read_bytes() == b"new"
    assert os.listdir(tmp_path) == ["result.npy"]  # noqa: PTH208 - hidden files count
    fresh = tmp_path / "fresh"
    fresh.touch()
    assert stat.S_IMODE(path.stat().st_mode) == stat.S_IMODE(fresh.stat().st_mode)


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "result.npy"
    path.write_bytes(b"old")

    def fail_half_way() -> None:
        with written_whole(path) as file:
            file.write(b"half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail_half_way()
    assert path.read_bytes() == b"old"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_full_disk_is_named_where_the_system_gives_no_reason(tmp_path: Path) -> None:
    def fill_up() -> None:
        with written_whole(tmp_path / "result.npy"):
            raise OSError("262144 requested and 76768 written")  # as NumPy words it

    with pytest.raises(ConfigurationError, match=r"Cannot write .*result\.npy: the disk may be full"):
        fill_up()
    assert list(tmp_path.iterdir()) == []


def test_paths_that_cannot_be_written_are_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="is a folder"):
        check_writable(tmp_path)
    with pytest.raises(ConfigurationError, match=r"absent.*does not exist"):
        check_writable(tmp_path / "absent" / "result.npy")
    with pytest.raises(ConfigurationError, match="Cannot write"), written_whole(tmp_path / "absent" / "x"):
        pass
    check_writable(tmp_path / "result.npy")


def test_a_folder_without_permission_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The superuser may write everywhere, so that the answer of the system is stood in for.
    monkeypatch.setattr(os, "access", lambda path, mode: not (Path(path) == tmp_path and mode == os.W_OK))
    with pytest.raises(ConfigurationError, match="no permission"):
        check_writable(tmp_path / "result.npy")


def test_an_action_is_reported_with_the_vehicles_that_refused_it() -> None:
    done, not_done = ActionResult(1, True, "lands"), ActionResult(4, False, "link lost")
    assert _result(ActionRecord(0.0, Action.LAND, None, (done,))) == "accepted"
    some = _result(ActionRecord(0.0, Action.LAND, None, (done, not_done)))
    assert some == "accepted by 1, refused by 1: vehicle 4: link lost"
    assert _result(ActionRecord(0.0, Action.START, None, (), "not ready")) == "refused: not ready"
