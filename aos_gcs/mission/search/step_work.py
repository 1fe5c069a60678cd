"""The work on a step's frames: see, decide, act, publish, learn; the same for frames taken at rest and in flight."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from aos_gcs.airspace.waypoints import WaypointRecord, as_enu_point
from aos_gcs.errors import MissionFailedError, UnusableFramesError, WorkerError
from aos_gcs.imaging.model import StepAnalysis
from aos_gcs.mission.context import FlightContext, MissionContext
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.handler_watch import WORK_S, sign_of_life
from aos_gcs.mission.model.decisions import Decision, DecisionRecord, Group, SearchRecord, Situation, SwarmPlace
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.search.decisions.decider import Decider
from aos_gcs.mission.search.decisions.ledger import DecisionLog, step_record
from aos_gcs.mission.search.frames.intake import FrameIntake
from aos_gcs.mission.search.frames.sampling import Sample, Sampler
from aos_gcs.mission.search.frames.vision import Vision
from aos_gcs.mission.search.gallery import Gallery
from aos_gcs.mission.search.ground.covered_ground import CoveredGround
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.ports import Goto, Severity

_MAX_BLIND_STEPS = 3
"""Steps in a row without a usable frame, or without their analysis, before the mission gives up."""
_NO_FRAME = "No camera delivered a usable frame"

LeaveOut = Callable[[int, Sample, Mapping[int, str]], Sample]
"""Returns a step's sample without the frames of some vehicles, and reports why."""


