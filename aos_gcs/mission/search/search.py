"""The search: form the line, then step after step sample, see, choose, check, go."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict
from aos_gcs.errors import MissionFailedError, UnusableFramesError
from aos_gcs.imaging.model import StepAnalysis
from aos_gcs.imaging.persons.classifier import DECISION
from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.fleet.roster import Member
from aos_gcs.mission.launch import MIN_SWARM
from aos_gcs.mission.model import Outcome, Phase, StepRecord, Task
from aos_gcs.mission.search.cameras import footprint_enu_m
from aos_gcs.mission.search.coverage import CoverageMap
from aos_gcs.mission.search.findings import Findings
from aos_gcs.mission.search.gallery import Gallery
from aos_gcs.mission.search.observing import make_observation
from aos_gcs.mission.search.sampling import Sample, sample, to_frame
from aos_gcs.mission.search.stalls import StallWatch, place_ahead_m
from aos_gcs.mission.search.targeting import TargetTracker
from aos_gcs.mission.search.vision import Vision
from aos_gcs.planning.legs import ScanLeg, leg_formation, scan_legs
from aos_gcs.ports import Severity
from aos_gcs.swarm.model import Diagnostics, Strategy
from aos_gcs.swarm.registry import make_strategy
from aos_gcs.swarm.state import dump_rng

_POLL_S = 0.5

_MAX_BLIND_STEPS = 3
"""Steps in a row without a single usable frame before the mission gives up."""


class Search:
    """The phases LINE, SCAN, CONVERGE and FOUND."""

    def __init__(self, context: MissionContext, gallery: Gallery, vision: Vision, findings: Findings) -> None:
        settings = context.settings
        self._context = context
        self._gallery = gallery
        self._vision = vision
        self._findings = findings
        self._rng = np.random.default_rng(settings.seed)
        self._strategy: Strategy[Any] = make_strategy(settings.strategy, settings.strategy_parameters)
        self._state = self._strategy.init(np.array(settings.scan_direction_enu))
        self._coverage: CoverageMap | None = None
        self._progress_m = 0.0
        self._stalls = StallWatch(settings.flight.arrival_radius_m)
        self._barred: tuple[WaypointRecord, ...] = ()
        """Of the latest step: what was not sent as it was planned."""
        self._left_out_m = 0.0
        """Of all legs: their stretches that were not flown."""
        self._blind_steps = 0
        self._steps_found = 0
        self.found_at_s: float | None = None
        """Mission time of the first decision that the target is found."""
        self.step = 0
        self.legs: tuple[ScanLeg, ...] = ()
        """Empty before they are planned."""
        self.leg = 0
        """Index of the one being flown."""
        self.tracker = TargetTracker(settings)

    # --- LINE ---------------------------------------------------------------------------------------------------------

    async def line(self) -> Phase:
        """Form the line at the present place of the present leg."""
        context = self._context
        swarm = await self._swarm()
        if not self.legs:
            self.legs = self._plan_legs(swarm)
        leg = self.legs[self.leg].after(self._progress_m)
        context.message = f"Forming the line for leg {self.leg + 1} of {len(self.legs)}."
        places_enu_m = leg_formation(leg, self._horizontal_enu_m(swarm), self._strategy.spacing_m)
        requests = self._in_layers(swarm, places_enu_m)
        late = await context.flight.transfer(requests, frozenset({Task.SWARM}))
        for member in late:
            context.journal.notice(Severity.WARNING, "did not reach its place in the line in time", member.vehicle_id)
        self._state = self._strategy.init(np.array(leg.direction_enu))
        self._stalls.restart()
        return Phase.SCAN

    def _plan_legs(self, swarm: list[Member]) -> tuple[ScanLeg, ...]:
        settings = self._context.settings
        lowest_m = min(member.layer_height_m or settings.flight.lowest_layer_m for member in swarm)
        return scan_legs(
            settings.area_enu_m,
            self._horizontal_enu_m(swarm).mean(axis=0),
            np.array(settings.scan_direction_enu),
            n=len(swarm),
            spacing_m=self._strategy.spacing_m,
            footprint_m=2 * (lowest_m - settings.imaging.plane_height_m) * np.tan(settings.planning_fov_rad / 2),
        )

    @property
    def covered_fraction(self) -> float | None:
        """Share of the search area that was in a frame; None before the first step."""
        return None if self._coverage is None else self._coverage.covered_fraction

    # --- SCAN, CONVERGE, FOUND ----------------------------------------------------------------------------------------

    async def make_step(self, phase: Phase) -> Phase:
        """Make one step: sample, see, choose, check, record, go; return the phase of the next one."""
        context = self._context
        swarm = await self._swarm()
        self.step += 1
        context.message = f"Step {self.step}: taking frames."
        taken = await self._sample(swarm)
        if not taken.captures:
            return self._count_blind_step(phase, taken)
        received_at_s = time.perf_counter()
        taken, analysis = await self._see(taken)
        if analysis is None:
            return self._count_blind_step(phase, taken)
        self._blind_steps = 0
        imaging_ms = _ms_since(received_at_s)
        context.message = f"Step {self.step}: moving."
        following, record = self._decide(phase, swarm, taken, analysis)
        work_ms = await self._act(record, received_at_s)
        await self._publish(
            replace(
                record,
                imaging_ms=imaging_ms,
                work_ms=work_ms,
                loop_lag_p99_ms=context.loop_monitor.take_step_lag_p99_ms(),
                focal_height_m=analysis.grid.height_m,
            ),
        )
        await self._gallery.hang(record.step, analysis, taken.captures[0].bands)
        await self._survey(taken, analysis)
        async with asyncio.TaskGroup() as group:
            group.create_task(self._learn(analysis))
            await self._await_arrival(record.waypoints)
        return following

    async def _learn(self, analysis: StepAnalysis) -> None:
        await self._vision.learn(self.step, analysis)
        self.tracker.judge(self._vision.persons.confidence_at)
        journal = self._context.journal
        for finding in self._findings.observe(self.tracker.estimates(), self.step, journal.elapsed_s()):
            east_m, north_m, _ = finding.position_enu_m
            journal.notice(Severity.INFO, f"finding {finding.finding_id} at {east_m:.1f} m east, {north_m:.1f} m north")

    async def _sample(self, swarm: list[Member]) -> Sample:
        """Take the frames of those that hover; others would blur, and are named."""
        context = self._context
        deadline_s = context.clock.now_s() + context.settings.deadlines.capture_s
        unsteady = self._unsteady(swarm)
        while len(unsteady) == len(swarm) and context.clock.now_s() < deadline_s:
            await context.clock.sleep(_POLL_S)
            unsteady = self._unsteady(swarm)
        hovering = [member for member in swarm if member.vehicle_id not in unsteady]
        taken = await sample(hovering, max(deadline_s, context.clock.now_s() + _POLL_S))
        return self._without(Sample(taken.captures, {}), unsteady | taken.missing)

    async def _see(self, taken: Sample) -> tuple[Sample, StepAnalysis | None]:
        """Analyse the frames, and count those that cannot be used as missing; None if that leaves none."""
        try:
            analysis = await self._vision.see(self.step, taken)
        except UnusableFramesError as error:
            return self._without(taken, error.reasons), None
        return self._without(taken, analysis.skipped), analysis

    def _without(self, taken: Sample, reasons: Mapping[int, str]) -> Sample:
        """Leave out the frames of some vehicles, and say why."""
        for vehicle_id, reason in reasons.items():
            self._context.journal.notice(
                Severity.WARNING, f"step {self.step} goes on without its frame: {reason}", vehicle_id
            )
        captures = tuple(capture for capture in taken.captures if capture.vehicle_id not in reasons)
        return Sample(captures, taken.missing | dict(reasons))

    def _unsteady(self, swarm: list[Member]) -> dict[int, str]:
        """Return who does not hover, or does not say so, with the reason by id."""
        return {member.vehicle_id: text for member in swarm if (text := self._why_unsteady(member))}

    def _why_unsteady(self, member: Member) -> str | None:
        limits, age_s = self._context.flight.limits, self._context.roster.position_age_s(member)
        if age_s is None or (limits is not None and age_s > limits.max_position_age_s):
            return "no position yet" if age_s is None else f"its last position is {age_s:.1f} s old"
        velocity_enu_mps = member.state.velocity_enu_mps
        speed_mps = 0.0 if velocity_enu_mps is None else float(np.linalg.norm(velocity_enu_mps))
        if speed_mps > 2 * self._context.settings.flight.arrival_speed_mps:
            return f"still moving at {speed_mps:.1f} m/s"
        return None

    def _count_blind_step(self, phase: Phase, taken: Sample) -> Phase:
        self._blind_steps += 1
        if self._blind_steps >= _MAX_BLIND_STEPS:
            reasons = "; ".join(f"vehicle {vehicle_id}: {reason}" for vehicle_id, reason in taken.missing.items())
            raise MissionFailedError(f"No camera delivered a usable frame in {self._blind_steps} steps ({reasons}).")
        return phase

    def _decide(
        self, phase: Phase, swarm: list[Member], taken: Sample, analysis: StepAnalysis
    ) -> tuple[Phase, StepRecord]:
        """Return the next phase and the step's record with its vetted waypoints."""
        context = self._context
        in_view = self.tracker.observe(analysis, context.journal.elapsed_s())
        if self.tracker.target_walks:
            self._vision.forget()
        following = self._next_phase(phase, swarm, in_view)
        diagnostics, waypoints = self._choose(following, swarm, analysis, in_view)
        return following, StepRecord(
            step=self.step,
            elapsed_s=context.journal.elapsed_s(),
            phase=phase,
            visibility_m2=analysis.visibility_m2,
            visibility_present_m2=analysis.present_m2,
            threshold_m2=context.settings.detection.threshold_m2,
            branch=diagnostics.branch,
            evolutionary_factor=diagnostics.evolutionary_factor,
            evolutionary_state=diagnostics.evolutionary_state,
            c_s_m=diagnostics.c_s_m,
            c_c_m=diagnostics.c_c_m,
            leader_id=analysis.leader_id,
            target_enu_m=self.tracker.measured_enu_m,
            fitness=dict(zip(analysis.vehicle_ids, map(float, analysis.fitness), strict=True)),
            missing=taken.missing,
            waypoints=waypoints,
            imaging_ms=0.0,
            work_ms=0.0,
            loop_lag_p99_ms=0.0,
        )

    def _choose(
        self, following: Phase, swarm: list[Member], analysis: StepAnalysis, in_view: bool
    ) -> tuple[Diagnostics, tuple[WaypointRecord, ...]]:
        """Ask the strategy where to go next, and safety what may be sent; a found target is watched from here."""
        if following not in {Phase.SCAN, Phase.CONVERGE}:
            return Diagnostics(branch="hold", leader_id=analysis.leader_id), ()
        estimate = self.tracker.estimate() if in_view else None
        observation = make_observation(
            [member.vehicle_id for member in swarm],
            self._positions_enu_m(swarm),
            analysis,
            None if estimate is None else np.array(estimate.position_enu_m[:2]),
        )
        self._state = self._strategy.tell(self._state, observation)
        next_enu_m, self._state = self._strategy.ask(self._state, self._rng)
        requests = self._in_layers(swarm, next_enu_m)
        waypoints = self._context.flight.vet(requests)
        self._barred = tuple(waypoint for waypoint in waypoints if waypoint.verdict is not WaypointVerdict.SENT)
        return self._strategy.diagnostics(self._state), waypoints

    def _next_phase(self, phase: Phase, swarm: list[Member], in_view: bool) -> Phase:
        settings, context = self._context.settings, self._context
        tracker = self.tracker
        if phase is Phase.FOUND:
            self._steps_found += 1
            if tracker.steps_out_of_view >= settings.detection.lost_steps:
                context.journal.notice(Severity.WARNING, "the target is out of view")
                return Phase.CONVERGE
            return Phase.RETURN if settings.auto_return and self._steps_found > settings.detection.hold_steps else phase
        if context.journal.elapsed_s() > settings.deadlines.search_s:
            context.journal.notice(Severity.WARNING, "the time for the search is over")
            return Phase.RETURN
        if in_view:
            return self._found() if tracker.is_found() and phase is Phase.CONVERGE else Phase.CONVERGE
        if phase is Phase.CONVERGE:
            context.journal.notice(Severity.INFO, "the target is out of view; searching where it was last seen")
            return Phase.SCAN
        return self._continue_scan(swarm)

    def _found(self) -> Phase:
        context, estimate = self._context, self.tracker.estimate()
        if estimate is not None:
            east_m, north_m, _ = estimate.position_enu_m
            context.journal.notice(
                Severity.NEWS,
                f"target found at {east_m:.1f} m east, {north_m:.1f} m north, give or take {estimate.sigma_m:.1f} m"
                + _person_text(estimate.person_confidence),
            )
        context.outcome = Outcome.FOUND
        self._steps_found = 0
        if self.found_at_s is None:
            self.found_at_s = context.journal.elapsed_s()
        return Phase.FOUND

    def _continue_scan(self, swarm: list[Member]) -> Phase:
        """Follow the leg; after a chase that led nowhere go back to it; at its end take the next one, or return."""
        detection, leg = self._context.settings.detection, self.legs[self.leg]
        if self.tracker.estimate() is not None:
            if self.tracker.steps_out_of_view < detection.reacquire_steps:
                return Phase.SCAN
            self.tracker.give_up()
            self._vision.forget()
            return Phase.LINE
        offset_m = self._horizontal_enu_m(swarm).mean(axis=0) - np.array(leg.start_enu_m)
        along_m = float(offset_m @ np.array(leg.direction_enu))
        self._progress_m = max(self._progress_m, along_m)
        if self._progress_m >= leg.length_m:
            return self._next_leg()
        is_stuck = self._stalls.is_stuck(along_m, barred=bool(self._barred))
        return self._go_on_behind(swarm) if is_stuck else Phase.SCAN

    def _go_on_behind(self, swarm: list[Member]) -> Phase:
        """Leave out the stretch of the leg in front of which the scan is stuck, and say so."""
        context, leg, reason = self._context, self.legs[self.leg], self._barred[0]
        left = leg.after(self._progress_m)
        ahead_m = place_ahead_m(
            left, len(swarm), self._strategy.spacing_m, lambda places_m: context.flight.reached(swarm, places_m)
        )
        left_out_m = left.length_m if ahead_m is None else ahead_m
        context.journal.notice(
            Severity.WARNING,
            f"leg {self.leg + 1} is barred after {self._progress_m:.0f} of {leg.length_m:.0f} m "
            f"(vehicle {reason.vehicle_id}: {reason.reason}); the scan leaves out "
            + ("the rest of it" if ahead_m is None else f"{left_out_m:.0f} m and goes on behind"),
        )
        self._left_out_m += left_out_m
        self._progress_m += left_out_m
        return self._next_leg() if ahead_m is None else Phase.LINE

    def _next_leg(self) -> Phase:
        self.leg, self._progress_m = self.leg + 1, 0.0
        if self.leg < len(self.legs):
            return Phase.LINE
        journal = self._context.journal
        if self._left_out_m == 0.0:
            journal.notice(Severity.NEWS, "the whole area has been scanned, nothing was found")
        else:
            text = f"the scan is over, nothing was found; {self._left_out_m:.0f} m of its legs were left out"
            seen = self.covered_fraction or 0.0
            journal.notice(Severity.NEWS, f"{text}, {100 * seen:.0f} % of the area has been in a frame")
        return Phase.RETURN

    async def _act(self, record: StepRecord, received_at_s: float) -> float:
        """Record the decision, then send it; return the milliseconds from the last frame to the last goto on the link.

        Recorded before it is acted on: what the vehicles were told is on disk even if we die while telling them.
        """
        context = self._context
        async with context.journal.patience(f"step {self.step}"):
            await context.recorder.record_step(record, self._strategy_state())
            await context.recorder.flush()
        handed_over_ms = [_ms_since(received_at_s)]
        await context.flight.send(record.waypoints, lambda: handed_over_ms.append(_ms_since(received_at_s)))
        return handed_over_ms[-1]

    async def _publish(self, record: StepRecord) -> None:
        async with self._context.journal.patience(f"step {self.step}"):
            await self._context.recorder.record_step(record, self._strategy_state())
        self._context.journal.step(record)

    async def _survey(self, taken: Sample, analysis: StepAnalysis) -> None:
        """Note what the frames show of the area, and show it."""
        context, plane_m = self._context, analysis.grid.height_m
        frame = context.roster.local_frame()
        frames = [to_frame(capture, frame) for capture in taken.captures]
        footprints = [footprint_enu_m(one, plane_m) for one in frames]
        context.cameras.note(self.step, frames, footprints, taken.missing)
        if self._coverage is None:
            forest = context.settings.forest
            self._coverage = CoverageMap(context.settings.area_enu_m, None if forest is None else forest.occlusion)
        await asyncio.to_thread(self._coverage.add, footprints)
        await self._gallery.show(self.step, await asyncio.to_thread(self._coverage.render))

    async def _await_arrival(self, waypoints: tuple[WaypointRecord, ...]) -> None:
        sent_ids = {record.vehicle_id for record in waypoints if record.sent_enu_m is not None}
        context = self._context

        def travelling() -> list[Member]:
            return [member for member in context.roster.members(Task.SWARM) if member.vehicle_id in sent_ids]

        late = await context.flight.wait_until(
            travelling, context.flight.has_arrived, context.settings.deadlines.move_s
        )
        for member in late:
            context.journal.notice(Severity.WARNING, "has not reached its waypoint in time", member.vehicle_id)

    # --- shared -------------------------------------------------------------------------------------------------------

    def _strategy_state(self) -> dict[str, object]:
        return {"strategy": self._state, "generator": dump_rng(self._rng)}

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
            context.message = f"Waiting for {len(lost)} lost vehicles."
            await context.clock.sleep(_POLL_S)
        return swarm

    def _horizontal_enu_m(self, members: list[Member]) -> NDArray[np.float64]:
        return self._positions_enu_m(members)[:, :2]

    def _positions_enu_m(self, members: list[Member]) -> NDArray[np.float64]:
        positions = [self._context.roster.position_enu_m(member) for member in members]
        return np.array([position for position in positions if position is not None])

    @staticmethod
    def _in_layers(members: list[Member], horizontal_enu_m: NDArray[np.float64]) -> dict[int, NDArray[np.float64]]:
        return {
            member.vehicle_id: np.array([*place_enu_m, member.layer_height_m])
            for member, place_enu_m in zip(members, horizontal_enu_m, strict=True)
        }


def _ms_since(start_s: float) -> float:
    return 1e3 * (time.perf_counter() - start_s)


def _person_text(confidence: float | None) -> str:
    if confidence is None:
        return ""
    if confidence < DECISION:
        return f"; it does not look like a person ({100 * confidence:.0f} %)"
    return f"; it looks like a person ({100 * confidence:.0f} %)"
