"""The decision after each step: which phase follows, and where the vehicles fly next."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.detours import Detours
from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.plans import reached, vet_plan
from aos_gcs.airspace.reference_surface import LEVEL, ReferenceSurface
from aos_gcs.airspace.terrain import GroundRaster
from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.imaging.model import StepAnalysis
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.mission.fleet.layers import in_layers
from aos_gcs.mission.journal import Announcer
from aos_gcs.mission.model.decisions import Decision, Group, LeftPlace, Situation
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.search.decisions.look_choice import LookChoice
from aos_gcs.mission.search.decisions.observing import make_observation
from aos_gcs.mission.search.decisions.split import Split, begin_split, places_of_both
from aos_gcs.mission.search.frames.ground_in_view import ground_in_view
from aos_gcs.mission.search.scan.notices import tell_blocked, tell_end, tell_gap
from aos_gcs.mission.search.scan.progress import Advance, ScanProgress
from aos_gcs.mission.search.scan.stalls import place_ahead_m
from aos_gcs.mission.search.scan.sweep import Sweep, Vet
from aos_gcs.mission.search.targets.claims import Claims
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.mission.search.targets.persons import Judgement
from aos_gcs.mission.search.targets.tracker import TargetTracker
from aos_gcs.planning.legs import ScanLeg, line_on
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Severity
from aos_gcs.swarm.model import Diagnostics, Strategy
from aos_gcs.swarm.registry import strategy_for
from aos_gcs.swarm.state import dump_rng


class Decider:
    """Tracks targets, advances the scan, and asks the strategy for waypoints.

    ``decide`` once per step, and ``conclude`` when its frames have been judged. Decisions depend on the arguments, the
    findings and the decisions before alone, so that a record leads to them again.

    Args:
        settings: settings of the mission.
        journal: told what is announced.
        findings: findings of the mission.
        left_for_later: places that were left for a later look before.
        forget: discards the views of earlier steps.
        covered_fraction: returns the share of the area that was in a frame, for a notice.
    """

    def __init__(
        self,
        settings: MissionSettings,
        journal: Announcer,
        findings: Findings,
        *,
        left_for_later: Sequence[LeftPlace] = (),
        forget: Callable[[], None],
        covered_fraction: Callable[[], float | None],
    ) -> None:
        self._settings = settings
        self._journal = journal
        self._forget = forget
        self._covered_fraction = covered_fraction
        self._rng = np.random.default_rng(settings.seed)
        self._strategy: Strategy[Any] = strategy_for(settings.vehicles, settings.strategy, settings.strategy_parameters)
        self._state = self._strategy.init(np.array(settings.scan_direction_enu))
        self._steps_found = 0
        self._swarm_size = settings.vehicles
        self._heading_rad = 0.0
        """Heading that the vehicles have been told last, north or south."""
        self._findings = findings
        self.tracker = TargetTracker(settings)
        self._claims = Claims(settings.detection, journal, self.tracker, findings)
        self.progress = ScanProgress(settings.flight.arrival_radius_m)
        self.choice = LookChoice(settings, journal, self.progress, left_for_later)
        self._limits: SafetyLimits | None = None
        """Limits of the latest decision; None before the first one."""
        self._sweep = Sweep(settings.flight, settings.imaging.rate_hz, self.line_spacing_m, journal)
        self.split: Split | None = None
        """Present split of the swarm; None while all vehicles do the same."""

    @property
    def found_at_s(self) -> float | None:
        """Mission time at which the first possible person was announced; None before it."""
        return self._claims.first_at_s

    @property
    def settled_enu_m(self) -> tuple[tuple[float, float], ...]:
        """Places that have been looked at, are left for later, or judged by operators: nobody converges on them."""
        return (*self._claims.settled_enu_m, *self.choice.later_enu_m)

    @property
    def threshold_m2(self) -> float:
        """Visibility from which a target is in view."""
        return self._settings.detection.threshold_m2

    @property
    def spacing_m(self) -> float:
        """Distance of the vehicles in the strategy's line."""
        return self._strategy.spacing_m

    @property
    def line_spacing_m(self) -> float:
        """Distance of the vehicles in the line along the legs."""
        on_legs_m = None if self.choice.is_look_leg else self._settings.search.line_spacing_m
        return on_legs_m or self.spacing_m

    def strategy_state(self) -> dict[str, object]:
        """Return what a replay needs to reach the next decision again."""
        return {"strategy": self._state, "generator": dump_rng(self._rng)}

    def begin_line(self, leg: ScanLeg) -> None:
        """Start the strategy afresh from a line formed on a leg."""
        self._state = self._strategy.init(np.array(leg.direction_enu))
        self.progress.form_line()
        self._sweep.end()
        self.split = None

    def decide(
        self,
        phase: Phase,
        situation: Situation,
        detours: Detours,
        analysis: StepAnalysis,
        ground: GroundRaster | None = None,
        *,
        surface: ReferenceSurface = LEVEL,
        may_sweep: bool = False,
        group: Group | None = None,
    ) -> Decision:
        """Decide what follows from a step's analysis.

        Those who scan on while others look are sent on, or to stop: then there are no waypoints.

        Args:
            phase: phase in which the step was made.
            situation: state of the flight.
            detours: those of the situation's traffic.
            analysis: analysis of the step's frames.
            ground: ground that the limits of the situation's traffic refer to.
            surface: surface that the altitude layers are offset from.
            may_sweep: whether the swarm may fly along the leg without stops while nothing is in view.
            group: group whose step it is; None: the whole swarm, where a split ends.
        """

        def vet(places_enu_m: NDArray[np.float64]) -> tuple[WaypointRecord, ...]:
            planned_enu_m = in_layers(situation.swarm, places_enu_m, surface)
            return vet_plan(planned_enu_m, situation.traffic, detours, ground, surface)

        self._limits = situation.traffic.limits
        if group is Group.SCAN:
            return self._scan_on(situation, analysis, vet)
        if group is None:
            self._end_split()
            self._swarm_size = len(situation.swarm)
        terrain = ground_in_view(self._settings, ground, analysis.grid)
        may_sweep = may_sweep and not self.choice.is_look_leg
        in_view = self._observe(analysis, situation, terrain, may_leave=may_sweep and phase is Phase.SCAN)
        if self.tracker.target_walks:
            self._forget()
        if in_view or phase is not Phase.SCAN:
            self._sweep.end()
        following = self._next_phase(phase, situation, detours, analysis.vehicle_ids, in_view=in_view)
        if may_sweep and following is Phase.CONVERGE:
            self._begin_split(situation, analysis)
        if self.split is not None:
            self.split.note_look(analysis, self.tracker.looked_at_enu_m, self.settled_enu_m)
        if following is Phase.SCAN and may_sweep and self.tracker.estimate() is None:
            progress = self.progress
            if swept := self._sweep.fly_on(progress.present_leg, progress.along_m, situation, vet):
                progress.note_waypoints(())
                return Decision(following, Diagnostics("sweep", leader_id=analysis.leader_id), swept, is_sweep=True)
        self._sweep.end()
        if following not in {Phase.SCAN, Phase.CONVERGE}:
            return Decision(following, Diagnostics(branch="hold", leader_id=analysis.leader_id), ())
        looking = situation if self.split is None else self.split.looking(situation)
        diagnostics, next_enu_m = self._choose_places(looking, analysis, in_view=in_view)
        if self.split is not None and len(looking.swarm) < len(situation.swarm):
            next_enu_m = places_of_both(self.split, self.progress, situation, next_enu_m)
        if following is Phase.SCAN and self.tracker.estimate() is None and self.line_spacing_m != self.spacing_m:
            # The strategy's own line is that of a close look.
            next_enu_m = line_on(self.progress.present_leg, next_enu_m, self.line_spacing_m)
        waypoints = vet(next_enu_m)
        self.progress.note_waypoints(waypoints)
        if self._settings.flight.reverse_heading and self.tracker.sees_targets:
            self._heading_rad = math.pi - self._heading_rad
            waypoints = tuple(replace(one, heading_rad=self._heading_rad) for one in waypoints)
        return Decision(following, diagnostics, waypoints)

    def conclude(self, following: Phase, judgements: Mapping[int, Judgement]) -> Phase:
        """Decide what the targets are, once a step's frames have been judged, and return the phase that follows.

        Args:
            following: phase that follows unless a decision changes it.
            judgements: what the tracks are taken for, by their ids.
        """
        self.tracker.judge(judgements)
        found = self._claims.announce(self.choice.later_enu_m, in_flight=self._sweep.is_under_way)
        is_free = found is None and following in {Phase.SCAN, Phase.LINE}
        worth_it = self.choice.review(self.tracker, self._claims.looked_at_enu_m, self._swarm_size, is_free=is_free)
        if following is Phase.FOUND and self._claims.is_rejected():
            return self._go_on()
        if following not in {Phase.SCAN, Phase.CONVERGE, Phase.LINE}:
            return following
        if worth_it is not None:
            self.tracker.attend(worth_it)
            return Phase.CONVERGE
        if found is not None:
            self.tracker.attend(found)
            self._steps_found = 0
            if self.split is not None:
                self.split.look_on(is_last=self._settings.detection.stop_at_first)
                self.progress.take_back(self.split.leg)
            return Phase.FOUND
        if following is Phase.CONVERGE and self._claims.is_look_over():
            return self._go_on()
        return following

    def goes_on_to_looks(self) -> bool:
        """Leave the other legs out where something was left for later; return whether that is looked at now."""
        if (leg := self.choice.next_leg(self._claims.looked_at_enu_m, self._limits)) is None:
            return False
        self.progress.leave_for(leg)
        return True

    def tell_end(self) -> None:
        """Tell operators, when the search has ended, what was scanned and found, and what was not looked at."""
        self._claims.announce_at_last()
        if self.progress.is_over:
            tell_end(self._journal, len(self._findings.persons()), self.progress.left_out_m, self._covered_fraction())
        self.choice.tell_left(self._claims.looked_at_enu_m, self._limits)

    def _observe(
        self, analysis: StepAnalysis, situation: Situation, terrain: Terrain | None, *, may_leave: bool
    ) -> bool:
        """Update the tracks, and return whether a target leads the swarm: it may be left for later."""
        in_view = self.tracker.observe(analysis, situation.now_s, terrain)
        self._claims.follow()
        target, vehicles = self.tracker.estimate(), len(situation.swarm)
        if not (in_view and may_leave and target is not None):
            return in_view
        if not self.choice.leaves(target.position_enu_m[:2], self.tracker.verdict(target.track_id), vehicles):
            return True
        self.tracker.give_up()
        return False

    def _begin_split(self, situation: Situation, analysis: StepAnalysis) -> None:
        """Have some vehicles look at what is in view and the others scan on, where there are enough of them."""
        target = self.tracker.estimate()
        self.split = begin_split(
            self._settings,
            situation,
            None if target is None else target.position_enu_m,
            analysis.leader_id,
            line_m=self.line_spacing_m,
            progress=self.progress,
            journal=self._journal,
        )

    def _scan_on(self, situation: Situation, analysis: StepAnalysis, vet: Vet) -> Decision:
        """Decide where those fly who scan while others look; behind a look that is over, their leg's end is the end."""
        following, waypoints = Phase.SCAN, tuple[WaypointRecord, ...]()
        if (split := self.split) is not None:
            waypoints = split.scan_on(self.progress, situation, analysis, vet)
            if split.is_catching_up and split.is_at_end:
                following = self._end_leg(split)
        return Decision(following, Diagnostics("sweep"), waypoints, is_sweep=bool(waypoints))

    def _end_leg(self, split: Split) -> Phase:
        """Begin the leg behind that of a split, once: a step that an operator has interrupted is made again."""
        if self.progress.leg == split.leg:
            return self._begin_next_leg()
        return Phase.RETURN if self.progress.is_over else Phase.LINE

    def _end_split(self) -> None:
        """Have all vehicles do the same again; what those who scanned have flown over is flown again."""
        if self.split is not None:
            self.progress.take_back(self.split.leg)
            self.progress.go_back(self.split.began_m)
            self.split = None

    def _choose_places(
        self, situation: Situation, analysis: StepAnalysis, *, in_view: bool
    ) -> tuple[Diagnostics, NDArray[np.float64]]:
        """Ask the strategy for the vehicles' next places, shape (n, 2)."""
        estimate = self.tracker.estimate() if in_view else None
        observation = make_observation(
            [one.vehicle_id for one in situation.swarm],
            situation.positions_enu_m,
            analysis,
            None if estimate is None else np.array(estimate.position_enu_m[:2]),
            situation.now_s,
        )
        self._state = self._strategy.tell(self._state, observation)
        next_enu_m, self._state = self._strategy.ask(self._state, self._rng)
        return self._strategy.diagnostics(self._state), next_enu_m

    def _next_phase(
        self, phase: Phase, situation: Situation, detours: Detours, framed_ids: Sequence[int], *, in_view: bool
    ) -> Phase:
        if phase is Phase.FOUND:
            return self._watch()
        if situation.now_s > self._settings.deadlines.search_s:
            self._claims.conclude_cut_short()
            self._journal.notice(Severity.WARNING, "Maximum search time reached: all vehicles return")
            return Phase.RETURN
        if in_view:
            return Phase.CONVERGE
        if phase is Phase.CONVERGE:
            self._journal.notice(Severity.INFO, "The target is out of view: searching where it was last seen")
            return Phase.SCAN
        return self._continue_scan(situation, detours, framed_ids)

    def _watch(self) -> Phase:
        """Watch a person that was announced for some steps; then go on, or stay or return where the search ends.

        What has come into view beside the person had glances only: if it may be another one, it gets a look of its own.
        """
        settings, tracker = self._settings, self.tracker
        self._steps_found += 1
        stops = settings.detection.stop_at_first
        if tracker.steps_out_of_view >= settings.detection.lost_steps:
            self._journal.notice(Severity.WARNING, "The target is out of view")
        elif self._steps_found <= settings.detection.hold_steps:
            return Phase.FOUND
        elif stops:
            return Phase.RETURN if settings.auto_return else Phase.FOUND
        return Phase.CONVERGE if stops or self._claims.may_be_another_person() else self._go_on()

    def _go_on(self) -> Phase:
        """Leave the target for good, and take up the scan where it was left."""
        self._claims.settle_target()
        self.tracker.give_up()
        self._forget()
        return self._return_to_leg(is_settled=True)

    def _return_to_leg(self, *, is_settled: bool) -> Phase:
        """Take up the leg where it was left, or where others have got to, where it is known what was seen."""
        if (split := self.split) is None:
            return Phase.LINE
        if not is_settled or split.leaves_something(self.settled_enu_m):
            split.end_behind()
            self.progress.take_back(split.leg)
            self.progress.go_back(split.began_m)
            return Phase.LINE
        split.end_look()
        return self._end_leg(split) if split.is_at_end else Phase.LINE

    def _continue_scan(self, situation: Situation, detours: Detours, framed_ids: Sequence[int]) -> Phase:
        """Follow the leg; return to it after a target was lost; after its end take the next one, or fly home."""
        if self.tracker.estimate() is not None:
            is_worth_it = self._claims.is_worth_a_search()
            if is_worth_it and self.tracker.steps_out_of_view < self._settings.detection.reacquire_steps:
                return Phase.SCAN
            self._claims.conclude_cut_short()
            self.tracker.give_up()
            self._forget()
            return self._return_to_leg(is_settled=not is_worth_it)
        progress = self.progress
        if self._sweep.is_under_way:
            along_m = self._sweep.exposed_at_m(progress.present_leg, situation, framed_ids)
            advance = progress.advance_in_flight(along_m, self._sweep.longest_gap_m)
            if advance is Advance.GAP:
                tell_gap(self._journal, progress, along_m)
                return Phase.LINE
        else:
            advance = progress.advance(situation.positions_enu_m[:, :2].mean(axis=0))
        if advance is Advance.END_OF_LEG:
            return self._begin_next_leg()
        return self._leave_out(situation, detours) if advance is Advance.STUCK else Phase.SCAN

    def _leave_out(self, situation: Situation, detours: Detours) -> Phase:
        """Leave out the stretch of the leg in front of which the scan is stuck, and report it."""
        progress, positions_enu_m = self.progress, list(situation.positions_enu_m)
        remaining = progress.remaining_leg
        ahead_m = place_ahead_m(
            remaining,
            len(situation.swarm),
            self.line_spacing_m,
            lambda places_m: reached(positions_enu_m, places_m, detours),
        )
        length_m = remaining.length_m if ahead_m is None else ahead_m
        tell_blocked(self._journal, progress, ahead_m, length_m)
        progress.leave_out(length_m)
        return self._begin_next_leg() if ahead_m is None else Phase.LINE

    def _begin_next_leg(self) -> Phase:
        return Phase.LINE if self.progress.begin_next_leg() or self.goes_on_to_looks() else Phase.RETURN
