"""Search that got no frames in flight: when it goes on without stops again."""

from __future__ import annotations

from dataclasses import replace

import pytest

from aos_gcs.mission.search.frames.sampling import Sample
from aos_gcs.mission.search.in_flight.frames import FIRST_STEPS, MOST_STEPS, PROVEN_ROUNDS, FramesInFlight
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_gcs.ports import Severity
from tests.fakes.mission_flight import settings
from tests.fakes.records import capture

IN_TIME_S, LATE_S = 0.6, 3.4
SILENCE = "No frame has come in flight for 3 s (no image yet)"


class FakeJournal:
    """Keeps what is announced."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def notice(self, severity: Severity, text: str, vehicle_id: int | None = None, **_: object) -> None:  # noqa: ARG002
        self.texts.append(text)

    def elapsed_s(self) -> float:
        return 0.0


def watch(mode: SearchMode = SearchMode.CONTINUOUS) -> tuple[FramesInFlight, FakeJournal]:
    journal = FakeJournal()
    return FramesInFlight(settings(4, search=SearchSettings(mode)), journal), journal


def rest(frames: FramesInFlight, came: int = 4, *, took_s: float = IN_TIME_S, sigma_s: float | None = 0.02) -> None:
    """Look at a step at rest in which the frames of some of four vehicles came."""
    captures = tuple(replace(capture(number), time_sigma_s=sigma_s) for number in range(1, came + 1))
    missing = dict.fromkeys(range(came + 1, 5), "no image")
    frames.look_at_rest(Sample(captures, missing), dict.fromkeys(range(1, came + 1), took_s))


def steps_to_go(frames: FramesInFlight) -> int:
    """Make good steps at rest until the search may fly on; return their number."""
    steps = 0
    while not frames.is_sweep_allowed:
        rest(frames)
        steps += 1
    return steps


def test_a_silence_in_flight_stops_the_line_until_frames_have_come_at_rest_some_times_in_a_row() -> None:
    frames, journal = watch()
    assert frames.is_sweep_allowed
    frames.note_silence(SILENCE)
    assert not frames.is_sweep_allowed
    for _ in range(FIRST_STEPS - 1):
        rest(frames)
    rest(frames, came=1)
    assert steps_to_go(frames) == FIRST_STEPS
    assert journal.texts == [
        f"{SILENCE}: the search goes on with stops",
        "Frames received again. The search continues without stops",
    ]


@pytest.mark.parametrize(
    "step", [{"came": 0}, {"came": 1}, {"took_s": LATE_S}, {"sigma_s": 0.2}], ids=["none", "few", "late", "no time"]
)
def test_frames_at_rest_that_would_not_have_counted_in_flight_change_nothing(step: dict[str, float]) -> None:
    frames, _ = watch()
    frames.note_silence(SILENCE)
    for _ in range(2 * FIRST_STEPS):
        rest(frames, **step)  # type: ignore[arg-type]
    assert not frames.is_sweep_allowed


def test_half_of_the_vehicles_suffice() -> None:
    frames, _ = watch()
    frames.note_silence(SILENCE)
    for _ in range(FIRST_STEPS):
        rest(frames, came=2)
    assert frames.is_sweep_allowed


def test_attempts_become_rarer_until_one_has_lasted() -> None:
    frames, _ = watch()
    waits = []
    for _ in range(7):
        frames.note_silence(SILENCE)
        waits.append(steps_to_go(frames))
    assert waits == [3, 6, 12, 24, 48, MOST_STEPS, MOST_STEPS]
    for _ in range(PROVEN_ROUNDS):
        frames.note_round()
    frames.note_silence(SILENCE)
    assert steps_to_go(frames) == FIRST_STEPS


def test_a_search_with_stops_never_sweeps() -> None:
    frames, journal = watch(SearchMode.STOPS)
    for _ in range(2 * FIRST_STEPS):
        rest(frames)
    assert not frames.is_sweep_allowed
    assert journal.texts == []
