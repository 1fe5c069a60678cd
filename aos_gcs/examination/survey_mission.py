"""A survey as the dashboard shows it: like a mission, but without vehicles."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Final

from aos_gcs.errors import MissionError, RecordingError
from aos_gcs.examination.state import SurveyState
from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.mission.events import EventStream
from aos_gcs.mission.model.events import Event, EventData, EventKind, NoticeRecord, PicturesRecord
from aos_gcs.mission.model.findings import Finding, FindingChange, FindingStatus, TargetEstimate
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import Picture, PictureKind, StepRecord
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.ports import Clock, Severity
from aos_gcs.store.recorder import MissionRecorder

REPORT_S: Final = 0.5
"""Time between two signs of life, in seconds."""


class SurveyMission:
    """Implements ``MissionView`` and ``FindingCommands`` on a survey; whatever changes is on the disk when it is told.

    Args:
        state: state so far.
        recorder: record of the survey.
        clock: clock of the examination.
    """

    def __init__(self, state: SurveyState, recorder: MissionRecorder, clock: Clock) -> None:
        self._state = state
        self._recorder = recorder
        self._clock = clock
        self._stream = EventStream(clock)
        self._stream.count = state.event_count
        self._findings = Findings()
        self._findings.adopt(state.findings)
        self._began_s = clock.now_s() - state.snapshot.elapsed_s

    # --- MissionView --------------------------------------------------------------------------------------------------

    def snapshot(self) -> MissionSnapshot:
        """Return the present state."""
        return self._state.snapshot

    def steps(self) -> Sequence[StepRecord]:
        """Return the windows examined so far, oldest first."""
        return self._state.steps

    def picture(self, kind: PictureKind) -> Picture | None:
        """Return the latest map of a kind."""
        return self._state.pictures.get(kind)

    def subscribe(self) -> AbstractContextManager[AsyncIterator[Event]]:
        """Follow the events from now on."""
        return self._stream.subscribe()

    # --- FindingCommands ----------------------------------------------------------------------------------------------

    async def add_finding(self, position_enu_m: EnuPoint, comment: str, *, operator: str = "") -> Finding:
        """Mark a place by hand; see ``FindingCommands.add_finding``."""
        step = self._nearest_step(position_enu_m)
        focus, (east_m, north_m, up_m) = self._state.snapshot.focus, position_enu_m
        heights_m = {record.step: record.focal_height_m for record in self._state.steps}
        ground_m = heights_m.get(step) or (up_m if focus is None else focus.height_m)
        finding = self._findings.add((east_m, north_m, ground_m), comment, operator, step, self.elapsed_s())
        await self._keep(operator, f"finding {finding.finding_id} marked")
        return finding

    async def change_finding(self, finding_id: int, change: FindingChange, *, operator: str = "") -> Finding:
        """Judge, comment or assign a finding; see ``FindingCommands.change_finding``."""
        finding = self._findings.change(finding_id, change, operator)
        if change.is_empty:
            return finding
        changes = {"": change.status, "comment: ": change.comment, "assigned to ": change.assignee}
        texts = [f"{label}{value!s}" for label, value in changes.items() if value is not None]
        await self._keep(operator, f"finding {finding_id} {', '.join(texts)}")
        return finding

    async def _keep(self, operator: str, text: str) -> None:
        """Record what an operator has decided, or refuse it."""
        before = self._state.snapshot.findings
        await self.notice(Severity.INFO, f"{operator or 'operator'}: {text}")
        await self.update()
        try:
            await self._recorder.flush()
        except RecordingError as error:
            self._findings = Findings()
            self._findings.adopt(before)
            self._change()
            self._stream.publish(EventKind.SNAPSHOT, self._state.snapshot)
            raise MissionError(f"The decision is not kept: {error}.") from error

    def _nearest_step(self, position_enu_m: EnuPoint) -> int:
        """Return the step of the nearest finding that frames show, or the latest one."""
        shown = [finding for finding in self._findings.all() if finding.step >= 1]
        nearest = min(shown, key=lambda one: _distance2_m2(one.position_enu_m, position_enu_m), default=None)
        return self._state.snapshot.step if nearest is None else nearest.step

    # --- Examination --------------------------------------------------------------------------------------------------

    @property
    def persons(self) -> int:
        """Number of findings that count as persons."""
        return len(self._findings.persons())

    def elapsed_s(self) -> float:
        """Return the seconds that the examination has taken."""
        return self._state.snapshot.elapsed_s if self._state.is_finished else self._clock.now_s() - self._began_s

    def known_at(self, position_enu_m: EnuPoint, within_m: float) -> Finding | None:
        """Return the nearest finding at a place that frames have shown and nobody has rejected."""
        near = [
            (distance_m2, finding.finding_id, finding)
            for finding in self._findings.all()
            if finding.track_id is not None and finding.status is not FindingStatus.REJECTED
            if (distance_m2 := _distance2_m2(finding.position_enu_m, position_enu_m)) <= within_m**2
        ]
        return min(near)[2] if near else None

    def observe(self, targets: Sequence[TargetEstimate], step: int) -> tuple[Finding, ...]:
        """Take in what a window shows, and return the findings that are new."""
        new = self._findings.observe(targets, step, self.elapsed_s())
        self._findings.merge(targets)
        reasons = {target.track_id: target.reasons for target in targets}
        # Missions keep the reasons of the decision that was announced; here, those of the window that is shown count.
        self._findings.adopt(
            [
                replace(finding, reasons=reasons[finding.track_id])
                for finding in self._findings.all()
                if finding.track_id in reasons
            ]
        )
        return new

    async def add_step(self, record: StepRecord) -> None:
        """Add a window, whose frames are recorded already: whoever receives the event can read them.

        Raises:
            RecordingError: it cannot be written.
        """
        await self._recorder.record_step(record, {})
        await self._recorder.flush()
        self._state.steps.append(record)
        await self._publish(EventKind.STEP, record)

    async def add_pictures(self, pictures: Sequence[Picture]) -> None:
        """Show other maps, of the same bounds."""
        self._state.pictures |= {picture.kind: picture for picture in pictures}
        first = pictures[0]
        for picture in pictures:
            await self._recorder.record_picture(picture)
        kinds = tuple(picture.kind for picture in pictures)
        bounds = first.west_m, first.south_m, first.east_m, first.north_m
        await self._publish(EventKind.PICTURES, PicturesRecord(first.step, kinds, *bounds))

    async def notice(self, severity: Severity, text: str) -> None:
        """Report something."""
        self._state.notice_count += 1
        number, utc_s = self._state.notice_count, self._clock.utc_s()
        record = NoticeRecord(severity, text, None, self.elapsed_s(), number, utc_s)
        await self._publish(EventKind.NOTICE, record)

    async def update(self, **changes: object) -> None:
        """Publish and record the state with changes of its fields."""
        self._change(**changes)
        await self._publish(EventKind.SNAPSHOT, self._state.snapshot)

    async def report(self) -> None:
        """Publish signs of life until cancelled: a page that hears nothing says so."""
        while True:
            await self._clock.sleep(REPORT_S)
            if not self._state.is_finished:
                self._change()
                self._stream.publish(EventKind.SNAPSHOT, self._state.snapshot)

    def _change(self, **changes: object) -> None:
        known = {"elapsed_s": self.elapsed_s(), "findings": self._findings.all()}
        self._state.snapshot = replace(self._state.snapshot, **(known | changes))  # type: ignore[arg-type]

    async def _publish(self, kind: EventKind, data: EventData) -> None:
        await self._recorder.record_event(self._stream.publish(kind, data))


def _distance2_m2(one: EnuPoint, other: EnuPoint) -> float:
    return float((one[0] - other[0]) ** 2 + (one[1] - other[1]) ** 2)
