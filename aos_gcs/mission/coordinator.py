"""The coordinator: runs a mission through its phases and takes the operator's actions at any time."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Coroutine, Mapping, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import replace
from typing import Any

import numpy as np

from aos_gcs.errors import AosError, MissionError
from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.mission.acknowledgements import Acknowledgements
from aos_gcs.mission.actions import Operator
from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.fleet.flight import FlightControl
from aos_gcs.mission.fleet.joining import Joining
from aos_gcs.mission.fleet.monitor import Monitor
from aos_gcs.mission.fleet.return_and_land import Homing
from aos_gcs.mission.fleet.return_heights import ReturnHeights
from aos_gcs.mission.fleet.roster import Member, Roster
from aos_gcs.mission.fleet.vehicle_tasks import Errands
from aos_gcs.mission.health import LoopMonitor
from aos_gcs.mission.journal import Journal, Recorder
from aos_gcs.mission.launch import Launch
from aos_gcs.mission.model import (
    Action,
    ActionResult,
    Event,
    EventKind,
    Finding,
    FindingChange,
    MissionSnapshot,
    Outcome,
    OutcomeRecord,
    Phase,
    Picture,
    PictureKind,
    PlanRecord,
    PreflightCheck,
    StepRecord,
    Suspension,
    Task,
)
from aos_gcs.mission.phases import BEFORE_START, ENDING, ON_GROUND, check_action, check_transition
from aos_gcs.mission.preflight.inspection import Inspector
from aos_gcs.mission.preflight.overrides import Overrides
from aos_gcs.mission.search.findings import Findings
from aos_gcs.mission.search.gallery import Gallery
from aos_gcs.mission.search.search import Search
from aos_gcs.mission.search.vision import Vision
from aos_gcs.planning.check import check_plan
from aos_gcs.planning.plan import MissionPlan, apply_plan
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Clock, Fleet, ReturnToLaunch, Severity

_FAREWELL_S = 5.0
"""How long a mission that is torn down tries to send its vehicles home, real seconds."""


class Coordinator:
    """One mission, from the first heartbeat to the last landing; implements ``MissionControl``.

    One activity (a phase's handler) runs at a time, beside the monitor. An operator's action may end it early and
    choose what follows; every handler looks at the vehicles afresh, so it can be entered again.
    """

    def __init__(
        self,
        mission_id: str,
        settings: MissionSettings,
        *,
        fleet: Fleet,
        clock: Clock,
        journal: Journal,
        recorder: Recorder,
        loop_monitor: LoopMonitor,
    ) -> None:
        self._mission_id = mission_id
        roster = Roster(fleet, clock)
        flight = FlightControl(roster, clock, journal, settings.flight, settings.deadlines)
        self._context = MissionContext(
            settings=settings,
            clock=clock,
            roster=roster,
            journal=journal,
            flight=flight,
            recorder=recorder,
            loop_monitor=loop_monitor,
        )
        self._gallery = Gallery(self._context)
        self._vision = Vision(self._context)
        self._findings = Findings()
        self._acknowledgements = Acknowledgements()
        self._errands = Errands()
        self._return_heights = ReturnHeights(self._context)
        self._inspector = Inspector(self._context, self._return_heights)
        self._homing = Homing(self._context, self._errands)
        self._monitor = Monitor(self._context, self._homing, self._publish_snapshot, self.end_without_vehicles)
        self._joining = Joining(self._context, self._errands, self._inspector, self._check_one)
        self._operator = Operator(
            self._context, self._errands, homing=self._homing, joining=self._joining, vision=self._vision, flow=self
        )
        self._follow_plan()
        self.phase = Phase.CONNECT
        self.suspension = Suspension.NONE
        self._resumed = asyncio.Event()
        self._resumed.set()
        self._redirect: Phase | None = None
        self._activity: asyncio.Future[Phase] | None = None

    def _follow_plan(self) -> None:
        """Make the procedures that depend on the plan, for the settings as they are now."""
        self._overrides = Overrides(self._context)
        self._launch = Launch(self._context, self._overrides, self._inspector)
        self._search = Search(self._context, self._gallery, self._vision, self._findings)
        self._handlers: Mapping[Phase, Callable[[], Coroutine[Any, Any, Phase]]] = {
            Phase.CONNECT: self._launch.connect,
            Phase.PREFLIGHT: self._launch.preflight,
            Phase.READY: self._launch.ready,
            Phase.ARM: self._launch.arm,
            Phase.TAKEOFF: self._launch.takeoff,
            Phase.LINE: self._search.line,
            Phase.SCAN: lambda: self._search.make_step(Phase.SCAN),
            Phase.CONVERGE: lambda: self._search.make_step(Phase.CONVERGE),
            Phase.FOUND: lambda: self._search.make_step(Phase.FOUND),
            Phase.RETURN: self._homing.return_home,
            Phase.LAND: self._homing.land,
        }

    def _publish_snapshot(self) -> None:
        self._context.journal.publish(EventKind.SNAPSHOT, self.snapshot())

    async def _check_one(self, member: Member) -> Sequence[PreflightCheck]:
        return await self._launch.check_one(member)

    # --- MissionControl -----------------------------------------------------------------------------------------------

    def snapshot(self) -> MissionSnapshot:
        """Return the present state."""
        context = self._context
        limits, frame = context.flight.limits, context.roster.frame
        return MissionSnapshot(
            mission_id=self._mission_id,
            strategy=context.settings.strategy,
            phase=self.phase,
            suspension=self.suspension,
            outcome=context.outcome,
            message=context.message,
            elapsed_s=context.journal.elapsed_s(),
            step=self._search.step,
            origin=None if frame is None else frame.origin,
            area_enu_m=context.settings.area_enu_m,
            fence_enu_m=()
            if limits is None
            else tuple((float(east), float(north)) for east, north in limits.fence_enu_m),
            vehicles=tuple(
                replace(context.roster.snapshot(member), camera=context.cameras.of(member.vehicle_id))
                for member in context.roster.members()
            ),
            preflight=context.preflight,
            target=self._search.tracker.estimate(),
            targets=self._search.tracker.estimates(),
            min_separation_m=self._monitor.min_separation_m,
            focus=self._vision.focus,
            no_go_enu_m=context.settings.safety.no_go_enu_m or (),
            legs_enu_m=tuple((leg.start_enu_m, leg.end_enu_m) for leg in self._search.legs),
            leg=self._search.leg,
            covered_fraction=self._search.covered_fraction,
            findings=self._findings.all(),
            acknowledgements=self._acknowledgements.all(),
        )

    def steps(self) -> Sequence[StepRecord]:
        """Return all steps so far, oldest first."""
        return self._context.journal.steps

    def picture(self, kind: PictureKind) -> Picture | None:
        """Return the latest raster of a kind, if there is one."""
        return self._gallery.latest(kind)

    async def act(
        self,
        action: Action,
        vehicle_ids: tuple[int, ...] | None,
        focal_height_m: float | None = None,
        *,
        operator: str = "",
    ) -> tuple[ActionResult, ...]:
        """Carry out an operator's action; see ``MissionControl.act``."""
        return await self._operator.act(action, vehicle_ids, focal_height_m, operator=operator)

    async def override_check(
        self, vehicle_id: int, check: str, reason: str | None, *, operator: str = ""
    ) -> PreflightCheck:
        """Let a failed check no longer stand against the launch; see ``MissionControl.override_check``."""
        check_action(self.heading, Action.OVERRIDE)
        return await self._overrides.decide(vehicle_id, check, reason, operator)

    def acknowledge(self, notice_ids: Sequence[int], *, operator: str = "") -> None:
        """Take note of notices, on behalf of all operators; see ``MissionControl.acknowledge``."""
        journal, utc_s = self._context.journal, self._context.clock.utc_s()
        if self._acknowledgements.add(notice_ids, operator, utc_s, journal.notice_count):
            self._publish_snapshot()

    def subscribe(self) -> AbstractContextManager[AsyncIterator[Event]]:
        """Follow the event stream from now on."""
        return self._context.journal.subscribe()

    # --- FindingControl -----------------------------------------------------------------------------------------------

    def add_finding(self, position_enu_m: EnuPoint, comment: str, *, operator: str = "") -> Finding:
        """Mark a place by hand; see ``FindingControl.add_finding``."""
        now_s = self._context.journal.elapsed_s()
        finding = self._findings.add(position_enu_m, comment, operator, self._search.step, now_s)
        self._tell_of(finding, f"marked at {position_enu_m[0]:.1f} m east, {position_enu_m[1]:.1f} m north")
        return finding

    def change_finding(self, finding_id: int, change: FindingChange, *, operator: str = "") -> Finding:
        """Judge, comment or assign a finding; see ``FindingControl.change_finding``."""
        finding = self._findings.change(finding_id, change, operator)
        what = [
            f"{name} {value!s}"
            for name, value in (("is", change.status), ("comment:", change.comment), ("for", change.assignee))
            if value is not None
        ]
        self._tell_of(finding, ", ".join(what) or "is as it was")
        return finding

    def _tell_of(self, finding: Finding, what: str) -> None:
        who = f"operator {finding.operator}" if finding.operator else "operator"
        self._context.journal.notice(Severity.INFO, f"{who}: finding {finding.finding_id} {what}")
        self._publish_snapshot()

    # --- PlanControl --------------------------------------------------------------------------------------------------

    @property
    def settings(self) -> MissionSettings:
        """What the mission flies by at present."""
        return self._context.settings

    async def apply_plan(self, plan: MissionPlan, *, operator: str = "") -> None:
        """Fly by another plan; see ``PlanControl.apply_plan``."""
        context = self._context
        # A tenth of a second and more: too long for the loop that commands vehicles.
        problems = await asyncio.to_thread(check_plan, plan, context.settings)
        if self.heading not in BEFORE_START:
            raise MissionError(f"The plan can no longer be changed: the mission has started (phase {self.heading}).")
        blocking = [problem for problem in problems if problem.blocking]
        if blocking:
            raise MissionError(f"This plan cannot be flown: {blocking[0].text}")
        settings = context.settings = apply_plan(context.settings, plan)
        context.flight = FlightControl(
            context.roster, context.clock, context.journal, settings.flight, settings.deadlines
        )
        context.preflight = ()
        self._follow_plan()
        self.redirect(Phase.CONNECT)
        context.journal.notice(Severity.INFO, f"operator {operator}: new plan" if operator else "operator: new plan")
        context.journal.publish(EventKind.PLAN, PlanRecord(plan, operator))

    # --- what the operator's actions do to the flow -------------------------------------------------------------------

    @property
    def heading(self) -> Phase:
        """The phase that the mission is in, or on its way to by an action just taken."""
        return self.phase if self._redirect is None else self._redirect

    def redirect(self, phase: Phase) -> None:
        """End the present activity and go on with ``phase``; a suspension ends."""
        check_transition(self.heading, phase)
        self._redirect = phase
        self.suspension = Suspension.NONE
        self._resumed.set()
        self._interrupt()

    def suspend(self, suspension: Suspension) -> None:
        """Make no further step. A hold ends the present activity at once, a pause lets the step in hand finish."""
        self.suspension = suspension
        self._resumed.clear()
        if suspension is Suspension.HELD:
            self._interrupt()

    def resume(self) -> None:
        """Go on where the mission was suspended."""
        self.suspension = Suspension.NONE
        self._resumed.set()

    def _interrupt(self) -> None:
        if self._activity is not None:
            self._activity.cancel()

    # --- the flow -----------------------------------------------------------------------------------------------------

    async def run(self) -> Outcome:
        """Run the mission to its end and return how it ended. Cancelled in flight, it first sends everybody home."""
        try:
            async with asyncio.TaskGroup() as group:
                helpers = (
                    group.create_task(self._errands.run()),
                    group.create_task(self._inspector.run()),
                    group.create_task(self._monitor.run()),
                    group.create_task(self._context.loop_monitor.run()),
                )
                while self.phase is not Phase.DONE:
                    await self._resumed.wait()
                    self._enter(await self._run_activity())
                for helper in helpers:
                    helper.cancel()
        except Exception as error:
            self._context.message = f"Internal error, everybody returns: {error!r}"
            self._context.journal.notice(Severity.CRITICAL, self._context.message)
            if self._context.outcome is Outcome.OPEN:
                self._context.outcome = Outcome.FAILED
            raise
        finally:
            await self._leave()
        return self._context.outcome

    async def _run_activity(self) -> Phase:
        """Run the present phase's handler once, or until an operator ends it, and return what follows."""
        result: Phase | BaseException = self.phase
        if self._redirect is None:
            self._activity = asyncio.ensure_future(self._handlers[self.phase]())
            # Cancelling us cancels the activity and waits for it; its own cancellation comes back as a value.
            (result,) = await asyncio.gather(self._activity, return_exceptions=True)
            self._activity = None
        redirect, self._redirect = self._redirect, None
        if redirect is not None:
            return redirect
        if isinstance(result, asyncio.CancelledError):
            return self.phase
        if isinstance(result, AosError):
            return self._fail(str(result))
        if isinstance(result, BaseException):
            raise result
        return result

    def _enter(self, phase: Phase) -> None:
        if phase is self.phase:
            return
        self.phase = phase
        if phase is Phase.ARM:
            self._context.journal.start_timing()
        self._context.journal.notice(Severity.INFO, f"phase {phase}")

    def _fail(self, text: str) -> Phase:
        """Report the failure and return the way down: none on the ground, home from the air."""
        self._context.journal.notice(Severity.CRITICAL, text)
        self._context.message = text
        if self._context.outcome is Outcome.OPEN:
            self._context.outcome = Outcome.FAILED
        if self.phase in ON_GROUND or not self._context.roster.airborne():
            return Phase.DONE
        return Phase.LAND if self.phase in ENDING else Phase.RETURN

    def end_without_vehicles(self) -> None:
        """End the mission at once: there is nobody left to be flown."""
        self._context.outcome = Outcome.FAILED
        self._context.message = "All vehicles are lost: the mission is over. Their own failsafes fly them."
        self._context.journal.notice(Severity.CRITICAL, self._context.message)
        self._redirect = Phase.DONE
        self.resume()
        self._interrupt()

    async def _leave(self) -> None:
        """Send home who still flies under our command, and close the record whatever comes of it."""
        try:
            if self.phase is not Phase.DONE:
                await self._send_all_home()
            await self._return_heights.restore()
        finally:
            await self._close_record()

    async def _send_all_home(self) -> None:
        context = self._context
        left = [member for member in context.roster.airborne() if member.follows_us]
        with suppress(TimeoutError):
            async with asyncio.timeout(_FAREWELL_S):
                await context.flight.command_each(left, lambda _: ReturnToLaunch())

    async def _close_record(self) -> None:
        context = self._context
        if context.outcome is Outcome.OPEN:
            context.outcome = Outcome.ABORTED
        self._publish_snapshot()
        async with context.journal.patience("the outcome"):
            await context.recorder.record_outcome(
                OutcomeRecord(context.clock.utc_s(), context.outcome, self._summary())
            )
            await context.recorder.flush()

    def _summary(self) -> dict[str, object]:
        context = self._context
        target, steps = self._search.tracker.estimate(), context.journal.steps
        return {
            "message": context.message,
            "duration_s": context.journal.elapsed_s(),
            "steps": len(steps),
            "time_to_detection_s": self._search.found_at_s,
            "target_enu_m": None if target is None else target.position_enu_m,
            "target_sigma_m": None if target is None else target.sigma_m,
            "vehicles": len(context.roster.members()),
            "landed": len(context.roster.members(Task.LANDED)),
            "min_separation_m": self._monitor.min_separation_m,
            "work_ms_median": float(np.median([step.work_ms for step in steps])) if steps else None,
            "loop_lag_p99_ms": context.loop_monitor.lag_p99_ms(),
        }
