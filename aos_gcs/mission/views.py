"""Read access to a mission in flight."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Protocol

from aos_gcs.airspace.waypoints import as_enu_point
from aos_gcs.mission.acknowledgements import Acknowledgements
from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.model.events import Event, EventKind
from aos_gcs.mission.model.phase import Outcome, Phase, Suspension
from aos_gcs.mission.model.sharing import ChannelStatus
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import Picture, PictureKind, StepRecord
from aos_gcs.mission.model.vehicles import Task, VehicleSnapshot
from aos_gcs.mission.phases import SAMPLING
from aos_gcs.mission.proposals import Proposals
from aos_gcs.mission.search.gallery import Gallery
from aos_gcs.mission.search.ground.mapping import GroundMapping
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.mission.search.targets.same_body import distinct
from aos_gcs.mission.sortie import Sortie


class CoordinatorState(Protocol):
    """The coordinator as the view sees it."""

    @property
    def phase(self) -> Phase:
        """The present phase."""
        ...

    @property
    def suspension(self) -> Suspension:
        """Why the mission makes no steps at present."""
        ...

    @property
    def outcome(self) -> Outcome:
        """Result of the mission, or that it has not ended."""
        ...

    @property
    def min_separation_m(self) -> float | None:
        """The smallest 3-D distance measured between two vehicles in the air so far."""
        ...

    @property
    def sortie(self) -> Sortie:
        """The sortie by the present plan."""
        ...


class LiveView:
    """Implements ``MissionView`` for a mission that is being flown.

    Args:
        mission_id: identifier of the mission.
        context: context of the mission.
        state: state of the coordinator.
        gallery: has the latest pictures.
        findings: findings of the mission.
        ground: map of the searched ground.
    """

    def __init__(
        self,
        mission_id: str,
        context: MissionContext,
        state: CoordinatorState,
        gallery: Gallery,
        findings: Findings,
        *,
        ground: GroundMapping,
    ) -> None:
        self._mission_id = mission_id
        self._context = context
        self._state = state
        self._gallery = gallery
        self._findings = findings
        self._ground = ground
        self.acknowledgements = Acknowledgements()
        self._sharing: tuple[ChannelStatus, ...] = ()
        self.proposals = Proposals()

    def show_sharing(self, statuses: tuple[ChannelStatus, ...]) -> None:
        """Show the states of live sharing, as its process has reported them."""
        self._sharing = statuses

    def snapshot(self) -> MissionSnapshot:
        """Return the present state."""
        journal, frame = self._context.journal, self._context.roster.frame
        sortie = self._state.sortie
        settings, limits, search = sortie.context.settings, sortie.context.bounds.limits, sortie.search
        tracker, progress = search.decider.tracker, search.decider.progress
        target = tracker.estimate()
        fence_enu_m = () if limits is None else limits.fence_enu_m
        return MissionSnapshot(
            mission_id=self._mission_id,
            strategy=settings.strategy,
            phase=self._state.phase,
            suspension=self._state.suspension,
            outcome=self._state.outcome,
            message=journal.message,
            elapsed_s=journal.elapsed_s(),
            step=search.step,
            origin=None if frame is None else frame.origin,
            area_enu_m=settings.area_enu_m,
            fence_enu_m=tuple((float(east), float(north)) for east, north in fence_enu_m),
            vehicles=self._vehicles(),
            preflight=sortie.overrides.checks,
            target=target,
            targets=distinct(tracker.estimates(), target),
            min_separation_m=self._state.min_separation_m,
            focus=sortie.vision.focus,
            no_go_enu_m=settings.safety.no_go_enu_m or (),
            legs_enu_m=tuple((leg.start_enu_m, leg.end_enu_m) for leg in progress.legs),
            leg=progress.leg,
            left_for_later=search.decider.choice.left_for_later,
            covered_fraction=search.covered_ground.covered_fraction,
            ground=self._ground.figures,
            scan_left_s=search.time_left_s() if self._state.phase in SAMPLING | {Phase.LINE} else None,
            findings=self._findings.all(),
            planned_vehicles=settings.vehicles,
            acknowledgements=self.acknowledgements.all(),
            command_count=self._context.order.count,
            follows_ground=settings.layers_follow_ground,
            started_utc_s=journal.started_utc_s,
            sharing=self._sharing,
            proposals=self.proposals.all(),
        )

    def _vehicles(self) -> tuple[VehicleSnapshot, ...]:
        roster, sortie = self._context.roster, self._state.sortie
        cameras, replacements = sortie.search.covered_ground.cameras, sortie.replacements
        return tuple(
            replace(
                _snapshot_of(roster, member),
                camera=cameras.of(member.vehicle_id),
                is_ready=replacements.is_ready(member) if replacements.is_waited_for(member) else None,
            )
            for member in roster.members()
        )

    def steps(self) -> Sequence[StepRecord]:
        """Return all steps so far, oldest first."""
        return self._context.journal.steps

    def picture(self, kind: PictureKind) -> Picture | None:
        """Return the latest raster of a kind, if there is one."""
        return self._gallery.latest(kind)

    def subscribe(self) -> AbstractContextManager[AsyncIterator[Event]]:
        """Follow the event stream from now on."""
        return self._context.journal.subscribe()

    def publish(self) -> None:
        """Put the present state on the event stream."""
        self._context.journal.publish(EventKind.SNAPSHOT, self.snapshot())


def _snapshot_of(roster: Roster, member: Member) -> VehicleSnapshot:
    """Describe one member."""
    position_enu_m = roster.position_enu_m(member)
    left = member.why_not_ours if member.task is Task.HELD and member.airborne else None
    return VehicleSnapshot(
        telemetry=member.state,
        task=member.task,
        layer_height_m=member.layer_height_m,
        position_enu_m=None if position_enu_m is None else as_enu_point(position_enu_m),
        link_age_s=roster.link_age_s(member),
        waypoint_enu_m=None if member.waypoint_enu_m is None else as_enu_point(member.waypoint_enu_m),
        refusal=member.refusal if left is None else left.text,
        takes_part=member.takes_part,
        home_enu_m=None if member.home_enu_m is None else as_enu_point(member.home_enu_m),
        altitude_offset_m=member.altitude_offset_m,
        height_above_ground_m=member.height_above_ground_m,
        leaves_in_s=member.leaves_in_s,
    )
