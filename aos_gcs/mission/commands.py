"""Commands of operators to a mission in flight."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from typing import Final

from aos_gcs.errors import MissionError
from aos_gcs.geometry.geodesy import EnuPoint, GeodeticPosition
from aos_gcs.mission.actions import ActionHandler
from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.flow import PlannedFlow
from aos_gcs.mission.model.actions import Action, ActionResult, Seen
from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.model.events import EventKind, PlanRecord
from aos_gcs.mission.model.findings import MAX_DISTANCE_M, Finding, FindingChange
from aos_gcs.mission.model.proposals import ProposalRecord, ProposalUse
from aos_gcs.mission.phases import BEFORE_START, check_action
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.mission.views import LiveView
from aos_gcs.planning.checks.check import check_plan
from aos_gcs.planning.plan import MissionPlan, apply_plan
from aos_gcs.planning.settings import MissionSettings

_USES: Final = {
    ProposalUse.AREA: "taken over as search area",
    ProposalUse.NO_GO: "taken over as no-go zone",
    ProposalUse.FENCE: "taken over as geofence",
    ProposalUse.LAUNCH: "taken over as launch point",
    ProposalUse.RETURN: "taken over as return point",
    ProposalUse.FINDING: "marked as finding",
    ProposalUse.DISMISSED: "dismissed",
}


class LiveCommands:
    """Implements ``MissionCommands`` for a mission that is being flown.

    Args:
        context: context of the mission.
        flow: order of the phases.
        actions: carries out actions.
        view: publishes what has changed.
        findings: findings of the mission.
    """

    def __init__(
        self,
        context: MissionContext,
        flow: PlannedFlow,
        actions: ActionHandler,
        view: LiveView,
        findings: Findings,
    ) -> None:
        self._context = context
        self._flow = flow
        self._actions = actions
        self._view = view
        self._findings = findings

    async def act(
        self,
        action: Action,
        vehicle_ids: tuple[int, ...] | None,
        focal_height_m: float | None = None,
        *,
        operator: str = "",
        seen: Seen | None = None,
    ) -> tuple[ActionResult, ...]:
        """Carry out an operator's action; see ``MissionCommands.act``."""
        return await self._actions.act(action, vehicle_ids, focal_height_m, operator=operator, seen=seen)

    async def override_check(
        self, vehicle_id: int, check: str, reason: str | None, *, operator: str = "", seen: Seen | None = None
    ) -> PreflightCheck:
        """Override a failed preflight check; see ``MissionCommands.override_check``."""
        self._context.order.check_age(seen)
        self._context.auto_start.cancel(f"{operator or 'an operator'} has acted")
        check_action(self._flow.heading, Action.OVERRIDE)
        return await self._flow.sortie.overrides.decide(vehicle_id, check, reason, operator)

    async def acknowledge(self, notice_ids: Sequence[int], *, operator: str = "") -> None:
        """Acknowledge notices on behalf of all operators; see ``MissionCommands.acknowledge``."""
        journal, utc_s = self._context.journal, self._context.clock.utc_s()
        if self._view.acknowledgements.add(notice_ids, operator, utc_s, journal.notice_count):
            self._view.publish()

    async def announce(self, text: str, *, operator: str = "") -> None:
        """Put on record what operators have settled among themselves; see ``MissionCommands.announce``."""
        self._context.journal.operator_notice(operator, text)

    async def add_finding(self, position_enu_m: EnuPoint, comment: str, *, operator: str = "") -> Finding:
        """Mark a place by hand; see ``MissionCommands.add_finding``."""
        now_s, step = self._context.journal.elapsed_s(), self._flow.sortie.search.step
        finding, utc_s = self._findings.add(position_enu_m, comment, operator, step, now_s), self._context.clock.utc_s()
        if self._context.journal.started_utc_s is None:
            finding_id = finding.finding_id
            self._context.journal.once_started(
                lambda started_utc_s: self._findings.date(finding_id, utc_s - started_utc_s)
            )
        self._report(finding, operator, f"marked at {position_enu_m[0]:.1f} m east, {position_enu_m[1]:.1f} m north")
        return finding

    async def change_finding(self, finding_id: int, change: FindingChange, *, operator: str = "") -> Finding:
        """Judge, comment or assign a finding; see ``MissionCommands.change_finding``."""
        finding = self._findings.change(finding_id, change, operator)
        if change.is_empty:
            return finding
        changes = {"": change.status, "comment: ": change.comment, "assigned to ": change.assignee}
        texts = [f"{label}{value!s}" for label, value in changes.items() if value is not None]
        self._report(finding, operator, ", ".join(texts))
        return finding

    def _report(self, finding: Finding, operator: str, text: str) -> None:
        self._context.journal.operator_notice(operator, f"finding {finding.finding_id} {text}")
        self._view.publish()

    async def decide_proposal(self, proposal_id: int, use: ProposalUse, *, operator: str = "") -> ProposalRecord:
        """Put on record what an operator makes of a proposal of others; see ``MissionCommands.decide_proposal``."""
        record = self._view.proposals.check(proposal_id, use)
        proposal = record.proposal
        who = f"{proposal.sender or 'somebody'} ({proposal.source})"
        if use is ProposalUse.FINDING:
            frame = self._context.roster.frame
            if frame is None:
                raise MissionError("The mission's origin is not known yet: wait until a vehicle has reported its home.")
            place = GeodeticPosition(*proposal.points_deg[0], frame.origin.altitude_amsl_m)
            east_m, north_m, _ = map(float, frame.to_enu(place))
            if max(abs(east_m), abs(north_m)) > MAX_DISTANCE_M:
                raise MissionError(
                    f"The place is more than {MAX_DISTANCE_M / 1000.0:.0f} km from the mission; dismiss it."
                )
            comment = f"{proposal.name}, proposed by {who}. {proposal.remarks}".removesuffix(" ")
            await self.add_finding((east_m, north_m, 0.0), comment, operator=operator)
        decided = self._view.proposals.decide(proposal_id, use, operator, self._context.clock.utc_s())
        text = f"proposal '{proposal.name}' of {who} {_USES[use]}"
        self._context.journal.operator_notice(operator, text)
        self._view.publish()
        return decided

    @property
    def settings(self) -> MissionSettings:
        """Settings that the mission flies by at present."""
        return self._flow.sortie.context.settings

    async def apply_plan(self, plan: MissionPlan, *, operator: str = "", seen: Seen | None = None) -> None:
        """Fly by another plan; see ``MissionCommands.apply_plan``."""
        self._context.order.check_age(seen)
        # A tenth of a second and more: too long for the loop that commands vehicles.
        frame = self._context.roster.frame
        origin = None if frame is None else frame.origin
        problems = await asyncio.to_thread(check_plan, plan, self.settings, None, origin)
        if self._flow.heading not in BEFORE_START:
            raise MissionError("The plan can no longer be changed: the mission has started.")
        blocking = [problem for problem in problems if problem.blocking]
        if blocking:
            raise MissionError(f"This plan cannot be flown: {blocking[0].text}")
        self._context.order.check_overtaken(seen, None)
        self._context.auto_start.cancel(f"{operator or 'an operator'} has acted")
        self._context.order.note("another plan", None, operator)
        self._flow.follow_plan(apply_plan(self.settings, plan))
        self._context.journal.operator_notice(operator, "plan applied. Checks restarted")
        self._context.journal.publish(EventKind.PLAN, PlanRecord(plan, operator))
