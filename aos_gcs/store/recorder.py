"""Records a mission as it happens.

Buffered: yes, ``QUEUE_SIZE`` frames and as many other records; when full: the caller waits, nothing is dropped. One
thread writes the image files of frames, which takes milliseconds of the processor for each, another one the database,
several records per transaction: a decision does not wait for images. A storage that fails never stops a mission: the
records concerned are lost and counted, the operator gets a notice when it begins and when it is over, and ``flush``
raises.
"""

from __future__ import annotations

import asyncio
import re
import sqlite3
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final, TypeVar

from aos_gcs.errors import ConfigurationError, RecordingError
from aos_gcs.mission.model.actions import ActionRecord
from aos_gcs.mission.model.decisions import ConclusionRecord, DecisionRecord, SearchRecord
from aos_gcs.mission.model.events import Event
from aos_gcs.mission.model.phase import OutcomeRecord
from aos_gcs.mission.model.steps import Picture, StepRecord
from aos_gcs.mission.model.vehicles import SettingsRecord
from aos_gcs.ports import Capture, Notice, Severity
from aos_gcs.store.database import MissionDatabase, Write
from aos_gcs.store.frame_files import FrameRow, write_frames
from aos_gcs.store.schema import MAVLINK_NAME

T = TypeVar("T")

QUEUE_SIZE: Final = 64
"""Bounds the memory as well: a frame of 512 x 512 pixels and four bands takes 4 MiB."""

FOLDER_NAME = r"\w[\w.-]*"
"""Pattern of the names of mission folders."""


@dataclass(frozen=True, slots=True)
class _Flush:
    """Marks a place in the queue; ``done`` is set when everything before it has been written or lost."""

    done: asyncio.Future[None]


_END: Final = None


