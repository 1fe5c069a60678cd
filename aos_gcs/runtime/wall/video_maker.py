"""Videos of the wall as the dashboard asks for them: one at a time, in a process that lets others go first."""

from __future__ import annotations

import asyncio
import logging
import os
import struct
import tempfile
import time
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO, Final

from aos_gcs.errors import AosError, RecordingError
from aos_gcs.extras import load_extra
from aos_gcs.geometry.notations import Notation
from aos_gcs.mission.viewing import ViewerBusyError
from aos_gcs.ports import Worker
from aos_gcs.runtime.processes.workers import VIDEO
from aos_gcs.runtime.wall.video import VideoFacts, write_wall_video
from aos_gcs.wall.model import TileName
from aos_gcs.wall.video import VideoPhase, VideoState
from aos_gcs.workers.process import open_worker

_log = logging.getLogger(__name__)

LEAST_FREE_BYTES: Final = 2 * 2**30
"""Space that a video leaves on its disk, which may be that of the record."""
REST_IN_FLIGHT: Final = 1.0
"""Rest after each picture as a multiple of the time that it took: half a core at most while vehicles may fly."""
_PART_BYTES: Final = 2**20
_SHARE: Final = struct.Struct("d")
OpenWorker = Callable[[], AbstractAsyncContextManager[Worker]]


@asynccontextmanager
async def open_video_process() -> AsyncIterator[Worker]:
    """Start the process that makes one video, and wait until it can work.

    Raises:
        WorkerError: it cannot be started.
    """
    async with open_worker(VIDEO) as worker:
        await worker.ready()
        yield worker


@dataclass(frozen=True, slots=True)
class VideoOrder:
    """A video to make."""

    folder: Path
    """Mission folder."""
    video: Path
    """Empty file that it is written into."""
    progress: Path
    """File for the share that is done."""
    tiles: tuple[TileName, ...]
    notation: Notation
    rest: float
    """Rest after each picture, as a multiple of the time that it took."""


def make_video(order: VideoOrder) -> VideoFacts:
    """Make a video into files that this removes from their folder: who has opened them before still reads them.

    So nothing is left behind, whichever process ends first.

    Raises:
        ConfigurationError: the record has no such tile.
        InputDataError: the record is damaged, or has no pictures.
        RecordingError: the disk is full, or nearly.
    """
    try:
        with order.video.open("r+b") as video, order.progress.open("r+b", buffering=0) as progress:
            order.video.unlink()
            order.progress.unlink()
            _check_room(video)
            pace = _Pace(video, progress, order.rest)
            return write_wall_video(order.folder, video, order.tiles, order.notation, pace.note, threads=1)
    except OSError as error:
        raise RecordingError(_unwritten(error)) from error


def _check_room(video: BinaryIO) -> None:
    disk = os.fstatvfs(video.fileno())
    if disk.f_bavail * disk.f_frsize < LEAST_FREE_BYTES:
        raise RecordingError(
            f"The disk has less than {LEAST_FREE_BYTES // 2**30} GB left, which the recording of the mission may need: "
            "delete files, or make the video on another machine."
        )


class _Pace:
    """What is done between two pictures: progress is told, the disk is looked at, and others may work."""

    def __init__(self, video: BinaryIO, progress: BinaryIO, rest: float) -> None:
        self._video = video
        self._progress = progress
        self._rest = rest
        self._since_s = time.process_time()

    def note(self, done: float) -> None:
        """Note the share that is done."""
        _check_room(self._video)
        os.pwrite(self._progress.fileno(), _SHARE.pack(done), 0)
        time.sleep(self._rest * (time.process_time() - self._since_s))
        self._since_s = time.process_time()


