"""Records of steps and decisions: what was seen and decided, and what that depended on besides the frames."""

from __future__ import annotations

from collections.abc import Mapping

from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.model import StepAnalysis
from aos_gcs.mission.model.decisions import ConclusionRecord, Decision, DecisionRecord, FormedLine, Group, Situation
from aos_gcs.mission.model.findings import Finding, TargetEstimate
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.mission.search.decisions.decider import Decider
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.planning.legs import ScanLeg


class DecisionLog:
    """Gathers what each decision of a search depends on: ``begin_analysis``, ``decided``, ``concluded`` in turn.

    What operators changed is taken from the findings at these times, and kept until a decision or a conclusion has it.

    Args:
        decider: makes the decisions.
        findings: findings of the mission.
    """

    def __init__(self, decider: Decider, findings: Findings) -> None:
        self._decider = decider
        self._findings = findings
        self._decisions = 0
        self._conclusions = 0
        self._line: FormedLine | None = None
        self._edits_before_analysis: list[Finding] = []
        self._settled_enu_m: tuple[tuple[float, float], ...] = ()

    def note_line(self, formed: ScanLeg) -> None:
        """Note that a line was formed on the rest of the present leg."""
        progress = self._decider.progress
        self._line = FormedLine(progress.legs, progress.leg, formed)

    def begin_analysis(self, group: Group | None = None) -> tuple[tuple[float, float], ...]:
        """Return the places that lead no vehicle any more, with which the frames of a group are to be analysed."""
        if group is Group.SCAN and self._decider.split is not None:
            # What operators change concerns the look.
            self._settled_enu_m = self._decider.split.passed_enu_m
            return self._settled_enu_m
        self._edits_before_analysis += self._findings.take_edits()
        self._settled_enu_m = self._decider.settled_enu_m
        return self._settled_enu_m

    def take_edits(self) -> tuple[Finding, ...]:
        """Return what operators have changed since the last call: to be called before each decision and conclusion."""
        return self._findings.take_edits()

    def decision(
        self,
        step: int,
        phase: Phase,
        situation: Situation,
        analysis: StepAnalysis,
        decision: Decision,
        *,
        poses: Mapping[int, Pose],
        edits: tuple[Finding, ...],
        may_sweep: bool,
        speeds_mps: Mapping[int, float],
        group: Group | None,
    ) -> DecisionRecord:
        """Return the record of a step's decision, once it is made."""
        record = DecisionRecord(
            step=step,
            phase=phase,
            decided=self._decisions,
            concluded=self._conclusions,
            focal_height_m=analysis.grid.height_m,
            settled_enu_m=self._settled_enu_m,
            situation=situation,
            following=decision.following,
            marks=analysis.mark_digests,
            line=self._line,
            poses=poses,
            edits_before_analysis=() if group is Group.SCAN else tuple(self._edits_before_analysis),
            edits=edits,
            may_sweep=may_sweep,
            speeds_mps=speeds_mps,
            group=group,
        )
        self._decisions += 1
        self._line = None
        if group is not Group.SCAN:
            self._edits_before_analysis = []
        return record

    def conclusion(
        self,
        step: int,
        now_s: float,
        following: Phase,
        targets: tuple[TargetEstimate, ...],
        *,
        judged: bool,
        edits: tuple[Finding, ...],
    ) -> ConclusionRecord:
        """Return the record of a step's conclusion, once it is made."""
        self._conclusions += 1
        return ConclusionRecord(step, now_s, judged, following, targets, edits)


def step_record(
    step: int,
    phase: Phase,
    now_s: float,
    decider: Decider,
    *,
    analysis: StepAnalysis,
    decision: Decision,
    missing: Mapping[int, str],
) -> StepRecord:
    """Return the record of a step, without the times that it took."""
    diagnostics = decision.diagnostics
    return StepRecord(
        step=step,
        elapsed_s=now_s,
        phase=phase,
        visibility_m2=analysis.visibility_m2,
        visibility_present_m2=analysis.present_m2,
        threshold_m2=decider.threshold_m2,
        branch=diagnostics.branch,
        evolutionary_factor=diagnostics.evolutionary_factor,
        evolutionary_state=diagnostics.evolutionary_state,
        c_s_m=diagnostics.c_s_m,
        c_c_m=diagnostics.c_c_m,
        leader_id=analysis.leader_id,
        target_enu_m=decider.tracker.measured_enu_m,
        fitness=dict(zip(analysis.vehicle_ids, map(float, analysis.fitness), strict=True)),
        missing=dict(missing),
        waypoints=decision.waypoints,
        imaging_ms=0.0,
        work_ms=0.0,
        loop_lag_p99_ms=0.0,
    )
