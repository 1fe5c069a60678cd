"""Priority of sessions, where the kernel groups processes by them."""

from __future__ import annotations

import os

import pytest

from aos_gcs.workers import lifeline


class Autogroup:
    """The kernel's file: it takes one priority at a time."""

    def __init__(self, refusals: list[OSError]) -> None:
        self.refusals = refusals
        self.texts: list[str] = []

    def write_text(self, text: str, encoding: str) -> None:
        assert encoding == "ascii"
        if self.refusals:
            raise self.refusals.pop()
        self.texts.append(text)


@pytest.fixture
def pauses_s(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    paused: list[float] = []
    monkeypatch.setattr(lifeline.time, "sleep", paused.append)
    return paused


@pytest.mark.parametrize(
    ("is_own", "refusals", "texts", "waits"),
    [
        (True, [], ["5"], 0),
        (True, [BlockingIOError(), BlockingIOError()], ["5"], 2),
        (True, [BlockingIOError() for _ in range(99)], [], 30),
        (True, [FileNotFoundError()], [], 0),
        (False, [], [], 0),
    ],
    ids=["alone", "others do it, too", "gives up", "no such file", "in a session of others"],
)
def test_only_a_session_of_its_own_steps_back(
    monkeypatch: pytest.MonkeyPatch,
    pauses_s: list[float],
    *,
    is_own: bool,
    refusals: list[OSError],
    texts: list[str],
    waits: int,
) -> None:
    autogroup = Autogroup(refusals)
    monkeypatch.setattr(lifeline, "_AUTOGROUP", autogroup)
    monkeypatch.setattr(os, "getsid", lambda _pid: os.getpid() if is_own else 1)
    lifeline.step_back_as_session()
    assert autogroup.texts == texts
    assert len(pauses_s) == waits
