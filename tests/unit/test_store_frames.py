"""Image files of frames: on the disk before their rows, and waited for by nobody who does not need them."""

import asyncio
import os
import threading
from collections.abc import AsyncIterator, Sequence
from pathlib import Path
from typing import NoReturn

import pytest

from aos_gcs.errors import RecordingError
from aos_gcs.ports import Capture, Severity
from aos_gcs.store.database import MissionDatabase
from aos_gcs.store.frame_files import FrameRow, write_frames
from aos_gcs.store.recorder import MissionRecorder
from tests.fakes.mission_store import Store
from tests.fakes.records import capture, frame_row, notice_event, step_record


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "missions")


@pytest.fixture
async def recorder(store: Store) -> AsyncIterator[MissionRecorder]:
    async with store.record() as recorder:
        yield recorder


def test_frames_are_on_the_disk_before_the_rows_that_name_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    database = MissionDatabase(tmp_path / "m", {})
    done: list[object] = []
    sync = os.fsync

    def note_sync(descriptor: int) -> None:
        done.append(os.fstat(descriptor).st_ino)
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", note_sync)
    database._connection.set_trace_callback(done.append)
    row = frame_row(tmp_path / "m", 1, capture(3))
    database.write([lambda database: database.add_frame(row)])
    database.write([lambda database: database.add_event(notice_event(1))])
    database._connection.set_trace_callback(None)
    database.close()
    frames = tmp_path / "m" / "frames"
    (frame,) = frames.iterdir()
    inodes = [entry for entry in done if isinstance(entry, int)]
    assert inodes == [frame.stat().st_ino, frames.stat().st_ino]
    assert done.index(frames.stat().st_ino) < done.index("COMMIT")


async def test_a_decision_does_not_wait_for_the_image_files_of_its_frames(
    store: Store, recorder: MissionRecorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    released = threading.Event()

    def write_when_released(folder: Path, frames: Sequence[tuple[int, Capture]]) -> list[FrameRow | Exception]:
        released.wait()
        return write_frames(folder, frames)

    monkeypatch.setattr("aos_gcs.store.recorder.write_frames", write_when_released)
    try:
        await recorder.record_frame(1, capture(2))
        await recorder.record_step(step_record(1), {})
        await recorder.flush(frames=False)
        with store.read() as reader:
            assert (len(reader.steps()), len(reader.frames())) == (1, 0)
        everything = asyncio.create_task(recorder.flush())
        await asyncio.sleep(0)
        assert not everything.done()
    finally:
        released.set()
    await everything
    with store.read() as reader:
        assert [frame.vehicle_id for frame in reader.frames(1)] == [2]


async def test_frames_that_cannot_be_written_are_told_once_while_other_records_are(
    store: Store, recorder: MissionRecorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patched:
        patched.setattr("aos_gcs.store.frame_files.encode_image", no_memory)
        for step in (1, 2):
            await recorder.record_frame(step, capture())
            await recorder.record_step(step_record(step), {})
            with pytest.raises(RecordingError, match="no memory for the picture"):
                await recorder.flush()
        assert [notice.severity for notice in store.notices] == [Severity.CRITICAL]
    await recorder.record_frame(3, capture())
    await recorder.flush()
    assert [notice.severity for notice in store.notices] == [Severity.CRITICAL, Severity.WARNING]
    with store.read() as reader:
        assert ([frame.step for frame in reader.frames()], len(reader.steps())) == ([3], 2)


def no_memory(*_: object) -> NoReturn:
    raise MemoryError("no memory for the picture")
