"""The decision after each step: which phase follows, and where the vehicles fly next."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.imaging.model import StepAnalysis
from aos_gcs.imaging.persons.classifier import DECISION
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.roster import Member, in_layers
from aos_gcs.mission.model.findings import TargetEstimate
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.search.observing import make_observation
from aos_gcs.mission.search.progress import Advance, ScanProgress
from aos_gcs.mission.search.stalls import place_ahead_m
from aos_gcs.mission.search.survey import Survey
from aos_gcs.mission.search.targeting import TargetTracker
from aos_gcs.mission.search.vision import Vision
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.ports import Severity
from aos_gcs.swarm.model import Diagnostics, Strategy
from aos_gcs.swarm.registry import make_strategy
from aos_gcs.swarm.state import dump_rng


@dataclass(frozen=True, slots=True)
class Decision:
    """Decision of a step."""

    following: Phase
    diagnostics: Diagnostics
    waypoints: tuple[WaypointRecord, ...]
    """Vetted, not sent yet."""


class Decider:
    """Tracks targets, advances the scan, and asks the strategy for waypoints. ``decide`` once per step."""

    def __init__(self, context: FlightContext, vision: Vision, survey: Survey) -> None:
        settings = context.settings
        self._context = context
        self._vision = vision
        self._survey = survey
        self._rng = np.random.default_rng(settings.seed)
        self._strategy: Strategy[Any] = make_strategy(settings.strategy, settings.strategy_parameters)
        self._state = self._strategy.init(np.array(settings.scan_direction_enu))
        self._steps_found = 0
        self.tracker = TargetTracker(settings)
        self.progress = ScanProgress(settings.flight.arrival_radius_m)
        self.found_at_s: float | None = None
        """Mission time of the first decision that a target is found; None before it."""

    @property
    def spacing_m(self) -> float:
        """Distance of the vehicles in the strategy's line."""
        return self._strategy.spacing_m

    def strategy_state(self) -> dict[str, object]:
        """Return what a replay needs to reach the next decision again."""
        return {"strategy": self._state, "generator": dump_rng(self._rng)}

    def begin_line(self, leg: ScanLeg) -> None:
        """Start the strategy afresh from a line formed on a leg."""
        self._state = self._strategy.init(np.array(leg.direction_enu))
        self.progress.form_line()

    def decide(self, phase: Phase, swarm: list[Member], analysis: StepAnalysis) -> Decision:
        """Decide what follows from a step's analysis."""
        in_view = self.tracker.observe(analysis, self._context.journal.elapsed_s())
        if self.tracker.target_walks:
            self._vision.forget()
        following = self._next_phase(phase, swarm, in_view=in_view)
        diagnostics, waypoints = self._choose_waypoints(following, swarm, analysis, in_view=in_view)
        return Decision(following, diagnostics, waypoints)

    def _choose_waypoints(
        self, following: Phase, swarm: list[Member], analysis: StepAnalysis, *, in_view: bool
    ) -> tuple[Diagnostics, tuple[WaypointRecord, ...]]:
        """Ask the strategy for waypoints and vet them; while a found target is observed, the vehicles hover."""
        if following not in {Phase.SCAN, Phase.CONVERGE}:
            return Diagnostics(branch="hold", leader_id=analysis.leader_id), ()
        estimate = self.tracker.estimate() if in_view else None
        observation = make_observation(
            [member.vehicle_id for member in swarm],
            self._context.roster.positions_enu_m(swarm),
            analysis,
            None if estimate is None else np.array(estimate.position_enu_m[:2]),
        )
        self._state = self._strategy.tell(self._state, observation)
        next_enu_m, self._state = self._strategy.ask(self._state, self._rng)
        waypoints = self._context.flight.vet(in_layers(swarm, next_enu_m))
        self.progress.note_waypoints(waypoints)
        return self._strategy.diagnostics(self._state), waypoints

    def _next_phase(self, phase: Phase, swarm: list[Member], *, in_view: bool) -> Phase:
        settings, journal, tracker = self._context.settings, self._context.journal, self.tracker
        if phase is Phase.FOUND:
            self._steps_found += 1
            if tracker.steps_out_of_view >= settings.detection.lost_steps:
                journal.notice(Severity.WARNING, "The target is out of view")
                return Phase.CONVERGE
            return Phase.RETURN if settings.auto_return and self._steps_found > settings.detection.hold_steps else phase
        if journal.elapsed_s() > settings.deadlines.search_s:
            journal.notice(Severity.WARNING, "Maximum search time reached: all vehicles return")
            return Phase.RETURN
        if in_view:
            return self._report_found() if tracker.is_found() and phase is Phase.CONVERGE else Phase.CONVERGE
        if phase is Phase.CONVERGE:
            journal.notice(Severity.INFO, "The target is out of view: searching where it was last seen")
            return Phase.SCAN
        return self._continue_scan(swarm)

    def _report_found(self) -> Phase:
        journal, estimate = self._context.journal, self.tracker.estimate()
        if estimate is not None:
            journal.notice(Severity.NEWS, describe_found(estimate))
        self._steps_found = 0
        if self.found_at_s is None:
            self.found_at_s = journal.elapsed_s()
        return Phase.FOUND

    def _continue_scan(self, swarm: list[Member]) -> Phase:
        """Follow the leg; return to it after a target was lost; after its end take the next one, or fly home."""
        if self.tracker.estimate() is not None:
            if self.tracker.steps_out_of_view < self._context.settings.detection.reacquire_steps:
                return Phase.SCAN
            self.tracker.give_up()
            self._vision.forget()
            return Phase.LINE
        middle_m = self._context.roster.positions_enu_m(swarm)[:, :2].mean(axis=0)
        advance = self.progress.advance(middle_m)
        if advance is Advance.END_OF_LEG:
            return self._begin_next_leg()
        return self._leave_out(swarm) if advance is Advance.STUCK else Phase.SCAN

    def _leave_out(self, swarm: list[Member]) -> Phase:
        """Leave out the stretch of the leg in front of which the scan is stuck, and report it."""
        context, progress = self._context, self.progress
        barred, remaining = progress.barred[0], progress.remaining_leg
        ahead_m = place_ahead_m(
            remaining, len(swarm), self.spacing_m, lambda places_m: context.flight.reached(swarm, places_m)
        )
        length_m = remaining.length_m if ahead_m is None else ahead_m
        context.journal.notice(
            Severity.WARNING,
            f"Leg {progress.leg + 1} is blocked after {progress.along_m:.0f} of {progress.present_leg.length_m:.0f} m "
            f"(vehicle {barred.vehicle_id}: {barred.reason}). The scan leaves out "
            + ("the rest of it" if ahead_m is None else f"{length_m:.0f} m and continues behind"),
        )
        progress.leave_out(length_m)
        return self._begin_next_leg() if ahead_m is None else Phase.LINE

    def _begin_next_leg(self) -> Phase:
        if self.progress.begin_next_leg():
            return Phase.LINE
        journal, left_out_m = self._context.journal, self.progress.left_out_m
        if left_out_m == 0.0:
            journal.notice(Severity.NEWS, "Scan complete: the whole area was scanned, nothing was found")
        else:
            text = f"Scan complete, nothing was found. {left_out_m:.0f} m of its legs were left out"
            covered = self._survey.covered_fraction or 0.0
            journal.notice(Severity.NEWS, f"{text}; {100 * covered:.0f} % of the area was in a frame")
        return Phase.RETURN


def describe_found(target: TargetEstimate) -> str:
    """Return what was found, where, and how sure that is."""
    confidence, (east_m, north_m, _) = target.person_confidence, target.position_enu_m
    if confidence is None:
        what = "Target found"
    else:
        what = f"{'Possible person' if confidence >= DECISION else 'Unlikely a person'} ({100 * confidence:.0f} %)"
    precision = "" if target.sigma_m is None else f", ± {target.sigma_m:.1f} m"
    return f"{what} at {east_m:.1f} m east, {north_m:.1f} m north{precision}"
