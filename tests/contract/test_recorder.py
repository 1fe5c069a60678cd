"""Behaviour that the Recorder port promises: of the mission folder, and of the recorder of the tests."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import pytest

from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.airspace.plans import TrafficSituation
from aos_gcs.errors import RecordingError
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.journal import Recorder
from aos_gcs.mission.model.actions import Action, ActionRecord
from aos_gcs.mission.model.decisions import ConclusionRecord, DecisionRecord, SearchRecord, Situation, SwarmPlace
from aos_gcs.mission.model.events import Event
from aos_gcs.mission.model.findings import TargetEstimate
from aos_gcs.mission.model.phase import Outcome, OutcomeRecord, Phase
from aos_gcs.mission.model.steps import Picture, PictureKind, StepRecord
from aos_gcs.mission.model.vehicles import SettingsRecord
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.store.codec import encode
from aos_gcs.store.database import MissionDatabase, Write
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.recorder import MissionRecorder
from tests.fakes.mission_flight import MemoryRecorder
from tests.fakes.records import ORIGIN, capture, notice_event, step_record

STATE = {"best": [1.0, 2.0]}
PICTURE = Picture(PictureKind.INTEGRAL, 1, b"png", 0.0, 0.0, 10.0, 10.0)
SEARCH = SearchRecord(MissionSettings(2, ((0.0, 0.0), (9.0, 0.0), (0.0, 9.0)), ImagingSettings()), ORIGIN)
DECISION = DecisionRecord(
    step=1,
    phase=Phase.SCAN,
    decided=0,
    concluded=0,
    focal_height_m=0.5,
    settled_enu_m=((1.0, 2.0),),
    situation=Situation(
        3.0,
        (SwarmPlace(2, (1.0, 2.0, 30.0), 30.0),),
        TrafficSituation(limits=UNLIMITED, arrival_radius_m=0.5, movable=(), left={2: "held"}, obstacles=()),
    ),
    following=Phase.CONVERGE,
    marks={2: "0123"},
)
CONCLUSION = ConclusionRecord(1, 4.0, True, Phase.FOUND, (TargetEstimate((1.0, 2.0, 0.0), None, 3),))


@dataclass(frozen=True, slots=True)
class Kept:
    """What is on record."""

    events: Sequence[Event]
    frames: Sequence[tuple[int, int]]
    """Step and vehicle of each."""
    picture: bytes | None
    """The picture of the first step."""
    steps: Sequence[StepRecord]
    search: SearchRecord | None
    decisions: Sequence[tuple[DecisionRecord, ConclusionRecord | None]]
    """Decision of each step, and what was concluded after it."""
    actions: Sequence[ActionRecord]
    settings: Sequence[SettingsRecord]
    outcome: OutcomeRecord | None


@dataclass
class Recording:
    """A recorder, and a look at what it keeps."""

    recorder: Recorder
    read: Callable[[], Kept]
    fail: Callable[[], None]
    """Let nothing more be written."""


@asynccontextmanager
async def on_disk(folder: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Recording]:
    def fail() -> None:
        def write(_database: MissionDatabase, _writes: Sequence[Write]) -> None:
            raise OSError("the disk is full")

        monkeypatch.setattr(MissionDatabase, "write", write)

    def read() -> Kept:
        with MissionReader(folder / "m") as reader:
            return Kept(
                list(reader.events()),
                [(entry.step, entry.vehicle_id) for entry in reader.frames()],
                reader.picture(1, PictureKind.INTEGRAL),
                reader.steps(),
                reader.search(),
                [decision for step in reader.steps() if (decision := reader.decision(step.step)) is not None],
                reader.actions(),
                reader.settings(),
                reader.outcome(),
            )

    async with MissionRecorder.create(folder, "m", {}, notify=lambda _: None) as recorder:
        yield Recording(recorder, read, fail)


@asynccontextmanager
async def in_memory(_folder: Path, _monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Recording]:
    recorder = MemoryRecorder()

    def fail() -> None:
        recorder.is_full = True

    def read() -> Kept:
        return Kept(
            recorder.events,
            [(step, frame.vehicle_id) for step, frame in recorder.frames],
            next((picture.png for picture in recorder.pictures), None),
            list(recorder.steps.values()),
            next(reversed(recorder.searches), None),
            [(decision, recorder.conclusions.get(step)) for step, decision in recorder.decisions.items()],
            recorder.actions,
            recorder.settings,
            recorder.outcome,
        )

    yield Recording(recorder, read, fail)


Opener = Callable[[Path, pytest.MonkeyPatch], AbstractAsyncContextManager[Recording]]


@pytest.fixture(params=[on_disk, in_memory], ids=["on disk", "in memory"])
async def recording(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> AsyncIterator[Recording]:
    opener: Opener = request.param
    async with opener(tmp_path / "missions", monkeypatch) as recording:
        yield recording


async def test_what_is_flushed_can_be_read_in_its_order(recording: Recording) -> None:
    recorder = recording.recorder
    events = [notice_event(number) for number in (1, 2, 3)]
    action = ActionRecord(1000.0, Action.HOLD, None, (), operator="Ada")
    changed = SettingsRecord(1000.0, 2, "return height", {"RTL_ALT": 3000.0})
    outcome = OutcomeRecord(1000.0, Outcome.FOUND, {"landed": 2})
    for event in events:
        await recorder.record_event(event)
    for vehicle_id in (2, 1):
        await recorder.record_frame(1, capture(vehicle_id))
    await recorder.record_picture(PICTURE)
    for number in (1, 2):
        await recorder.record_step(step_record(number), STATE)
    await recorder.record_action(action)
    await recorder.record_action(replace(action, action=Action.RETURN))
    await recorder.record_settings(changed)
    await recorder.record_settings(replace(changed, is_restored=True))
    await recorder.record_outcome(outcome)
    await recorder.flush()

    kept = recording.read()
    assert list(kept.events) == events
    assert sorted(kept.frames) == [(1, 1), (1, 2)]
    assert kept.picture == PICTURE.png
    assert list(kept.steps) == [step_record(1), step_record(2)]
    assert [record.action for record in kept.actions] == [Action.HOLD, Action.RETURN]
    assert [record.is_restored for record in kept.settings] == [False, True]
    assert kept.outcome == outcome


async def test_a_second_record_of_a_step_replaces_the_first(recording: Recording) -> None:
    for missing in ({}, {3: "no frame within 5 s"}):
        await recording.recorder.record_step(replace(step_record(1), missing=missing), STATE)
    await recording.recorder.flush()
    assert [step.missing for step in recording.read().steps] == [{3: "no frame within 5 s"}]


async def test_decisions_can_be_verified_by_what_they_and_their_search_depended_on(recording: Recording) -> None:
    recorder = recording.recorder
    later = replace(SEARCH, settings=replace(SEARCH.settings, strategy="aos-pso"))
    for search in (SEARCH, later):
        await recorder.record_search(search)
    for number in (1, 2):
        await recorder.record_decision(replace(DECISION, step=number))
        await recorder.record_step(step_record(number), STATE)
    await recorder.record_conclusion(CONCLUSION)
    await recorder.flush()

    kept = recording.read()
    assert kept.search == later, "the search under way, which a new sortie begins anew"
    (first, concluded), (second, none_yet) = kept.decisions
    assert [encode(first), encode(second)] == [encode(DECISION), encode(replace(DECISION, step=2))]
    assert (concluded, none_yet) == (CONCLUSION, None)


async def test_a_second_decision_of_a_step_replaces_the_first(recording: Recording) -> None:
    recorder = recording.recorder
    for following in (Phase.SCAN, Phase.FOUND):
        await recorder.record_decision(replace(DECISION, following=following))
    await recorder.record_step(step_record(1), STATE)
    await recorder.flush()
    assert [(decision.following, concluded) for decision, concluded in recording.read().decisions] == [
        (Phase.FOUND, None)
    ]


async def test_a_flush_tells_that_something_could_not_be_written_and_its_recording_does_not(
    recording: Recording,
) -> None:
    recorder = recording.recorder
    await recorder.record_event(notice_event(1))
    await recorder.flush()
    recording.fail()
    writes: list[Callable[[], Awaitable[None]]] = [
        partial(recorder.record_event, notice_event(2)),
        partial(recorder.record_step, step_record(1), STATE),
        partial(recorder.record_search, SEARCH),
        partial(recorder.record_decision, DECISION),
        partial(recorder.record_conclusion, CONCLUSION),
        partial(recorder.record_action, ActionRecord(1000.0, Action.HOLD, None, ())),
    ]
    for write in writes:
        await write()
        with pytest.raises(RecordingError):
            await recorder.flush()
    await recorder.flush()  # nothing was recorded since
    kept = recording.read()
    assert [event.seq for event in kept.events] == [1]
    assert (list(kept.steps), kept.search, list(kept.decisions), list(kept.actions)) == ([], None, [], [])
