"""The search: form the line, then step after step sample, see, decide, act, publish."""

from __future__ import annotations

import asyncio
import time
from dataclasses import replace

import numpy as np

from aos_gcs.airspace.waypoints import WaypointRecord, as_enu_point
from aos_gcs.errors import MissionFailedError, UnusableFramesError, WorkerError
from aos_gcs.imaging.model import StepAnalysis
from aos_gcs.mission.context import FlightContext, MissionContext
from aos_gcs.mission.fleet.layers import in_layers
from aos_gcs.mission.fleet.roster import Member
from aos_gcs.mission.handler_watch import WORK_S, sign_of_life
from aos_gcs.mission.model.decisions import DecisionRecord, SearchRecord, Situation, SwarmPlace
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.search.covered_ground import CoveredGround
from aos_gcs.mission.search.deciding import Decider, Decision
from aos_gcs.mission.search.findings import Findings
from aos_gcs.mission.search.gallery import Gallery
from aos_gcs.mission.search.intake import FrameIntake
from aos_gcs.mission.search.ledger import DecisionLog, step_record
from aos_gcs.mission.search.sampling import Sample, Sampler
from aos_gcs.mission.search.vision import Vision
from aos_gcs.planning.legs import ScanLeg, leg_formation, scan_legs
from aos_gcs.planning.settings import MIN_SWARM
from aos_gcs.ports import Goto, Severity

_POLL_S = 0.5

_MAX_BLIND_STEPS = 3
"""Steps in a row without a usable frame, or without their analysis, before the mission gives up."""
_NO_FRAME = "No camera delivered a usable frame"


