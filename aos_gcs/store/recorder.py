"""Records a mission as it happens.

Buffered: yes, ``QUEUE_SIZE`` records; when full: the caller waits, nothing is dropped. One thread writes, several
records per transaction. A storage that fails never stops a mission: the records concerned are lost and counted, the
operator gets a notice when it begins and when it is over, and ``flush`` raises.
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
from typing import Final

from aos_gcs.errors import ConfigurationError, RecordingError
from aos_gcs.mission.model.actions import ActionRecord
from aos_gcs.mission.model.decisions import ConclusionRecord, DecisionRecord, SearchRecord
from aos_gcs.mission.model.events import Event
from aos_gcs.mission.model.phase import OutcomeRecord
from aos_gcs.mission.model.steps import Picture, StepRecord
from aos_gcs.mission.model.vehicles import SettingsRecord
from aos_gcs.ports import Capture, Notice, Severity
from aos_gcs.store.database import MissionDatabase, Write
from aos_gcs.store.schema import MAVLINK_NAME

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
        self._queue: asyncio.Queue[Write | _Flush | None] = asyncio.Queue(QUEUE_SIZE)
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
        with ThreadPoolExecutor(max_workers=1, thread_name_prefix="recorder") as thread:
            loop = asyncio.get_running_loop()
            database = await loop.run_in_executor(thread, open_database)
            writer = asyncio.create_task(self._write_all(database, thread), name="recorder")
            try:
                yield
            finally:
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
        await self._queue.put(lambda database: database.add_frame(step, frame))

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

    async def flush(self) -> None:
        """Wait until everything recorded so far is on the disk.

        Raises:
            RecordingError: something recorded since the last flush could not be written.
        """
        done = asyncio.get_running_loop().create_future()
        await self._queue.put(_Flush(done))
        await done

    async def _write_all(self, database: MissionDatabase, thread: ThreadPoolExecutor) -> None:
        """Write batches until the end mark; owned by :meth:`_writing`."""
        loop = asyncio.get_running_loop()
        ended = False
        while not ended:
            batch = [await self._queue.get()]
            while not self._queue.empty():
                batch.append(self._queue.get_nowait())
            ended = _END in batch
            writes = [item for item in batch if item is not _END and not isinstance(item, _Flush)]
            if writes:
                self._report(await loop.run_in_executor(thread, _write, database, writes))
            for item in batch:
                if isinstance(item, _Flush):
                    self._answer(item)

    def _report(self, errors: Sequence[Exception]) -> None:
        self._lost += len(errors)
        self._lost_before_flush += len(errors)
        if errors:
            self._why_lost = str(errors[0])
        if errors and self._failure is None:
            self._failure = RecordingError(
                f"cannot record into {self._folder}: {errors[0]}; free some space or check the disk"
            )
            self._notify(Notice(Severity.CRITICAL, f"The mission continues without recording: {self._failure}."))
        elif not errors and self._failure is not None:
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
