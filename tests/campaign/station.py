"""One run of the service: the real driver, coordinator and recorder, until it ends or is killed."""

from __future__ import annotations

import asyncio
import sqlite3
from contextlib import AsyncExitStack, suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from aos_drivers.mavlink.service import open_mavlink
from aos_gcs.clock import LoopClock
from aos_gcs.mission.coordinator import Coordinator
from aos_gcs.mission.health import LoopMonitor
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.actions import ActionRecord
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Capture, DriverContext, Worker
from aos_gcs.store.last_mission import former_flight
from aos_gcs.store.recorder import MissionRecorder
from aos_gcs.store.schema import DATABASE_NAME
from tests.fakes.air import GCS
from tests.fakes.frozen import station


class _Counted:
    """Counts what a recorder is given; nothing more reaches the disk once the process is dead."""

    def __init__(self, recorder: MissionRecorder) -> None:
        self._recorder = recorder
        self.given = {"actions": 0, "frames": 0}
        self.steps: set[int] = set()
        self.is_dead = False

    def __getattr__(self, name: str) -> object:
        return _write_nothing if self.is_dead else getattr(self._recorder, name)

    async def record_frame(self, step: int, frame: Capture) -> None:
        self.given["frames"] += 1
        if not self.is_dead:
            await self._recorder.record_frame(step, frame)

    async def record_step(self, step: StepRecord, state: dict[str, object]) -> None:
        self.steps.add(step.step)
        if not self.is_dead:
            await self._recorder.record_step(step, state)

    async def record_action(self, action: ActionRecord) -> None:
        self.given["actions"] += 1
        if not self.is_dead:
            await self._recorder.record_action(action)


async def _write_nothing(*_: object, **__: object) -> None:
    """Stand in for a recorder whose process is dead."""


class Station:
    """A station that flies one mission."""

    def __init__(
        self, settings: MissionSettings, folder: Path, number: int, start_utc_s: float, *, imaging: Worker
    ) -> None:
        self._imaging = imaging
        self._settings = settings
        self._folder = folder
        self.number = number
        self.clock = LoopClock()
        self.clock._start_utc_s = start_utc_s + asyncio.get_running_loop().time()
        self.journal = Journal(self.clock)
        self._stack = AsyncExitStack()
        self.mission: Coordinator
        self.run: asyncio.Task[Outcome]
        self._recorder: _Counted

    async def __aenter__(self) -> Self:
        pulse = LoopMonitor(period_s=0.5)
        with station():
            await self._start(pulse)
        return self

    async def _start(self, pulse: LoopMonitor) -> None:
        former = former_flight(self._folder, self.clock.utc_s())
        context = DriverContext(
            clock=self.clock,
            is_healthy=pulse.is_healthy,
            notify=self.journal.take,
            former=None if former is None else former.links,
        )
        async with AsyncExitStack() as stack:
            fleet = await stack.enter_async_context(open_mavlink([f"udpin://{GCS[0]}:{GCS[1]}"], context))
            recorder = await stack.enter_async_context(
                MissionRecorder.create(self._folder, f"run-{self.number}", {}, notify=self.journal.take)
            )
            self._recorder = _Counted(recorder)
            await stack.enter_async_context(self.journal.recorded(self._recorder))  # type: ignore[arg-type]
            self.mission = Coordinator(
                f"run-{self.number}",
                self._settings,
                fleet=fleet,
                clock=self.clock,
                journal=self.journal,
                recorder=self._recorder,  # type: ignore[arg-type]
                loop_monitor=pulse,
                imaging=self._imaging,
                former=former,
            )
            self.run = asyncio.create_task(self.mission.run())
            self._stack = stack.pop_all()

    def die(self) -> None:
        """Write nothing more, as a process that was killed."""
        self._recorder.is_dead = True

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.run.cancel()
        with suppress(asyncio.CancelledError, Exception):
            await self.run
        await self._stack.aclose()

    @property
    def is_over(self) -> bool:
        """Whether the mission has ended."""
        return self.run.done()

    @property
    def has_launched(self) -> bool:
        return self.mission.phase not in {Phase.CONNECT, Phase.PREFLIGHT, Phase.READY}

    def failure(self) -> BaseException | None:
        """Return the exception that has ended the mission."""
        return self.run.exception() if self.run.done() and not self.run.cancelled() else None

    def landed_ids(self) -> list[int]:
        """Return the vehicles that count as landed."""
        return [member.vehicle_id for member in self.mission._context.roster.members(Task.LANDED)]

    def lost_records(self) -> str:
        """Compare what was given to the recorder with what is on the disk, once it is closed; empty if all is there."""
        wanted = {
            **self._recorder.given,
            "steps": len(self._recorder.steps),
            "events WHERE kind = 'notice'": self.journal.notice_count,
            "outcome": 1,
        }
        with sqlite3.connect(self._folder / f"run-{self.number}" / DATABASE_NAME) as database:
            found = {table: database.execute(f"SELECT count(*) FROM {table}").fetchone()[0] for table in wanted}  # noqa: S608
        database.close()
        return ", ".join(
            f"{found[table]} of {count} {table.split()[0]}" for table, count in wanted.items() if found[table] < count
        )
