"""The journal of a mission: everything that happens is numbered, published and recorded."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AbstractContextManager, asynccontextmanager
from typing import Protocol

from aos_gcs.errors import RecordingError
from aos_gcs.mission.events import EventStream
from aos_gcs.mission.model.actions import ActionRecord
from aos_gcs.mission.model.decisions import ConclusionRecord, DecisionRecord, SearchRecord
from aos_gcs.mission.model.events import Event, EventData, EventKind, NoticeRecord
from aos_gcs.mission.model.phase import OutcomeRecord
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import Picture, StepRecord
from aos_gcs.mission.model.vehicles import SettingsRecord
from aos_gcs.mission.patience import patience
from aos_gcs.ports import Capture, Clock, Notice, Severity

_log = logging.getLogger(__name__)

_LOG_LEVELS = {
    Severity.INFO: logging.INFO,
    Severity.NEWS: logging.INFO,
    Severity.WARNING: logging.WARNING,
    Severity.CRITICAL: logging.ERROR,
}

DISK_TIMEOUT_S = 1.0
"""Time that the mission waits for the disk, in real seconds."""

CRITICAL_STALL_S = 3.0
"""Time without heartbeats that is close to the vehicles' own limits, mostly 5 s."""

_STALLS = 100
"""Number of stalls that are remembered."""

EVENT_BACKLOG = 4096
"""Number of events that may wait for the disk; far more than a mission makes in a minute."""


class Recorder(Protocol):
    """Record of a mission; ``aos_gcs.store.recorder`` implements it on disk."""

    async def record_event(self, event: Event) -> None:
        """Append one event."""
        ...

    async def record_frame(self, step: int, frame: Capture) -> None:
        """Store one frame."""
        ...

    async def record_picture(self, picture: Picture) -> None:
        """Store a raster as it is shown."""
        ...

    async def record_step(self, step: StepRecord, strategy_state: Mapping[str, object]) -> None:
        """Store a step's decision with what a replay needs to reach it again; a second record of a step replaces it."""
        ...

    async def record_search(self, search: SearchRecord) -> None:
        """Append what all steps of a search have in common, before the first of them."""
        ...

    async def record_decision(self, decision: DecisionRecord) -> None:
        """Store what a step's decision depended on, besides its frames."""
        ...

    async def record_conclusion(self, conclusion: ConclusionRecord) -> None:
        """Store what was concluded about a step's targets."""
        ...

    async def record_action(self, action: ActionRecord) -> None:
        """Append an operator's action and its results."""
        ...

    async def record_settings(self, settings: SettingsRecord) -> None:
        """Append which settings of a vehicle the mission is about to change, or has restored."""
        ...

    async def record_outcome(self, outcome: OutcomeRecord) -> None:
        """Close the mission."""
        ...

    async def flush(self, *, frames: bool = True) -> None:
        """Return when all of the above is on disk, or all but frames.

        Raises:
            RecordingError: something recorded since the last flush could not be written.
        """
        ...


class Announcer(Protocol):
    """What decisions need of a journal."""

    def elapsed_s(self) -> float:
        """Return the mission time."""
        ...

    def notice(
        self, severity: Severity, text: str, vehicle_id: int | None = None, *, track_id: int | None = None
    ) -> None:
        """Report something to the operators, about a vehicle or the target of a track where it concerns one."""
        ...


