"""Intake of a step's frames: each is recorded and examined as it comes, while others are still on their way."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from aos_gcs.errors import WorkerError
from aos_gcs.imaging.model import AnomalySource, Frame
from aos_gcs.imaging.step.examination import ExaminedFrame, examine_all
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.handler_watch import WORK_S, sign_of_life
from aos_gcs.mission.journal import Recorder
from aos_gcs.mission.search.frames.sampling import to_frame
from aos_gcs.ports import Capture


class FrameIntake:
    """Frames of one step, and what each shows by itself; made by :func:`open_intake`.

    Args:
        context: context of the flight.
        recorder: stores the frames.
        step: number of the step.
    """

    def __init__(self, context: FlightContext, recorder: Recorder, step: int) -> None:
        self._context = context
        self._recorder = recorder
        self._step = step
        self._to_record: asyncio.Queue[Capture | None] = asyncio.Queue()
        self._to_examine: asyncio.Queue[Frame | None] = asyncio.Queue()
        self._is_complete = False
        self._failure: WorkerError | None = None
        self._examined: dict[int, ExaminedFrame] = {}
        self.frames: dict[int, Frame] = {}
        """Frames by vehicle, with the poses that the vehicles have reported."""
        self.received_at_s = time.perf_counter()
        """Reading of the performance counter when the last of them came."""

    def add(self, capture: Capture, speed_mps: float = 0.0) -> None:
        """Take in a frame, exposed at some speed."""
        frame = to_frame(capture, self._context.roster.local_frame(), speed_mps)
        self.frames[capture.vehicle_id] = frame
        self.received_at_s = time.perf_counter()
        self._to_record.put_nowait(capture)
        self._to_examine.put_nowait(frame)

    def examined(self, vehicle_id: int) -> ExaminedFrame:
        """Return what the frame of a vehicle shows, once the intake is over.

        Raises:
            WorkerError: not all frames could be examined.
        """
        if self._failure is not None:
            raise self._failure
        return self._examined[vehicle_id]

    async def work(self) -> None:
        """Record and examine frames until there are no more."""
        async with asyncio.TaskGroup() as group:
            group.create_task(self._record())
            if self._context.settings.imaging.anomaly_source is AnomalySource.MASKS:
                group.create_task(self._examine())

    def complete(self) -> None:
        """Note that no more frames come."""
        self._is_complete = True
        self._to_record.put_nowait(None)
        self._to_examine.put_nowait(None)

    async def _record(self) -> None:
        while (capture := await self._to_record.get()) is not None:
            is_recorded = False
            async with self._context.journal.with_disk_timeout(f"frames of step {self._step}"):
                await self._recorder.record_frame(self._step, capture)
                is_recorded = True
            if not is_recorded:
                return  # a disk that does not answer delays a step once, not once per frame

    async def _examine(self) -> None:
        """Examine frames, all that have come since the last call at once; a worker that fails costs the step."""
        context, is_over = self._context, False
        while not is_over:
            batch = [await self._to_examine.get()]
            while not self._to_examine.empty():
                batch.append(self._to_examine.get_nowait())
            is_over = None in batch
            frames = [frame for frame in batch if frame is not None]
            if self._is_complete:
                sign_of_life(WORK_S)
            try:
                examined = await context.imaging.run(examine_all, frames, context.settings.imaging) if frames else []
            except WorkerError as error:
                self._failure = error
                return
            self._examined |= {one.vehicle_id: one for one in examined}


@asynccontextmanager
async def open_intake(context: FlightContext, recorder: Recorder, step: int) -> AsyncIterator[FrameIntake]:
    """Take in frames for as long as the context is entered; leaving it waits until all are examined."""
    intake = FrameIntake(context, recorder, step)
    work = asyncio.create_task(intake.work(), name=f"frames of step {step}")
    try:
        yield intake
        intake.complete()
        await work
    finally:
        work.cancel()
        await asyncio.wait([work])