class VideoMaker:
    """Implementation of ``VideoControl`` on a mission folder.

    Args:
        folder: returns the mission folder; that of the sortie shown, in a replay.
        rest: rest of the process after each picture, as a multiple of the time that it took.
        open_process: starts the process that makes one video.
    """

    def __init__(self, folder: Callable[[], Path], rest: float, open_process: OpenWorker = open_video_process) -> None:
        self._folder = folder
        self._rest = rest
        self._open_process = open_process
        self._state = VideoState()
        self._order: tuple[tuple[TileName, ...], Notation] | None = None
        """What was asked for and has not begun."""
        self._ordered = asyncio.Event()
        self._job: asyncio.Task[None] | None = None
        self._progress: int | None = None
        """Descriptor of the file with the share that is done."""
        self._video: int | None = None
        """Descriptor of the video that is ready."""

    async def run(self) -> None:
        """Make what is asked for, until cancelled."""
        while True:
            await self._ordered.wait()
            self._ordered.clear()
            if self._order is None:
                continue  # it was given up before it began
            (tiles, notation), self._order = self._order, None
            async with asyncio.TaskGroup() as group:
                self._job = group.create_task(self._make(tiles, notation))
            self._job = None

    def state(self) -> VideoState:
        """Return what there is."""
        if self._progress is None:
            return self._state
        written = os.pread(self._progress, _SHARE.size, 0)
        return replace(self._state, done=_SHARE.unpack(written)[0]) if written else self._state

    def begin(self, tiles: Sequence[TileName], notation: Notation) -> VideoState:
        """Begin a video of the record so far."""
        load_extra("av", "video", "A video of the wall")
        if self._state.phase is VideoPhase.MAKING:
            raise ViewerBusyError("A video is being made already; try again in a moment.")
        self._drop()
        self._state = VideoState(VideoPhase.MAKING, self._state.number + 1)
        self._order = tuple(tiles), notation
        self._ordered.set()
        return self._state

    def give_up(self) -> VideoState:
        """End what is being made, or remove what is ready."""
        self._order = None
        if self._job is not None and not self._job.cancelling():
            self._job.cancel()  # what is asked for next begins when it has ended
        self._drop()
        self._state = VideoState(number=self._state.number)
        return self._state

    def read(self) -> tuple[int, Iterator[bytes]] | None:
        """Return the size and the parts of the video; None where none is ready."""
        return None if self._video is None else (self._state.bytes, _parts(os.fdopen(os.dup(self._video), "rb")))

    def _drop(self) -> None:
        if self._video is not None:
            os.close(self._video)
            self._video = None

    async def _make(self, tiles: tuple[TileName, ...], notation: Notation) -> None:
        try:
            await self._make_one(tiles, notation)
        except AosError as error:
            self._failed(str(error))
        except OSError as error:
            self._failed(_unwritten(error))
        except Exception:  # whatever it is: the dashboard goes on without a video
            _log.exception("A video of the wall cannot be made")
            self._failed("The video cannot be made: see the log of the station.")

    async def _make_one(self, tiles: tuple[TileName, ...], notation: Notation) -> None:
        with _spool() as (video_path, video), _spool() as (progress_path, progress):
            order = VideoOrder(self._folder(), video_path, progress_path, tiles, notation, self._rest)
            self._progress = progress
            try:
                async with self._open_process() as worker:
                    facts = await worker.run(make_video, order)
            finally:
                self._progress = None
            self._video = os.dup(video)
            size = os.fstat(video).st_size
            self._state = VideoState(
                VideoPhase.READY, self._state.number, 1.0, facts.tiles, facts.duration_s, size, facts.unreadable
            )

    def _failed(self, reason: str) -> None:
        self._state = replace(self._state, phase=VideoPhase.FAILED, reason=reason)


@contextmanager
def _spool() -> Iterator[tuple[Path, int]]:
    """Yield the path and a descriptor of a new file, which exists as long as somebody has it open."""
    descriptor, name = tempfile.mkstemp(prefix="aos-gcs-video-")
    try:
        yield Path(name), descriptor
    finally:
        os.close(descriptor)
        Path(name).unlink(missing_ok=True)


def _parts(video: BinaryIO) -> Iterator[bytes]:
    """Yield the content of a file, and close it, also where nobody asks for the first part."""
    with video:
        offset = 0
        while part := os.pread(video.fileno(), _PART_BYTES, offset):  # several may read it at once
            yield part
            offset += len(part)


def _unwritten(error: OSError) -> str:
    return f"The video cannot be written: {error.strerror or error}."