class Journal:
    """Numbers, publishes and records what happens in a mission."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._stream = EventStream(clock)
        self._unwritten = self._stream.attach(EVENT_BACKLOG)
        self._missing_count = 0
        self._start_s: float | None = None
        self.started_utc_s: float | None = None
        """Clock time at which the mission's time was 0; None before the start."""
        self._at_start: list[Callable[[float], None]] = []
        """Calls that wait for that time."""
        self._stalls: deque[tuple[float, float]] = deque(maxlen=_STALLS)
        """Time of each of the latest reports of a stall, and its duration."""
        self.steps: list[StepRecord] = []
        self.message = ""
        """Present activity of the mission, in one sentence."""
        self.notice_count = 0
        """Number of the latest notice."""

    def start_timing(self, elapsed_s: float = 0.0) -> None:
        """Begin to count the mission's time, of which some may have passed already."""
        self._start_s = self._clock.now_s() - elapsed_s
        self.started_utc_s = self._clock.utc_s() - elapsed_s
        waiting, self._at_start = self._at_start, []
        for call in waiting:
            call(self.started_utc_s)

    def once_started(self, call: Callable[[float], None]) -> None:
        """Have something called with the clock time of the start: now, or at the start."""
        if self.started_utc_s is None:
            self._at_start.append(call)
        else:
            call(self.started_utc_s)

    def elapsed_s(self) -> float:
        """Return the clock seconds since the start, 0 before."""
        return 0.0 if self._start_s is None else self._clock.now_s() - self._start_s

    def publish(self, kind: EventKind, data: EventData) -> None:
        """Put an event on the stream."""
        self._stream.publish(kind, data)

    def notice(
        self, severity: Severity, text: str, vehicle_id: int | None = None, *, track_id: int | None = None
    ) -> None:
        """Report something to the operators and the log, about a vehicle or the target of a track where it has one."""
        prefix = "" if vehicle_id is None else f"Vehicle {vehicle_id}: "
        _log.log(_LOG_LEVELS[severity], "%s%s", prefix, text)
        self.notice_count += 1
        elapsed_s, utc_s = self.elapsed_s(), self._clock.utc_s()
        record = NoticeRecord(severity, text, vehicle_id, elapsed_s, self.notice_count, utc_s, track_id)
        self.publish(EventKind.NOTICE, record)

    def operator_notice(self, operator: str, text: str) -> None:
        """Report what an operator has ordered or decided, with the sign-in name where there is one."""
        self.notice(Severity.INFO, f"{operator or 'operator'}: {text}")

    def take(self, notice: Notice) -> None:
        """Report a driver's notice."""
        self.notice(notice.severity, notice.text, notice.vehicle_id)

    def set_message(self, text: str) -> None:
        """Say what the mission is doing or waiting for, in one sentence; the next snapshot carries it."""
        self.message = text

    def note_stall(self, stall_s: float) -> None:
        """Report that the station stood still: what looks like lost links then is its own fault."""
        self._stalls.append((self._clock.now_s(), stall_s))
        severity = Severity.CRITICAL if stall_s >= CRITICAL_STALL_S else Severity.WARNING
        self.notice(
            severity,
            f"Station unresponsive for {stall_s:.1f} s: no telemetry received, no commands sent. "
            "Close other programs on this computer",
        )

    def stalled_s(self, within_s: float) -> float:
        """Return the longest stall reported within the last clock seconds; 0 if there was none."""
        since_s = self._clock.now_s() - within_s
        return max((stall_s for at_s, stall_s in self._stalls if at_s >= since_s), default=0.0)

    def step(self, record: StepRecord) -> None:
        """Keep and publish a step."""
        self.steps.append(record)
        self.publish(EventKind.STEP, record)

    def subscribe(self) -> AbstractContextManager[AsyncIterator[Event]]:
        """Follow the stream."""
        return self._stream.subscribe()

    @asynccontextmanager
    async def with_disk_timeout(self, what: str) -> AsyncIterator[None]:
        """Limit the time that the block waits for the disk: neither vehicles nor operators wait for it.

        A full disk is reported by the recorder; a disk that hangs is reported here, with ``what`` may be missing. Where
        this station itself was late meanwhile, it is that which is reported.
        """
        wait = None
        try:
            async with patience(DISK_TIMEOUT_S) as wait:
                yield
        except TimeoutError:
            missing = f"{what} may be missing in the record"
            if wait is not None and wait.is_own_fault:
                text = f"This station is overloaded: {missing}. Close other programs on this computer"
            else:
                text = f"The disk does not answer: {missing}. Check the disk"
            self.notice(Severity.CRITICAL, text)
        except RecordingError as error:
            _log.debug("not recorded: %s", error)

    @asynccontextmanager
    async def recorded(self, recorder: Recorder) -> AsyncIterator[None]:
        """Write every event for as long as the context is entered; leaving waits until all are written.

        Earlier events are written, too: vehicles are heard before a mission begins. It may be entered again, since
        findings are judged after the vehicles have landed. Snapshots are thinned to one per second and phase: the raw
        telemetry is in the .tlog. When the disk is slower than the mission for long, the oldest events are lost, which
        is reported.
        """
        self._unwritten.reopen()
        async with asyncio.TaskGroup() as group:
            writer = group.create_task(self._write(recorder))
            try:
                yield
            finally:
                self._unwritten.close()
                await asyncio.wait({writer})

    async def _write(self, recorder: Recorder) -> None:
        due_utc_s, phase = 0.0, None
        left_out: Event | None = None
        async for event in self._unwritten:
            if isinstance(event.data, MissionSnapshot):
                left_out = event
                if event.utc_s < due_utc_s and event.data.phase is phase:
                    continue
                due_utc_s, phase = event.utc_s + 1.0, event.data.phase
                left_out = None
            await recorder.record_event(event)
            if self._unwritten.dropped > self._missing_count:
                self._missing_count = self._unwritten.dropped
                self.notice(Severity.WARNING, f"The disk is too slow: {self._missing_count} events were not recorded")
        if left_out is not None:
            await recorder.record_event(left_out)
