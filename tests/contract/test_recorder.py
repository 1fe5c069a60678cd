"""Behaviour that the Recorder port promises: of the mission folder, and of the recorder of the tests."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import pytest

from aos_gcs.errors import RecordingError
from aos_gcs.mission.journal import Recorder
from aos_gcs.mission.model.actions import Action, ActionRecord
from aos_gcs.mission.model.events import Event
from aos_gcs.mission.model.phase import Outcome, OutcomeRecord
from aos_gcs.mission.model.steps import Picture, PictureKind, StepRecord
from aos_gcs.mission.model.vehicles import SettingsRecord
from aos_gcs.store.database import MissionDatabase, Write
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.recorder import MissionRecorder
from tests.fakes.mission_flight import MemoryRecorder
from tests.fakes.records import capture, notice_event, step_record

STATE = {"best": [1.0, 2.0]}
PICTURE = Picture(PictureKind.INTEGRAL, 1, b"png", 0.0, 0.0, 10.0, 10.0)


@dataclass(frozen=True, slots=True)
class Kept:
    """What is on record."""

    events: Sequence[Event]
    frames: Sequence[tuple[int, int]]
    """Step and vehicle of each."""
    picture: bytes | None
    """The picture of the first step."""
    steps: Sequence[StepRecord]
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
        partial(recorder.record_action, ActionRecord(1000.0, Action.HOLD, None, ())),
    ]
    for write in writes:
        await write()
        with pytest.raises(RecordingError):
            await recorder.flush()
    await recorder.flush()  # nothing was recorded since
    kept = recording.read()
    assert [event.seq for event in kept.events] == [1]
    assert (list(kept.steps), list(kept.actions)) == ([], [])