class SweepFlight(Protocol):
    """A sweep under way, as the work on its steps sees it."""

    def send(self, waypoints: Sequence[WaypointRecord]) -> None:
        """Send vetted waypoints while others work."""
        ...

    def give_way(self) -> None:
        """Send no more of the sweep: the vehicles are about to be sent elsewhere."""
        ...

    async def finish(self) -> None:
        """Expose no more in flight."""
        ...

    def leave_out(self, step: int, taken: Sample, reasons: Mapping[int, str]) -> Sample:
        """Return the sample without the frames of some vehicles, and report why."""
        ...

    @property
    def is_behind(self) -> bool:
        """Whether frames wait for analysis, so that nothing is done that can be left out."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Worked:
    """A step that was decided, and is still to be concluded."""

    step: int
    analysis: StepAnalysis
    decision: Decision


class StepWork:
    """Works on the frames of one step after another.

    Groups of a split swarm take turns: the one that has :attr:`turn` numbers a step, sees, decides, records and sends.

    Args:
        context: context of the flight.
        mission: records the steps, and measures the event loop.
        gallery: publishes the pictures.
        vision: analyses the frames.
        findings: findings of the mission.
        decider: decides what follows.
        sampler: reports the vehicles that a step goes on without.
        covered_ground: notes what the frames show.
    """

    def __init__(
        self,
        context: FlightContext,
        mission: MissionContext,
        gallery: Gallery,
        vision: Vision,
        findings: Findings,
        *,
        decider: Decider,
        sampler: Sampler,
        covered_ground: CoveredGround,
    ) -> None:
        self._context = context
        self._mission = mission
        self._gallery = gallery
        self._vision = vision
        self._findings = findings
        self._decider = decider
        self._sampler = sampler
        self._covered_ground = covered_ground
        self.log = DecisionLog(decider, findings)
        self._blind_steps = 0
        self._problem = _NO_FRAME, ""
        """Why the latest step has led to no decision."""
        self._step = 0
        self.turn = asyncio.Lock()
        """Held by the group whose step is decided."""

    @property
    def step(self) -> int:
        """Number of the present step."""
        return self._step

    def begin_step(self) -> None:
        """Number the next step; in a split swarm, the group that has the turn does."""
        self._step += 1

    async def work_on(
        self,
        phase: Phase,
        swarm: list[Member],
        intake: FrameIntake,
        taken: Sample,
        *,
        may_sweep: bool,
        sweep: SweepFlight | None = None,
    ) -> tuple[Phase, Decision | None]:
        """Return the phase of the next step, and the decision; None where the frames lead to none.

        Waits for the arrival of the vehicles, unless they are to sweep on. Arguments as for :meth:`decide_on`.
        """
        worked = await self.decide_on(phase, swarm, intake, taken, may_sweep=may_sweep, sweep=sweep)
        if worked is None:
            return self.count_blind_step(phase, taken), None
        return await self.conclude(worked), worked.decision

    async def decide_on(
        self,
        phase: Phase,
        swarm: list[Member],
        intake: FrameIntake,
        taken: Sample,
        *,
        may_sweep: bool,
        sweep: SweepFlight | None = None,
        group: Group | None = None,
        vision: Vision | None = None,
        send: Callable[[Sequence[WaypointRecord]], None] | None = None,
    ) -> Worked | None:
        """See, decide, record, send and publish a step; None where the frames lead to no decision.

        Args:
            phase: phase of this step.
            swarm: vehicles of the swarm, or of a group of it.
            intake: intake of the frames, which is over.
            taken: frames that were taken, if any.
            may_sweep: whether the vehicles may fly along the leg without stops.
            sweep: the sweep in which they were taken; None: at rest.
            group: group whose step it is, in a split swarm.
            vision: sees the frames of the scanning group; None: that of the search.
            send: begins to send the waypoints of the close look, for whose confirmation the others do not wait.
        """
        context, received_at_s = self._context, intake.received_at_s
        vision, self._problem = self._vision if vision is None else vision, (_NO_FRAME, "")
        if not taken.captures:
            return None
        try:
            leave_out = self._sampler.leave_out if sweep is None else sweep.leave_out
            taken, analysis = await self._see(vision, intake, taken, leave_out, group)
        except WorkerError as error:
            text = f"Step {self.step} is repeated: {error}. Fault of this station; the swarm holds its position"
            context.journal.notice(Severity.WARNING, text)
            self._problem = "No images could be analysed", str(error)
            return None
        if analysis is None:
            self._problem = _NO_FRAME, _reasons(taken)
            return None
        if group is not Group.SCAN:
            self._blind_steps = 0
        imaging_ms = _ms_since(received_at_s)
        if sweep is None:
            context.journal.set_message(f"Step {self.step}: moving.")
        situation = self._situation(swarm, intake, taken)
        decision, record, reasons = self._decide(
            vision, phase, situation, taken, analysis, may_sweep=may_sweep, group=group
        )
        is_recorded = await self._record(record, reasons)
        work_ms = _ms_since(received_at_s)
        if send is not None:
            send(decision.waypoints)
        elif decision.is_sweep or group is not Group.SCAN:
            work_ms = await self._send(decision, sweep, received_at_s)
        await self._publish(
            replace(
                record,
                imaging_ms=imaging_ms,
                work_ms=work_ms,
                loop_lag_p99_ms=self._mission.loop_monitor.take_step_lag_p99_ms(),
                focal_height_m=analysis.grid.height_m,
            ),
            is_recorded=is_recorded,
        )
        sign_of_life(WORK_S)
        # Operators are shown what the look sees.
        if group is not Group.SCAN and (sweep is None or not sweep.is_behind):
            await self._gallery.render(self.step, vision.frames(analysis), analysis)
        await self._covered_ground.note(self.step, taken, analysis, vision.frames(analysis))
        return Worked(self.step, analysis, decision)

    async def conclude(self, worked: Worked) -> Phase:
        """Conclude a step while its vehicles fly, wait for their arrival unless they sweep, return the next phase.

        Vehicles of a split swarm that look closely wait for each other only.
        """
        decision, split = worked.decision, self._decider.split
        awaited = [one for one in decision.waypoints if split is None or one.vehicle_id in split.look_ids]
        async with asyncio.TaskGroup() as group:
            learning = group.create_task(self._learn(worked))
            if not decision.is_sweep:
                await self.await_arrival(awaited)
            sign_of_life(WORK_S)
        return learning.result()

    async def _see(
        self, vision: Vision, intake: FrameIntake, taken: Sample, leave_out: LeaveOut, group: Group | None
    ) -> tuple[Sample, StepAnalysis | None]:
        """Analyse the frames, and count those that cannot be used as missing; None if that leaves none."""
        target = None if group is Group.SCAN else self._decider.tracker.estimate()
        target_enu_m = None if target is None else target.position_enu_m
        try:
            analysis = await vision.see(intake, taken, self.log.begin_analysis(group), target_enu_m)
        except UnusableFramesError as error:
            return leave_out(self.step, taken, error.reasons), None
        return leave_out(self.step, taken, analysis.skipped), analysis

    def count_blind_step(self, phase: Phase, taken: Sample) -> Phase:
        """Count a step that has led to no decision, and return its phase.

        Raises:
            MissionFailedError: it was one too many.
        """
        problem, details = self._problem
        self._blind_steps += 1
        if self._blind_steps >= _MAX_BLIND_STEPS:
            raise MissionFailedError(f"{problem} in {self._blind_steps} steps ({details or _reasons(taken)}).")
        return phase

    def _situation(self, swarm: list[Member], intake: FrameIntake, taken: Sample) -> Situation:
        """Return the state of the flight; vehicles are where they exposed in flight."""
        context = self._context
        exposed_enu_m = {key: intake.frames[key].pose.position_enu_m for key in taken.speeds_mps}
        places_enu_m = {
            member.vehicle_id: exposed_enu_m.get(member.vehicle_id, context.roster.position_enu_m(member))
            for member in swarm
        }
        places = [
            SwarmPlace(member.vehicle_id, as_enu_point(place_enu_m), member.layer_height_m)
            for member in swarm
            if (place_enu_m := places_enu_m[member.vehicle_id]) is not None
        ]
        traffic = context.flight.situation([member.vehicle_id for member in swarm])
        return Situation(context.journal.elapsed_s(), tuple(places), traffic)

    def _decide(
        self,
        vision: Vision,
        phase: Phase,
        situation: Situation,
        taken: Sample,
        analysis: StepAnalysis,
        *,
        may_sweep: bool,
        group: Group | None,
    ) -> tuple[Decision, StepRecord, DecisionRecord]:
        """Decide, and return the records of the step and of all that the decision depended on."""
        edits = () if group is Group.SCAN else self.log.take_edits()
        bounds, surface = self._context.bounds, self._context.roster.layers.known_surface()
        decision = self._decider.decide(
            phase, situation, bounds.detours, analysis, bounds.ground, surface=surface, may_sweep=may_sweep, group=group
        )
        record = self.log.decision(
            self.step,
            phase,
            situation,
            analysis,
            decision,
            poses=vision.corrected_poses(),
            edits=edits,
            may_sweep=may_sweep,
            speeds_mps=taken.speeds_mps,
            group=group,
        )
        step = step_record(
            self.step,
            phase,
            situation.now_s,
            self._decider,
            analysis=analysis,
            decision=decision,
            missing=taken.missing,
        )
        return decision, step, record

    async def _record(self, record: StepRecord, reasons: DecisionRecord) -> bool:
        """Record the decision: what the vehicles are commanded is on disk even if we die while commanding them.

        Its frames follow: no command waits for them. Returns whether the disk has taken it.
        """
        context, recorder = self._context, self._mission.recorder
        async with context.journal.with_disk_timeout(f"step {self.step}"):
            if reasons.decided == 0:
                origin, left = context.roster.local_frame().origin, self._decider.choice.taken_up
                await recorder.record_search(SearchRecord(context.settings, origin, left))
            await recorder.record_step(record, self._decider.strategy_state())
            await recorder.record_decision(reasons)
            await recorder.flush(frames=False)
            return True
        return False

    async def _send(self, decision: Decision, sweep: SweepFlight | None, received_at_s: float) -> float:
        """Send the waypoints; return the milliseconds from the last frame to the last goto on the link.

        Those that begin a sweep are sent by it.
        """
        handed_over_ms = [_ms_since(received_at_s)]
        if decision.is_sweep:
            if sweep is not None:
                sweep.send(decision.waypoints)
            return handed_over_ms[-1]
        if sweep is not None:
            sweep.give_way()
        await self._context.flight.send(decision.waypoints, lambda: handed_over_ms.append(_ms_since(received_at_s)))
        if sweep is not None:
            await sweep.finish()
        return handed_over_ms[-1]

    async def _publish(self, record: StepRecord, *, is_recorded: bool) -> None:
        """Record what the step took, and publish it; a disk that has not taken the decision is not waited for again."""
        journal, recorder = self._context.journal, self._mission.recorder
        async with journal.with_disk_timeout(f"step {self.step}"):
            await recorder.record_step(record, self._decider.strategy_state())
            if is_recorded:
                # Clients read the frames of a step as soon as they are sent it.
                await recorder.flush()
        journal.step(record)

    async def _learn(self, worked: Worked) -> Phase:
        """Learn from the step's frames while the vehicles move, decide what was seen, and return the next phase."""
        tracker, journal, step, decision = self._decider.tracker, self._context.journal, worked.step, worked.decision
        judgements = await self._vision.learn(step, worked.analysis, tracker.places_enu_m())
        edits, now_s = self.log.take_edits(), journal.elapsed_s()
        following = self._decider.conclude(decision.following, judgements or {})
        targets = tracker.estimates()
        for finding in self._findings.observe(targets, step, now_s):
            east_m, north_m, _ = finding.position_enu_m
            text = f"Finding {finding.finding_id} at {east_m:.1f} m east, {north_m:.1f} m north"
            journal.notice(Severity.INFO, text, track_id=finding.track_id)
        for finding in self._findings.merge(targets):
            same = finding.merged_into
            change = "is no longer the same as another one" if same is None else f"is the same as finding {same}"
            journal.notice(Severity.INFO, f"Finding {finding.finding_id} {change}")
        record = self.log.conclusion(step, now_s, following, targets, judged=judgements is not None, edits=edits)
        async with journal.with_disk_timeout(f"conclusion of step {step}"):
            await self._mission.recorder.record_conclusion(record)
        return following

    async def await_arrival(self, waypoints: Sequence[WaypointRecord]) -> None:
        """Wait until the vehicles that were sent hover at their waypoints; report those that are late."""
        sent_ids = {record.vehicle_id for record in waypoints if record.sent_enu_m is not None}
        context = self._context

        def travelling() -> list[Member]:
            swarm = context.roster.members(Task.SWARM)
            # A vehicle that has refused its waypoint stays where it is.
            return [one for one in swarm if one.vehicle_id in sent_ids and isinstance(one.last_command, Goto)]

        late = await context.flight.wait_until(
            travelling, context.flight.has_arrived, context.settings.deadlines.move_s
        )
        for member in late:
            context.journal.notice(Severity.WARNING, "has not reached its waypoint in time", member.vehicle_id)


def _reasons(taken: Sample) -> str:
    return "; ".join(f"vehicle {vehicle_id}: {reason}" for vehicle_id, reason in taken.missing.items())


def _ms_since(start_s: float) -> float:
    return 1e3 * (time.perf_counter() - start_s)
