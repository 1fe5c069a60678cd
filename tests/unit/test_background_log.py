"""Log lines while the terminal takes none."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator

import pytest

from aos_gcs import background_log
from aos_gcs.background_log import BackgroundHandler
from tests.timing import scaled_s

_log = logging.getLogger("flight")


class Terminal(logging.Handler):
    """Takes lines only while it is not stopped, as after Ctrl-S."""

    def __init__(self) -> None:
        super().__init__()
        self.runs = threading.Event()
        self.is_asked = threading.Event()
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.is_asked.set()
        self.runs.wait()
        self.lines.append(record.getMessage())


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> Iterator[Terminal]:
    root, terminal = logging.getLogger(), Terminal()
    before = root.handlers[:]
    root.handlers[:] = [terminal]
    # Whatever ran in this process before may have silenced loggers.
    monkeypatch.setattr(_log, "disabled", False)
    monkeypatch.setattr(logging.root.manager, "disable", logging.NOTSET)
    monkeypatch.setattr(background_log, "_FAREWELL_S", scaled_s(30.0))
    _log.setLevel(logging.INFO)
    yield terminal
    terminal.runs.set()
    root.handlers[:] = before
    _log.setLevel(logging.NOTSET)


def test_a_terminal_that_stands_still_stops_nobody(terminal: Terminal) -> None:
    before = logging.getLogger().handlers[:]
    with background_log.background_log():
        for number in range(3):
            _log.warning("step %d", number)
        assert terminal.is_asked.wait(scaled_s(30.0))
        assert terminal.lines == []
        terminal.runs.set()
    assert terminal.lines == ["step 0", "step 1", "step 2"]
    assert logging.getLogger().handlers == before


def test_lines_tell_what_was_true_when_they_were_logged(terminal: Terminal) -> None:
    vehicles = [1, 2]
    with background_log.background_log():
        _log.warning("flying: %s", vehicles)
        vehicles.clear()
        terminal.runs.set()
    assert terminal.lines == ["flying: [1, 2]"]


def test_lines_that_find_no_room_are_counted(terminal: Terminal, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(background_log, "_MAX_WAITING", 2)
    handler = BackgroundHandler([terminal])
    records = [logging.LogRecord("flight", logging.INFO, "", 0, f"step {number}", None, None) for number in range(6)]
    handler.emit(records[0])
    assert terminal.is_asked.wait(scaled_s(30.0))
    for record in records[1:]:
        handler.emit(record)
    terminal.runs.set()
    handler.close()
    assert terminal.lines[0] == "step 0"
    assert terminal.lines[1].startswith("step 1 (3 lines before this one were lost")
    assert terminal.lines[2:] == ["step 2"]


def test_the_end_of_the_program_does_not_wait_for_the_terminal(
    terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(background_log, "_FAREWELL_S", 0.01)
    with background_log.background_log():
        _log.warning("landed")
    assert terminal.lines == []
