"""A mission by script: believable data for the API and the dashboard without vehicles, imaging or chance."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace

import numpy as np

from aos_gcs.errors import MissionError
from aos_gcs.geometry.geodesy import EnuPoint, GeodeticPosition, LocalFrame
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.acknowledgements import Acknowledgements
from aos_gcs.mission.command_order import CommandOrder
from aos_gcs.mission.events import EventStream
from aos_gcs.mission.model.actions import Action, ActionResult, Seen
from aos_gcs.mission.model.checks import CheckOverride, CheckStatus, PreflightCheck
from aos_gcs.mission.model.events import Event, EventKind, NoticeRecord, PicturesRecord, PlanRecord
from aos_gcs.mission.model.findings import ErrorEllipse, Finding, FindingChange, TargetEstimate
from aos_gcs.mission.model.phase import Outcome, Phase, Suspension
from aos_gcs.mission.model.proposals import ProposalRecord, ProposalUse
from aos_gcs.mission.model.sharing import ChannelStatus
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import FocusSnapshot, FocusSource, Picture, PictureKind, StepRecord
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.phases import check_action
from aos_gcs.mission.proposals import Proposals
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.planning.plan import MissionPlan, apply_plan
from aos_gcs.planning.settings import MissionSettings, TerrainSettings
from aos_gcs.ports import Clock, FlightMode, Severity
from tests.fakes.pictures import paint
from tests.fakes.scripted_checks import PROPOSED, scripted_checks
from tests.fakes.scripted_ground import GROUND
from tests.fakes.scripted_vehicle import ORIGIN, SILENT_ID, TARGET_ENU_M, ScriptedVehicle

AREA_ENU_M = ((-60.0, -20.0), (60.0, -20.0), (60.0, 110.0), (-60.0, 110.0))
FENCE_ENU_M = ((-80.0, -50.0), (80.0, -50.0), (80.0, 130.0), (-80.0, 130.0))
THRESHOLD_M2 = 0.3
STEP_INTERVAL_S = 2.0
_PICTURE_HALF_WIDTH_M = 25.0


class ScriptedMission:
    """Implements ``MissionView`` and ``MissionCommands``; time passes by ``advance`` alone, which ``run`` calls.

    Args:
        clock: stamps the events.
        vehicles: ids from 1; one is never heard, one refuses to return.
        terrain: elevation model of the ground.
    """

    def __init__(self, clock: Clock, vehicles: int = 8, terrain: TerrainSettings | None = None) -> None:
        self.stream = EventStream(clock)
        self.actions: list[tuple[Action, tuple[int, ...] | None]] = []
        self.announced: list[tuple[str, str]] = []
        self.overrides: dict[tuple[int, str], CheckOverride] = {}
        self.mission_id = "scripted-1"
        self.findings = Findings()
        self.acknowledgements = Acknowledgements()
        self.order = CommandOrder("scripted-1", lambda: 0.0, math.inf)
        """Commands of any age are taken, since the machine may be busy; tests of their age replace it."""
        self.sharing: tuple[ChannelStatus, ...] = ()
        self.proposals = Proposals()
        self._clock = clock
        self._notices = 0
        self.operators: list[str] = []
        """Operator who requested the action at the same index."""
        self.phase = Phase.READY
        self.suspension = Suspension.NONE
        self.warning = ""  # text of a check that warns
        self.focus = FocusSnapshot(0.0, FocusSource.CONFIGURED, None)
        self.elapsed_s = 0.0
        self._started_utc_s: float | None = None
        self._settings = MissionSettings(vehicles, AREA_ENU_M, ImagingSettings(), terrain=terrain)
        self._phase_s = 0.0
        self._since_step_s = 0.0
        self._chosen = frozenset(range(1, vehicles + 1))
        self._steps: list[StepRecord] = []
        self._pictures: dict[PictureKind, Picture] = {}
        """Pictures of the latest step that somebody has asked for: painting them takes longer than the step."""
        self._vehicles: list[ScriptedVehicle] = []
        for index in range(vehicles):
            home = (-21.0 + 6.0 * index, -38.0, 0.0)
            self._vehicles.append(ScriptedVehicle(index + 1, home, home, 30.0 + 2.0 * index))

    async def run(self, interval_s: float = 0.25, speed: float = 1.0) -> None:
        """Let time pass until cancelled, ``speed`` times as fast as real time."""
        while True:
            self.advance(interval_s * speed)
            await asyncio.sleep(interval_s)

    # --- MissionView and MissionCommands

    def snapshot(self) -> MissionSnapshot:
        """Return the present state."""
        return MissionSnapshot(
            mission_id=self.mission_id,
            strategy="aos-apso",
            phase=self.phase,
            suspension=self.suspension,
            outcome=Outcome.FOUND if self.phase is Phase.FOUND else Outcome.OPEN,
            message=self._message(),
            elapsed_s=self.elapsed_s,
            step=len(self._steps),
            origin=ORIGIN,
            area_enu_m=self._settings.area_enu_m,
            fence_enu_m=FENCE_ENU_M,
            vehicles=tuple(
                vehicle.snapshot(self.phase, self.elapsed_s, is_chosen=vehicle.vehicle_id in self._chosen)
                for vehicle in self._vehicles
            ),
            preflight=self._preflight(),
            target=self._target(),
            targets=tuple(filter(None, [self._target()])),
            min_separation_m=5.21 if self._steps else None,
            focus=self.focus,
            findings=self.findings.all(),
            planned_vehicles=len(self._chosen) or PROPOSED,
            acknowledgements=self.acknowledgements.all(),
            command_count=self.order.count,
            sharing=self.sharing,
            proposals=self.proposals.all(),
            started_utc_s=self._started_utc_s,
            ground=GROUND if self._steps else None,
            scan_left_s=252.0 if self._steps else None,
        )

    def steps(self) -> Sequence[StepRecord]:
        """Return all steps so far."""
        return tuple(self._steps)

    def picture(self, kind: PictureKind) -> Picture | None:
        """Return the latest raster."""
        if kind not in self._pictures and self._steps:
            latest = self._steps[-1]
            bounds = _picture_bounds(latest.step)
            png = paint(kind, latest.step, bounds, TARGET_ENU_M, latest.visibility_m2)
            self._pictures[kind] = Picture(kind, latest.step, png, *bounds)
        return self._pictures.get(kind)

    async def act(
        self,
        action: Action,
        vehicle_ids: tuple[int, ...] | None,
        focal_height_m: float | None = None,
        *,
        operator: str = "",
        seen: Seen | None = None,
    ) -> tuple[ActionResult, ...]:
        """Carry out an action at once."""
        self.order.check(seen, action, vehicle_ids)
        check_action(self.phase, action)
        known = {vehicle.vehicle_id for vehicle in self._vehicles}
        unknown = sorted(set(vehicle_ids or ()) - known)
        if unknown:
            raise MissionError(f"There is no vehicle {unknown[0]} in this mission.")
        if action is Action.OVERRIDE:
            raise MissionError("An override concerns one check of one vehicle.")
        if (action is Action.FOCUS and vehicle_ids is not None) or (action is not Action.FOCUS and focal_height_m):
            raise MissionError("The focal plane is one for the whole mission.")
        self.order.note(action, vehicle_ids, operator)
        self.actions.append((action, vehicle_ids))
        self.operators.append(operator)
        if action is Action.FOCUS:
            source = FocusSource.CONFIGURED if focal_height_m is None else FocusSource.OPERATOR
            self.focus = FocusSnapshot(focal_height_m or 0.0, source, None)
            return ()
        if vehicle_ids is None:
            self._act_on_mission(action)
        if action is Action.CHOOSE:
            if vehicle_ids is None:
                raise MissionError("A mission needs at least one vehicle; name it.")
            self._chosen = frozenset(vehicle_ids)
            return tuple(ActionResult(number, accepted=True, text="flies the mission") for number in vehicle_ids)
        results = tuple(
            vehicle.act(action)
            for vehicle in self._vehicles
            if vehicle_ids is None or vehicle.vehicle_id in vehicle_ids
        )
        self.notify(Severity.INFO, f"Operator: {action}.")
        self._publish_snapshot()
        return results

    async def override_check(
        self, vehicle_id: int, check: str, reason: str | None, *, operator: str = "", seen: Seen | None = None
    ) -> PreflightCheck:
        """Override a failed check, or take that back."""
        self.order.check_age(seen)
        check_action(self.phase, Action.OVERRIDE)
        key = (vehicle_id, check)
        found = next((one for one in self._preflight() if (one.vehicle_id, one.name) == key), None)
        if found is None or found.status is not CheckStatus.FAIL or not found.overridable:
            raise MissionError(f"{check} of vehicle {vehicle_id} cannot be overridden.")
        self.overrides.pop(key, None)
        if reason is not None:
            self.overrides[key] = CheckOverride(reason, operator, 0.0)
        return replace(found, overridden=self.overrides.get(key))

    async def add_finding(self, position_enu_m: EnuPoint, comment: str, *, operator: str = "") -> Finding:
        """Mark a place by hand."""
        return self.findings.add(position_enu_m, comment, operator, len(self._steps), self.elapsed_s)

    async def change_finding(self, finding_id: int, change: FindingChange, *, operator: str = "") -> Finding:
        """Judge, comment or assign a finding."""
        return self.findings.change(finding_id, change, operator)

    async def acknowledge(self, notice_ids: Sequence[int], *, operator: str = "") -> None:
        """Take note of notices."""
        self.acknowledgements.add(notice_ids, operator, self._clock.utc_s(), self._notices)

    async def announce(self, text: str, *, operator: str = "") -> None:
        """Put on record what operators have settled."""
        self.announced.append((operator, text))
        self.notify(Severity.INFO, f"{operator or 'operator'}: {text}")

    async def decide_proposal(self, proposal_id: int, use: ProposalUse, *, operator: str = "") -> ProposalRecord:
        """Decide about a proposal."""
        decided = self.proposals.decide(proposal_id, use, operator, self._clock.utc_s())
        if use is ProposalUse.FINDING:
            place = GeodeticPosition(*decided.proposal.points_deg[0], ORIGIN.altitude_amsl_m)
            east_m, north_m, _ = map(float, LocalFrame(ORIGIN).to_enu(place))
            await self.add_finding((east_m, north_m, 0.0), decided.proposal.name, operator=operator)
        return decided

    @property
    def settings(self) -> MissionSettings:
        """What the mission flies by."""
        return self._settings

    async def apply_plan(self, plan: MissionPlan, *, operator: str = "", seen: Seen | None = None) -> None:
        """Fly by another plan."""
        self.order.check_age(seen)
        self.order.check_overtaken(seen, None)
        if self.phase is not Phase.READY:
            raise MissionError("The plan can no longer be changed: the mission has started.")
        self._settings = apply_plan(self._settings, plan)
        self.stream.publish(EventKind.PLAN, PlanRecord(plan, operator))

    def subscribe(self) -> AbstractContextManager[AsyncIterator[Event]]:
        """Follow the events."""
        return self.stream.subscribe()

    # --- the script

    def forget_vehicles(self) -> None:
        """Have operators confirm the vehicles that fly; preflight passes when ``pass_preflight`` is called."""
        self._chosen, self.phase = frozenset(), Phase.PREFLIGHT
        self._publish_snapshot()

    def pass_preflight(self, *, warning: str = "") -> None:
        """Let the checks pass, one of the first vehicle with a warning where one is given."""
        self.warning, self.phase = warning, Phase.READY
        self._publish_snapshot()

    def notify(self, severity: Severity, text: str, vehicle_id: int | None = None, track_id: int | None = None) -> None:
        """Publish a notice."""
        self._notices += 1
        utc_s = self._clock.utc_s()
        notice = NoticeRecord(severity, text, vehicle_id, self.elapsed_s, self._notices, utc_s, track_id)
        self.stream.publish(EventKind.NOTICE, notice)

    def advance(self, duration_s: float) -> None:
        """Let time pass: move the vehicles, change phases, make steps; publishes a snapshot."""
        if self.phase not in {Phase.READY, Phase.DONE}:
            self.elapsed_s += duration_s
            self._phase_s += duration_s
            self._change_phase()
            for vehicle in self._vehicles:
                vehicle.move(self.phase, duration_s)
            if self.suspension is Suspension.NONE and self.phase in {Phase.SCAN, Phase.CONVERGE, Phase.FOUND}:
                self._since_step_s += duration_s
                if self._since_step_s >= STEP_INTERVAL_S:
                    self._since_step_s = 0.0
                    self.make_step()
        self._publish_snapshot()

    def make_step(self) -> None:
        """Record and publish one step, with its pictures."""
        number = len(self._steps) + 1
        # Chosen to look like a search that closes in on its target: flat noise, then a steep rise to a plateau.
        visibility_m2 = 0.04 + 0.02 * math.sin(2.1 * number) + 0.9 / (1.0 + math.exp(9.0 - 0.8 * number))
        in_view = visibility_m2 >= THRESHOLD_M2
        self.phase = Phase.FOUND if number >= 16 else Phase.CONVERGE if in_view else Phase.SCAN
        record = StepRecord(
            step=number,
            elapsed_s=self.elapsed_s,
            phase=self.phase,
            visibility_m2=visibility_m2,
            threshold_m2=THRESHOLD_M2,
            branch="pso" if in_view else "line",
            evolutionary_factor=max(0.08, 0.8 - 0.045 * number) if in_view else None,
            evolutionary_state=("convergence" if number > 13 else "exploitation") if in_view else None,
            c_s_m=1.0,
            c_c_m=2.0,
            leader_id=3 if in_view else None,
            target_enu_m=self._sighting(number) if in_view else None,
            fitness={vehicle.vehicle_id: visibility_m2 / (1 + index) for index, vehicle in enumerate(self._vehicles)},
            missing={SILENT_ID: "no frame before the deadline"} if len(self._vehicles) >= SILENT_ID else {},
            waypoints=tuple(
                vehicle.plan(index, number, in_view=in_view) for index, vehicle in enumerate(self._vehicles)
            ),
            imaging_ms=61.0,
            work_ms=84.0,
            loop_lag_p99_ms=3.0,
        )
        self._steps.append(record)
        self.findings.observe(tuple(filter(None, [self._target()])), number, self.elapsed_s)
        for vehicle in self._vehicles:
            vehicle.expose(number)
        self.stream.publish(EventKind.STEP, record)
        self._publish_pictures(number)

    def _change_phase(self) -> None:
        if self.suspension is not Suspension.NONE:
            return
        following = {Phase.ARM: (1.0, Phase.TAKEOFF), Phase.TAKEOFF: (4.0, Phase.LINE), Phase.LINE: (5.0, Phase.SCAN)}
        if self.phase in following and self._phase_s >= following[self.phase][0]:
            self._enter(following[self.phase][1])
        elif self.phase is Phase.RETURN and self._phase_s >= 12.0:
            self._enter(Phase.LAND)

    def _enter(self, phase: Phase) -> None:
        self.phase = phase
        self._phase_s = 0.0
        for index, vehicle in enumerate(self._vehicles):
            if phase is Phase.LINE and vehicle.task is Task.SWARM:
                vehicle.mode = FlightMode.GUIDED
                vehicle.waypoint_enu_m = (-42.0 + 12.0 * index, -15.0, vehicle.layer_height_m)

    def _act_on_mission(self, action: Action) -> None:
        suspensions = {
            Action.HOLD: Suspension.HELD,
            Action.PAUSE: Suspension.PAUSED,
            Action.RESUME: Suspension.NONE,
        }
        self.suspension = suspensions.get(action, self.suspension)
        phases = {Action.START: Phase.ARM, Action.RETURN: Phase.RETURN, Action.LAND: Phase.LAND}
        if action is Action.START:
            self._started_utc_s = self._clock.utc_s()
        if action in phases:
            self._enter(phases[action])
            self.suspension = Suspension.NONE
        elif action is Action.ABORT:
            self._enter(Phase.RETURN)

    # --- what is shown

    def _publish_snapshot(self) -> None:
        self.stream.publish(EventKind.SNAPSHOT, self.snapshot())

    def _message(self) -> str:
        if self.suspension is not Suspension.NONE:
            return f"{self.suspension.capitalize()} by the operator."
        return {
            Phase.READY: "Preflight has passed; waiting for start.",
            Phase.SCAN: f"Scanning in a line, step {len(self._steps)}.",
            Phase.CONVERGE: "Closing in on a possible target.",
            Phase.FOUND: "Target found; holding above it and tracking.",
            Phase.RETURN: "Returning to the launch site.",
        }.get(self.phase, f"{self.phase.capitalize()} in progress.")

    def _sighting(self, number: int) -> EnuPoint:
        return (TARGET_ENU_M[0] + math.sin(number) * 0.8, TARGET_ENU_M[1] + math.cos(2 * number) * 0.8, 0.0)

    def _target(self) -> TargetEstimate | None:
        seen = [step.target_enu_m for step in self._steps if step.target_enu_m is not None]
        if not seen:
            return None
        east_m, north_m, up_m = np.mean(np.array(seen), axis=0)
        sigma_m = 2.4 / math.sqrt(len(seen))
        ellipse = ErrorEllipse(1.2 * sigma_m, 0.8 * sigma_m, heading_rad=0.6)
        return TargetEstimate(
            (float(east_m), float(north_m), float(up_m)), sigma_m, len(seen), track_id=1, ellipse=ellipse
        )

    def _preflight(self) -> tuple[PreflightCheck, ...]:
        ids = [vehicle.vehicle_id for vehicle in self._vehicles]
        checks = scripted_checks(ids, is_confirmed=bool(self._chosen), warning=self.warning)
        return tuple(replace(check, overridden=self.overrides.get((check.vehicle_id, check.name))) for check in checks)

    def _publish_pictures(self, number: int) -> None:
        self._pictures.clear()
        self.stream.publish(EventKind.PICTURES, PicturesRecord(number, tuple(PictureKind), *_picture_bounds(number)))


def _picture_bounds(step: int) -> tuple[float, float, float, float]:
    """Return west, south, east and north of a step's pictures, in metres."""
    east_m = min(TARGET_ENU_M[0], -42.0 + 6.0 * step)
    north_m = min(TARGET_ENU_M[1], -15.0 + 8.0 * step)
    return (
        east_m - _PICTURE_HALF_WIDTH_M,
        north_m - _PICTURE_HALF_WIDTH_M,
        east_m + _PICTURE_HALF_WIDTH_M,
        north_m + _PICTURE_HALF_WIDTH_M,
    )
