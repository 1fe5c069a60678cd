"""Conversion of the mission's snapshots with their preflight checks, of operators' actions, and of who has control."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Final

from aos_gcs.airspace.polygon import Polygon
from aos_gcs.api.access.control import ControlState
from aos_gcs.api.convert.findings import finding, left_place, target
from aos_gcs.api.convert.notices import acknowledgement
from aos_gcs.api.convert.places import finite, geodetic, percent, rounded, scan_leg, vertices
from aos_gcs.api.convert.proposals import proposal
from aos_gcs.api.convert.replay import replay_state
from aos_gcs.api.convert.reuse import Reused, ReusedItems
from aos_gcs.api.convert.sharing import channel
from aos_gcs.api.convert.vehicles import VehicleConverter
from aos_gcs.api.models.base import ScanLegModel, VertexModel
from aos_gcs.api.models.control import ControlModel
from aos_gcs.api.models.mission import (
    ActionResponse,
    ActionResultModel,
    DetectionModel,
    FocusModel,
    GroundModel,
    MissionModel,
    SegmentModel,
)
from aos_gcs.api.models.preflight import OverrideModel, PreflightCheckModel
from aos_gcs.api.models.vehicles import VehicleModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.groundmap.figures import GroundFigures, SegmentFigures
from aos_gcs.mission.control import ReplayState
from aos_gcs.mission.model.actions import Action, ActionResult
from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.model.phase import Suspension
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import FocusSnapshot
from aos_gcs.mission.model.vehicles import Task, VehicleSnapshot
from aos_gcs.mission.phases import is_allowed
from aos_gcs.ports import LandedState

JOIN_LINK_AGE_S: Final = 3.0
"""Age of a link beyond which a vehicle on the ground is not offered to join."""


class MissionConverter:
    """Converts snapshots of one mission; hands out the same objects again for what has not changed.

    Args:
        origin: origin of the mission's frame; None while it is unknown.
    """

    def __init__(self, origin: GeodeticPosition | None) -> None:
        self.origin: Final = origin
        self._vehicles: dict[int, VehicleConverter] = {}
        self._preflight = ReusedItems(preflight_check)
        self._findings = ReusedItems(partial(finding, origin=origin))
        self._left_for_later = ReusedItems(partial(left_place, origin=origin))
        self._acknowledgements = ReusedItems(acknowledgement)
        self._sharing = ReusedItems(channel)
        self._proposals = ReusedItems(proposal)
        self._area = Reused(self._polygon)
        self._fence = Reused(self._polygon)
        self._no_go = ReusedItems(self._polygon)
        self._legs = ReusedItems(self._leg)

    def convert(
        self,
        snapshot: MissionSnapshot,
        replay: ReplayState | None = None,
        control: ControlModel | None = None,
        *,
        is_survey: bool = False,
    ) -> MissionModel:
        """Convert a snapshot; in a replay and in a survey there is nothing to command."""
        origin = self.origin
        return MissionModel(
            mission_id=snapshot.mission_id,
            control=control,
            strategy=snapshot.strategy,
            phase=snapshot.phase,
            suspension=snapshot.suspension,
            outcome=snapshot.outcome,
            message=snapshot.message,
            elapsed_s=round(snapshot.elapsed_s, 1),
            started_utc_s=rounded(snapshot.started_utc_s, 1),
            step=snapshot.step,
            origin=geodetic(origin) if origin else None,
            area=self._area(snapshot.area_enu_m),
            fence=self._fence(snapshot.fence_enu_m),
            no_go=self._no_go(snapshot.no_go_enu_m),
            legs=self._legs(snapshot.legs_enu_m),
            leg=snapshot.leg,
            covered_percent=percent(snapshot.covered_fraction),
            ground=_ground(snapshot.ground) if snapshot.ground else None,
            scan_left_s=rounded(snapshot.scan_left_s, 0),
            vehicles=[self._vehicle(one) for one in snapshot.vehicles],
            planned_vehicles=snapshot.planned_vehicles,
            preflight=self._preflight(snapshot.preflight),
            target=target(snapshot.target, origin) if snapshot.target else None,
            targets=[target(one, origin) for one in snapshot.targets],
            left_for_later=self._left_for_later(snapshot.left_for_later),
            min_separation_m=rounded(snapshot.min_separation_m, 2),
            focus=_focus(snapshot.focus) if snapshot.focus else None,
            findings=self._findings(snapshot.findings),
            acknowledgements=self._acknowledgements(snapshot.acknowledgements),
            command_count=snapshot.command_count,
            sharing=self._sharing(snapshot.sharing),
            proposals=self._proposals(snapshot.proposals),
            replay=replay_state(replay) if replay else None,
            allowed_actions=[] if replay or is_survey else allowed_actions(snapshot),
        )

    def _vehicle(self, vehicle: VehicleSnapshot) -> VehicleModel:
        vehicle_id = vehicle.telemetry.vehicle_id
        if vehicle_id not in self._vehicles:
            self._vehicles[vehicle_id] = VehicleConverter(self.origin)
        return self._vehicles[vehicle_id].convert(vehicle)

    def _polygon(self, corners_enu_m: Polygon) -> list[VertexModel]:
        return vertices(corners_enu_m, self.origin)

    def _leg(self, leg_enu_m: tuple[tuple[float, float], tuple[float, float]]) -> ScanLegModel:
        return scan_leg(*leg_enu_m, self.origin)


def _focus(state: FocusSnapshot) -> FocusModel:
    """Convert the focal plane."""
    return FocusModel(height_m=state.height_m, source=state.source, sigma_m=finite(state.sigma_m))


def _ground(figures: GroundFigures) -> GroundModel:
    """Convert the figures about the searched ground."""
    shares, detection = figures.detection, None
    if shares is not None:
        detection = DetectionModel(
            standing=_percent(shares.standing), sitting=_percent(shares.sitting), lying=_percent(shares.lying)
        )
    return GroundModel(
        frames=figures.frames,
        left_out=figures.left_out,
        seen_percent=_percent(figures.seen_fraction),
        mean_views=round(figures.mean_views, 1),
        detection_percent=detection,
        soon_percent=_percent_if_known(figures.soon),
        success_percent=_percent_if_known(figures.success),
        segments=[_segment(segment) for segment in figures.segments],
    )


def _segment(segment: SegmentFigures) -> SegmentModel:
    """Convert the figures of a segment."""
    return SegmentModel(
        name=segment.name,
        hectares=round(segment.area_m2 / 1e4, 2),
        seen_percent=_percent(segment.seen_fraction),
        detection_percent=_percent_if_known(segment.detection),
        probability_percent=_percent_if_known(segment.probability),
        success_percent=_percent_if_known(segment.success),
    )


def _percent_if_known(share: float | None) -> float | None:
    return None if share is None else _percent(share)


def _percent(share: float) -> float:
    return round(100.0 * share, 1)


def allowed_actions(snapshot: MissionSnapshot) -> list[Action]:
    """Return the actions of the phase that are worth offering: those that have something to act on."""
    tasks = {one.task for one in snapshot.vehicles}
    is_suspended = snapshot.suspension is not Suspension.NONE
    useless = set()
    if is_suspended:
        useless.add(Action.PAUSE)
    elif Task.HELD not in tasks:
        useless.add(Action.RESUME)
    if not any(map(_may_join, snapshot.vehicles)):
        useless.add(Action.JOIN)
    if not any(_may_join(one) and not one.is_ready and _is_spare(one) for one in snapshot.vehicles):
        useless.add(Action.READY)
    if not any(one.is_ready for one in snapshot.vehicles):
        useless.add(Action.NOT_READY)
    anyone_flies = any(
        one.telemetry.armed and one.telemetry.landed is not LandedState.ON_GROUND for one in snapshot.vehicles
    )
    return [
        action
        for action in Action
        if is_allowed(snapshot.phase, action, anyone_flies=anyone_flies) and action not in useless
    ]


def _is_spare(vehicle: VehicleSnapshot) -> bool:
    """Return whether a vehicle could be confirmed for the relay: it has landed, or is not one of the swarm."""
    return vehicle.task is Task.LANDED or not vehicle.takes_part


def _may_join(vehicle: VehicleSnapshot) -> bool:
    """Return whether a vehicle waits on the ground that reports what it needs for joining: link, home, readiness."""
    telemetry = vehicle.telemetry
    is_heard = vehicle.link_age_s is not None and vehicle.link_age_s <= JOIN_LINK_AGE_S
    is_waiting = vehicle.task in {Task.IDLE, Task.LANDED} and telemetry.landed is LandedState.ON_GROUND
    return is_heard and is_waiting and telemetry.home is not None and telemetry.ready_to_arm is not False


def action_results(action: Action, results: Iterable[ActionResult]) -> ActionResponse:
    """Convert what became of an action."""
    return ActionResponse(
        action=action,
        results=[ActionResultModel(vehicle_id=one.vehicle_id, accepted=one.accepted, text=one.text) for one in results],
    )


def preflight_check(check: PreflightCheck) -> PreflightCheckModel:
    """Convert one cell of the matrix."""
    override = check.overridden
    return PreflightCheckModel(
        vehicle_id=check.vehicle_id,
        name=check.name,
        status=check.status,
        text=check.text,
        remedy=check.remedy,
        overridable=check.overridable,
        overridden=OverrideModel(reason=override.reason, by=override.by, utc_s=override.utc_s) if override else None,
        blocks=check.blocks,
    )


def control(state: ControlState) -> ControlModel:
    """Convert who has control."""
    return ControlModel(
        holder=state.holder,
        holder_present=state.is_holder_present,
        operators=list(state.operators),
        requests=list(state.requests),
    )