class Search:
    """The phases LINE, SCAN, CONVERGE and FOUND.

    Args:
        context: context of the flight.
        mission: records the steps, and measures the event loop.
        gallery: publishes the pictures.
        vision: analyses the frames.
        findings: findings of the mission.
    """

    def __init__(
        self, context: FlightContext, mission: MissionContext, gallery: Gallery, vision: Vision, findings: Findings
    ) -> None:
        self._context = context
        self._mission = mission
        self._gallery = gallery
        self._vision = vision
        self._findings = findings
        self._sampler = Sampler(context)
        self.covered_ground = CoveredGround(context, gallery)
        self.decider = Decider(
            context.settings,
            context.journal,
            findings,
            forget=vision.forget,
            covered_fraction=lambda: self.covered_ground.covered_fraction,
        )
        self._log = DecisionLog(self.decider, findings)
        self._blind_steps = 0
        self.step = 0

    # --- LINE ---------------------------------------------------------------------------------------------------------

    async def line(self) -> Phase:
        """Form the line at the present place of the present leg."""
        context, progress = self._context, self.decider.progress
        swarm = await self._swarm()
        if not progress.legs:
            progress.plan(self._plan_legs(swarm))
        leg = progress.remaining_leg
        context.journal.set_message(f"Forming the line for leg {progress.leg + 1} of {len(progress.legs)}.")
        places_enu_m = leg_formation(leg, context.roster.positions_enu_m(swarm)[:, :2], self.decider.spacing_m)
        late = await context.flight.transfer(
            in_layers(swarm, places_enu_m, context.roster.layers.known_surface()), frozenset({Task.SWARM})
        )
        for member in late:
            context.journal.notice(Severity.WARNING, "did not reach its place in the line in time", member.vehicle_id)
        self.decider.begin_line(leg)
        self._log.note_line(leg)
        return Phase.SCAN

    def _plan_legs(self, swarm: list[Member]) -> tuple[ScanLeg, ...]:
        settings = self._context.settings
        lowest_m = min(member.layer_height_m or settings.flight.lowest_layer_m for member in swarm)
        return scan_legs(
            settings.area_enu_m,
            self._context.roster.positions_enu_m(swarm)[:, :2].mean(axis=0),
            np.array(settings.scan_direction_enu),
            n=len(swarm),
            spacing_m=self.decider.spacing_m,
            footprint_m=2 * (lowest_m - settings.imaging.plane_height_m) * np.tan(settings.planning_fov_rad / 2),
        )

    # --- SCAN, CONVERGE, FOUND ----------------------------------------------------------------------------------------

    async def make_step(self, phase: Phase) -> Phase:
        """Make one step: sample, see, decide, act, publish; return the phase of the next one."""
        context = self._context
        swarm = await self._swarm()
        self.step += 1
        context.journal.set_message(f"Step {self.step}: capturing images.")
        async with self._vision.intake(self.step) as intake:
            taken = await self._sampler.take(self.step, swarm, intake.add)
            received_at_s = time.perf_counter()
        if not taken.captures:
            return self._count_blind_step(phase, _NO_FRAME, _reasons(taken))
        try:
            taken, analysis = await self._see(intake, taken)
        except WorkerError as error:
            text = f"Step {self.step} is repeated: {error}. Fault of this station; the swarm holds its position"
            context.journal.notice(Severity.WARNING, text)
            return self._count_blind_step(phase, "No images could be analysed", str(error))
        if analysis is None:
            return self._count_blind_step(phase, _NO_FRAME, _reasons(taken))
        self._blind_steps = 0
        imaging_ms = _ms_since(received_at_s)
        context.journal.set_message(f"Step {self.step}: moving.")
        decision, record, reasons = self._decide(phase, swarm, taken, analysis)
        work_ms = await self._act(record, reasons, received_at_s)
        await self._publish(
            replace(
                record,
                imaging_ms=imaging_ms,
                work_ms=work_ms,
                loop_lag_p99_ms=self._mission.loop_monitor.take_step_lag_p99_ms(),
                focal_height_m=analysis.grid.height_m,
            ),
        )
        sign_of_life(WORK_S)
        await self._gallery.render(self.step, self._vision.frames(analysis), analysis)
        await self.covered_ground.note(self.step, taken, analysis)
        async with asyncio.TaskGroup() as group:
            learning = group.create_task(self._learn(analysis, decision))
            await self._await_arrival(record.waypoints)
            sign_of_life(WORK_S)
        return learning.result()

    async def _see(self, intake: FrameIntake, taken: Sample) -> tuple[Sample, StepAnalysis | None]:
        """Analyse the frames, and count those that cannot be used as missing; None if that leaves none."""
        target = self.decider.tracker.estimate()
        target_enu_m = None if target is None else target.position_enu_m
        try:
            analysis = await self._vision.see(intake, taken, self._log.begin_analysis(), target_enu_m)
        except UnusableFramesError as error:
            return self._sampler.leave_out(self.step, taken, error.reasons), None
        return self._sampler.leave_out(self.step, taken, analysis.skipped), analysis

    def _count_blind_step(self, phase: Phase, problem: str, details: str) -> Phase:
        self._blind_steps += 1
        if self._blind_steps >= _MAX_BLIND_STEPS:
            raise MissionFailedError(f"{problem} in {self._blind_steps} steps ({details}).")
        return phase

    def _situation(self, swarm: list[Member]) -> Situation:
        context = self._context
        places = [
            SwarmPlace(member.vehicle_id, as_enu_point(position_enu_m), member.layer_height_m)
            for member in swarm
            if (position_enu_m := context.roster.position_enu_m(member)) is not None
        ]
        traffic = context.flight.situation([member.vehicle_id for member in swarm])
        return Situation(context.journal.elapsed_s(), tuple(places), traffic)

    def _decide(
        self, phase: Phase, swarm: list[Member], taken: Sample, analysis: StepAnalysis
    ) -> tuple[Decision, StepRecord, DecisionRecord]:
        """Decide, and return the records of the step and of all that the decision depended on."""
        situation, edits = self._situation(swarm), self._log.take_edits()
        flight, surface = self._context.flight, self._context.roster.layers.known_surface()
        decision = self.decider.decide(phase, situation, flight.detours, analysis, flight.ground, surface=surface)
        poses = self._vision.corrected_poses()
        record = self._log.decision(self.step, phase, situation, analysis, decision, poses=poses, edits=edits)
        step = step_record(
            self.step,
            phase,
            situation.now_s,
            self.decider,
            analysis=analysis,
            decision=decision,
            missing=taken.missing,
        )
        return decision, step, record

    async def _act(self, record: StepRecord, reasons: DecisionRecord, received_at_s: float) -> float:
        """Record the decision, then send it; return the milliseconds from the last frame to the last goto on the link.

        Recorded before it is acted on: what the vehicles are commanded is on disk even if we die while commanding them.
        """
        context, recorder = self._context, self._mission.recorder
        async with context.journal.with_disk_timeout(f"step {self.step}"):
            if reasons.decided == 0:
                await recorder.record_search(SearchRecord(context.settings, context.roster.local_frame().origin))
            await recorder.record_step(record, self.decider.strategy_state())
            await recorder.record_decision(reasons)
            await recorder.flush()
        handed_over_ms = [_ms_since(received_at_s)]
        await context.flight.send(record.waypoints, lambda: handed_over_ms.append(_ms_since(received_at_s)))
        return handed_over_ms[-1]

    async def _publish(self, record: StepRecord) -> None:
        journal = self._context.journal
        async with journal.with_disk_timeout(f"step {self.step}"):
            await self._mission.recorder.record_step(record, self.decider.strategy_state())
        journal.step(record)

    async def _learn(self, analysis: StepAnalysis, decision: Decision) -> Phase:
        """Learn from the step's frames while the vehicles move, decide what was seen, and return the next phase."""
        tracker, journal = self.decider.tracker, self._context.journal
        judgements = await self._vision.learn(self.step, analysis, tracker.places_enu_m())
        edits, now_s = self._log.take_edits(), journal.elapsed_s()
        following = self.decider.conclude(decision.following, judgements or {})
        targets = tracker.estimates()
        for finding in self._findings.observe(targets, self.step, now_s):
            east_m, north_m, _ = finding.position_enu_m
            text = f"Finding {finding.finding_id} at {east_m:.1f} m east, {north_m:.1f} m north"
            journal.notice(Severity.INFO, text, track_id=finding.track_id)
        for finding in self._findings.merge(targets):
            same = finding.merged_into
            change = "is no longer the same as another one" if same is None else f"is the same as finding {same}"
            journal.notice(Severity.INFO, f"Finding {finding.finding_id} {change}")
        record = self._log.conclusion(self.step, now_s, following, targets, judged=judgements is not None, edits=edits)
        async with journal.with_disk_timeout(f"conclusion of step {self.step}"):
            await self._mission.recorder.record_conclusion(record)
        return following

    async def _await_arrival(self, waypoints: tuple[WaypointRecord, ...]) -> None:
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

    async def _swarm(self) -> list[Member]:
        """Return the swarm; with too few left, wait for lost ones. When all are lost, the monitor ends the mission."""
        context = self._context
        deadline_s = context.clock.now_s() + context.settings.deadlines.all_lost_s
        while len(swarm := context.roster.members(Task.SWARM)) < MIN_SWARM:
            lost = context.roster.members(Task.LOST)
            if not lost or (swarm and context.clock.now_s() > deadline_s):
                raise MissionFailedError(
                    f"The swarm needs {MIN_SWARM} vehicles, but has {len(swarm)} left and {len(lost)} lost."
                )
            context.journal.set_message(f"Waiting for {len(lost)} lost vehicles.")
            sign_of_life()
            await context.clock.sleep(_POLL_S)
        return swarm


def _reasons(taken: Sample) -> str:
    return "; ".join(f"vehicle {vehicle_id}: {reason}" for vehicle_id, reason in taken.missing.items())


def _ms_since(start_s: float) -> float:
    return 1e3 * (time.perf_counter() - start_s)