class MissionRecorder:
    """Writes one mission folder; made by :meth:`create` or :meth:`reopen`."""

    def __init__(self, folder: Path, notify: Callable[[Notice], None]) -> None:
        self._folder = folder
        self._notify = notify
        self._frames: asyncio.Queue[tuple[int, Capture] | _Flush | None] = asyncio.Queue(QUEUE_SIZE)
        self._queue: asyncio.Queue[Write | _Flush | None] = asyncio.Queue(QUEUE_SIZE)
        self._failing: set[str] = set()
        """What cannot be written at present."""
        self._failure: RecordingError | None = None
        self._lost = 0
        self._lost_before_flush = 0
        self._why_lost = ""

    @classmethod
    @asynccontextmanager
    async def create(
        cls, root: Path, mission_id: str, manifest: Mapping[str, object], *, notify: Callable[[Notice], None]
    ) -> AsyncIterator[MissionRecorder]:
        """Make the folder ``root / mission_id`` and record into it for as long as the context is entered.

        Leaving the context writes what is still queued, also when the mission was cancelled.

        Args:
            root: where the missions are; made when it is missing.
            mission_id: a plain folder name.
            manifest: inputs of the mission: configuration, versions, seed, start time.
            notify: gets a notice when recording begins to fail and when it works again; called on the event loop.

        Raises:
            ConfigurationError: the folder exists already or cannot be made.
        """
        if not re.fullmatch(FOLDER_NAME, mission_id):
            raise ConfigurationError(
                f"the mission id {mission_id!r} is not a valid folder name; use letters, digits, - and _"
            )
        recorder = cls(root / mission_id, notify)
        async with recorder._writing(partial(_make, recorder.folder, manifest)):
            yield recorder

    @classmethod
    @asynccontextmanager
    async def reopen(
        cls, folder: Path, last_step: int, *, notify: Callable[[Notice], None]
    ) -> AsyncIterator[MissionRecorder]:
        """Continue the record in a folder, after a step, for as long as the context is entered; see :meth:`create`.

        Raises:
            ConfigurationError: it cannot be written.
        """
        recorder = cls(folder, notify)
        async with recorder._writing(partial(_reopen, folder, last_step)):
            yield recorder

    @asynccontextmanager
    async def _writing(self, open_database: Callable[[], MissionDatabase]) -> AsyncIterator[None]:
        with (
            ThreadPoolExecutor(max_workers=1, thread_name_prefix="recorder") as thread,
            ThreadPoolExecutor(max_workers=1, thread_name_prefix="recorder of frames") as frame_thread,
        ):
            loop = asyncio.get_running_loop()
            database = await loop.run_in_executor(thread, open_database)
            writer = asyncio.create_task(self._write_all(database, thread), name="recorder")
            frame_writer = asyncio.create_task(self._write_frames(frame_thread), name="recorder of frames")
            try:
                yield
            finally:
                await self._frames.put(_END)
                await frame_writer
                await self._queue.put(_END)
                await writer
                await loop.run_in_executor(thread, database.close)

    @property
    def folder(self) -> Path:
        """The mission's folder."""
        return self._folder

    @property
    def log_folder(self) -> Path:
        """Folder of the driver's raw traffic."""
        return self._folder / MAVLINK_NAME

    async def record_event(self, event: Event) -> None:
        """Record an entry of the event stream."""
        await self._queue.put(lambda database: database.add_event(event))

    async def record_frame(self, step: int, frame: Capture) -> None:
        """Record a frame with its pose; the image must not be changed afterwards."""
        await self._frames.put((step, frame))

    async def record_picture(self, picture: Picture) -> None:
        """Record a raster as it is shown."""
        await self._queue.put(lambda database: database.add_picture(picture))

    async def record_step(self, step: StepRecord, strategy_state: Mapping[str, object]) -> None:
        """Record a step; a second record of the same step replaces the first.

        Args:
            step: measurements and decisions of the step.
            strategy_state: inputs with which the strategy decides the same again: its state (dataclasses and arrays
                are welcome) and the state of its random generator (``rng.bit_generator.state``).
        """
        await self._queue.put(lambda database: database.add_step(step, strategy_state))

    async def record_search(self, search: SearchRecord) -> None:
        """Append what all steps of a search have in common."""
        await self._queue.put(lambda database: database.add_search(search))

    async def record_decision(self, decision: DecisionRecord) -> None:
        """Record what a step's decision depended on, besides its frames."""
        await self._queue.put(lambda database: database.add_decision(decision))

    async def record_conclusion(self, conclusion: ConclusionRecord) -> None:
        """Record what was concluded about a step's targets, after its decision."""
        await self._queue.put(lambda database: database.add_conclusion(conclusion))

    async def record_action(self, action: ActionRecord) -> None:
        """Append an operator's action, and what became of it, to the audit log."""
        await self._queue.put(lambda database: database.add_action(action))

    async def record_settings(self, settings: SettingsRecord) -> None:
        """Append which settings of a vehicle the mission changes, or has set back."""
        await self._queue.put(lambda database: database.add_settings(settings))

    async def record_outcome(self, outcome: OutcomeRecord) -> None:
        """Record how the mission has ended; once."""
        await self._queue.put(lambda database: database.add_outcome(outcome))

    async def flush(self, *, frames: bool = True) -> None:
        """Wait until everything recorded so far is on the disk, or everything but frames.

        Raises:
            RecordingError: something recorded since the last flush could not be written.
        """
        done = asyncio.get_running_loop().create_future()
        if frames:
            await self._frames.put(_Flush(done))
        else:
            await self._queue.put(_Flush(done))
        await done

    async def _write_frames(self, thread: ThreadPoolExecutor) -> None:
        """Write the files of frames until the end mark, and hand over their rows; owned by :meth:`_writing`."""
        loop = asyncio.get_running_loop()
        ended = False
        while not ended:
            batch = await _waiting(self._frames)
            ended = _END in batch
            frames = [item for item in batch if isinstance(item, tuple)]
            if frames:
                rows = await loop.run_in_executor(thread, write_frames, self._folder, frames)
                self._report("frames", [row for row in rows if isinstance(row, Exception)])
                for row in rows:
                    if isinstance(row, FrameRow):
                        await self._queue.put(partial(_add_frame, row))
            for item in batch:
                if isinstance(item, _Flush):
                    await self._queue.put(item)

    async def _write_all(self, database: MissionDatabase, thread: ThreadPoolExecutor) -> None:
        """Write batches until the end mark; owned by :meth:`_writing`."""
        loop = asyncio.get_running_loop()
        ended = False
        while not ended:
            batch = await _waiting(self._queue)
            ended = _END in batch
            writes = [item for item in batch if item is not _END and not isinstance(item, _Flush)]
            if writes:
                self._report("rows", await loop.run_in_executor(thread, _write, database, writes))
            for item in batch:
                if isinstance(item, _Flush):
                    self._answer(item)

    def _report(self, what: str, errors: Sequence[Exception]) -> None:
        """Count what is lost; report when something begins to fail, and when everything works again."""
        self._lost += len(errors)
        self._lost_before_flush += len(errors)
        if not errors:
            self._failing.discard(what)
        else:
            self._failing.add(what)
            self._why_lost = str(errors[0])
        if errors and self._failure is None:
            self._failure = RecordingError(
                f"cannot record into {self._folder}: {errors[0]}; free some space or check the disk"
            )
            self._notify(Notice(Severity.CRITICAL, f"The mission continues without recording: {self._failure}."))
        elif not self._failing and self._failure is not None:
            self._failure = None
            self._notify(Notice(Severity.WARNING, f"Recording resumed; {self._lost} records were lost."))

    def _answer(self, flush: _Flush) -> None:
        if flush.done.cancelled():
            return
        if self._lost_before_flush:
            text = str(
                self._failure
                or f"{self._lost_before_flush} records could not be written into {self._folder}: {self._why_lost}; "
                "free some space or check the disk"
            )
            flush.done.set_exception(RecordingError(text))
        else:
            flush.done.set_result(None)
        self._lost_before_flush = 0


async def _waiting(queue: asyncio.Queue[T]) -> list[T]:
    """Return everything that waits in a queue, once there is something."""
    batch = [await queue.get()]
    while not queue.empty():
        batch.append(queue.get_nowait())
    return batch


def _add_frame(row: FrameRow, database: MissionDatabase) -> None:
    database.add_frame(row)


def _make(folder: Path, manifest: Mapping[str, object]) -> MissionDatabase:
    try:
        return MissionDatabase(folder, manifest)
    except FileExistsError as error:
        raise ConfigurationError(f"{folder} exists already; choose another name or folder") from error
    except (OSError, sqlite3.Error) as error:
        raise ConfigurationError(
            f"the folder {folder} cannot be made: {error}; check its path and rights, and the space on the disk"
        ) from error


def _reopen(folder: Path, last_step: int) -> MissionDatabase:
    try:
        return MissionDatabase.reopen(folder, last_step)
    except sqlite3.Error as error:
        raise ConfigurationError(f"the record in {folder} cannot be continued: {error}") from error


def _write(database: MissionDatabase, writes: Sequence[Write]) -> list[Exception]:
    """Write a batch at once; if that fails, one by one, and return why each of the lost ones could not be written."""
    try:
        database.write(writes)
    except Exception as error:  # whatever it is: a writer that dies would leave the coordinator waiting
        if len(writes) == 1:
            return [error]
        return [lost for write in writes for lost in _write(database, [write])]
    return []
