"""From the mission's dataclasses to wire models: plain functions, one per kind of data."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache

from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.api import models as wire
from aos_gcs.api.convert_vehicle import vehicle
from aos_gcs.api.places import (
    finite,
    geodetic,
    optional_position,
    percent,
    position,
    positions,
    rounded,
    scan_leg,
    vertex,
)
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.notations import dms, mgrs_text, utm_text
from aos_gcs.mission import model
from aos_gcs.mission.acknowledgements import ACKNOWLEDGEMENTS_KEPT
from aos_gcs.mission.control import ReplayState, Timeline
from aos_gcs.mission.phases import is_allowed
from aos_gcs.mission.search.findings import MAX_FINDINGS
from aos_gcs.ports import LandedState

_CHECKS_KEPT = 4096
"""The matrix of a large fleet comes again with every snapshot, and hardly changes."""


def focus(state: model.FocusSnapshot) -> wire.FocusModel:
    """Convert the focal plane."""
    return wire.FocusModel(height_m=state.height_m, source=state.source, sigma_m=finite(state.sigma_m))


def allowed_actions(snapshot: model.MissionSnapshot) -> list[model.Action]:
    """Return the actions of the phase that are worth offering: those that have something to act on."""
    tasks = {one.task for one in snapshot.vehicles}
    is_suspended = snapshot.suspension is not model.Suspension.NONE
    useless = set()
    if is_suspended:
        useless.add(model.Action.PAUSE)
    elif model.Task.HELD not in tasks:
        useless.add(model.Action.RESUME)
    if not tasks & {model.Task.IDLE, model.Task.LANDED}:
        useless.add(model.Action.JOIN)
    anyone_flies = any(
        one.telemetry.armed and one.telemetry.landed is not LandedState.ON_GROUND for one in snapshot.vehicles
    )
    return [
        action
        for action in model.Action
        if is_allowed(snapshot.phase, action, anyone_flies=anyone_flies) and action not in useless
    ]


def ellipse(error: model.ErrorEllipse) -> wire.EllipseModel:
    """Convert an error ellipse."""
    return wire.EllipseModel(
        semi_major_m=error.semi_major_m,
        semi_minor_m=error.semi_minor_m,
        heading_deg=math.degrees(error.heading_rad),
    )


def target(estimate: model.TargetEstimate, origin: GeodeticPosition | None) -> wire.TargetModel:
    """Convert one target."""
    velocity_enu_mps = estimate.velocity_enu_mps
    return wire.TargetModel(
        track_id=estimate.track_id,
        confirmed=estimate.confirmed,
        position=position(estimate.position_enu_m, origin),
        sigma_m=finite(estimate.sigma_m),
        ellipse=ellipse(estimate.ellipse) if estimate.ellipse else None,
        speed_mps=math.hypot(*velocity_enu_mps) if velocity_enu_mps else None,
        sightings=estimate.sightings,
        seen_at_s=finite(estimate.seen_at_s),
        person_confidence=estimate.person_confidence,
    )


@lru_cache(maxsize=MAX_FINDINGS)
def finding(found: model.Finding, origin: GeodeticPosition | None) -> wire.FindingModel:
    """Convert one finding, its place in all notations."""
    place = position(found.position_enu_m, origin)
    at_deg = (place.latitude_deg, place.longitude_deg)
    return wire.FindingModel(
        finding_id=found.finding_id,
        status=found.status,
        position=place,
        dms=_written(dms, *at_deg),
        utm=_written(utm_text, *at_deg),
        mgrs=_written(mgrs_text, *at_deg),
        sigma_m=rounded(found.sigma_m, 2),
        ellipse=ellipse(found.ellipse) if found.ellipse else None,
        sightings=found.sightings,
        person_confidence=rounded(found.person_confidence, 3),
        track_id=found.track_id,
        found_at_s=round(found.found_at_s, 1),
        seen_at_s=round(found.seen_at_s, 1),
        step=found.step,
        comment=found.comment,
        assignee=found.assignee,
        operator=found.operator,
    )


def _written(
    notation: Callable[[float, float], str | None], latitude_deg: float | None, longitude_deg: float | None
) -> str | None:
    return None if latitude_deg is None or longitude_deg is None else notation(latitude_deg, longitude_deg)


class _Matrix:
    """Converts the matrix of preflight, and remembers the latest: a fleet has thousands of cells, too many to hash."""

    def __init__(self) -> None:
        self._checks: tuple[model.PreflightCheck, ...] = ()
        self._converted: list[wire.PreflightCheckModel] = []

    def convert(self, checks: tuple[model.PreflightCheck, ...]) -> list[wire.PreflightCheckModel]:
        """Return all cells."""
        if checks is not self._checks:
            self._checks, self._converted = checks, [preflight_check(check) for check in checks]
        return self._converted


_MATRIX = _Matrix()


@lru_cache(maxsize=_CHECKS_KEPT)
def preflight_check(check: model.PreflightCheck) -> wire.PreflightCheckModel:
    """Convert one cell of the matrix."""
    override = check.overridden
    return wire.PreflightCheckModel(
        vehicle_id=check.vehicle_id,
        name=check.name,
        status=check.status,
        text=check.text,
        remedy=check.remedy,
        overridable=check.overridable,
        overridden=wire.OverrideModel(reason=override.reason, by=override.by, utc_s=override.utc_s)
        if override
        else None,
        blocks=check.blocks,
    )


def mission(snapshot: model.MissionSnapshot, replay: ReplayState | None = None) -> wire.MissionModel:
    """Convert a whole snapshot; in a replay there is nothing to command."""
    origin = snapshot.origin
    return wire.MissionModel(
        mission_id=snapshot.mission_id,
        strategy=snapshot.strategy,
        phase=snapshot.phase,
        suspension=snapshot.suspension,
        outcome=snapshot.outcome,
        message=snapshot.message,
        elapsed_s=round(snapshot.elapsed_s, 1),
        step=snapshot.step,
        origin=geodetic(origin) if origin else None,
        area=[vertex(point, origin) for point in snapshot.area_enu_m],
        fence=[vertex(point, origin) for point in snapshot.fence_enu_m],
        no_go=[[vertex(point, origin) for point in zone] for zone in snapshot.no_go_enu_m],
        legs=[scan_leg(start, end, origin) for start, end in snapshot.legs_enu_m],
        leg=snapshot.leg,
        covered_percent=percent(snapshot.covered_fraction),
        vehicles=[vehicle(one, origin) for one in snapshot.vehicles],
        preflight=_MATRIX.convert(snapshot.preflight),
        target=target(snapshot.target, origin) if snapshot.target else None,
        targets=[target(one, origin) for one in snapshot.targets],
        min_separation_m=rounded(snapshot.min_separation_m, 2),
        focus=focus(snapshot.focus) if snapshot.focus else None,
        findings=[finding(one, origin) for one in snapshot.findings],
        acknowledgements=[acknowledgement(one) for one in snapshot.acknowledgements],
        replay=replay_state(replay) if replay else None,
        allowed_actions=[] if replay else allowed_actions(snapshot),
    )


def replay_state(state: ReplayState) -> wire.ReplayModel:
    """Convert where a replay is."""
    return wire.ReplayModel(
        time_s=round(state.time_s, 1),
        duration_s=round(state.duration_s, 1),
        speed=state.speed,
        playing=state.playing,
    )


def timeline(state: ReplayState, line: Timeline) -> wire.TimelineModel:
    """Convert a replay, and what lies where in it."""
    return wire.TimelineModel(
        replay=replay_state(state),
        start_utc_s=line.start_utc_s,
        phases=[wire.ReplayPhaseModel(time_s=round(time_s, 1), phase=phase) for time_s, phase in line.phases],
        steps=[wire.ReplayStepModel(time_s=round(time_s, 1), step=step) for time_s, step in line.steps],
        notices=[
            wire.ReplayNoticeModel(
                time_s=round(time_s, 1), severity=record.severity, text=record.text, vehicle_id=record.vehicle_id
            )
            for time_s, record in line.notices
        ],
        findings=[
            wire.ReplayFindingModel(time_s=round(time_s, 1), finding_id=found.finding_id, status=found.status)
            for time_s, found in line.findings
        ],
    )


def step(record: model.StepRecord, origin: GeodeticPosition | None) -> wire.StepModel:
    """Convert a step."""
    return wire.StepModel(
        step=record.step,
        elapsed_s=record.elapsed_s,
        phase=record.phase,
        visibility_m2=finite(record.visibility_m2),
        threshold_m2=finite(record.threshold_m2),
        branch=record.branch,
        evolutionary_factor=finite(record.evolutionary_factor),
        evolutionary_state=record.evolutionary_state,
        c_s_m=finite(record.c_s_m),
        c_c_m=finite(record.c_c_m),
        leader_id=record.leader_id,
        target=optional_position(record.target_enu_m, origin),
        fitness=[wire.FitnessModel(vehicle_id=key, fitness=finite(f)) for key, f in sorted(record.fitness.items())],
        missing=[wire.MissingModel(vehicle_id=key, reason=text) for key, text in sorted(record.missing.items())],
        waypoints=waypoints(record.waypoints, origin),
        imaging_ms=record.imaging_ms,
        work_ms=record.work_ms,
        loop_lag_p99_ms=record.loop_lag_p99_ms,
    )


def waypoints(records: Sequence[WaypointRecord], origin: GeodeticPosition | None) -> list[wire.WaypointModel]:
    """Convert the waypoints of a step."""
    requested = positions([record.requested_enu_m for record in records], origin)
    sent = iter(positions([record.sent_enu_m for record in records if record.sent_enu_m is not None], origin))
    return [
        wire.WaypointModel(
            vehicle_id=record.vehicle_id,
            requested=place,
            sent=None if record.sent_enu_m is None else next(sent),
            verdict=record.verdict,
            reason=record.reason,
        )
        for record, place in zip(records, requested, strict=True)
    ]


def notice(record: model.NoticeRecord) -> wire.NoticeModel:
    """Convert a notice."""
    return wire.NoticeModel(
        severity=record.severity,
        notice_id=record.notice_id,
        text=record.text,
        vehicle_id=record.vehicle_id,
        elapsed_s=record.elapsed_s,
    )


@lru_cache(maxsize=ACKNOWLEDGEMENTS_KEPT)
def acknowledgement(given: model.Acknowledgement) -> wire.AcknowledgementModel:
    """Convert the word that somebody has taken note."""
    return wire.AcknowledgementModel(notice_id=given.notice_id, operator=given.operator, utc_s=given.utc_s)


def pictures(
    kinds: Iterable[model.PictureKind], bounds: model.Picture | model.PicturesRecord, origin: GeodeticPosition | None
) -> list[wire.PictureModel]:
    """Describe rasters of one step that share their bounds."""
    corners_enu_m = (
        (bounds.west_m, bounds.north_m),
        (bounds.east_m, bounds.north_m),
        (bounds.east_m, bounds.south_m),
        (bounds.west_m, bounds.south_m),
    )
    corners = [vertex(corner, origin) for corner in corners_enu_m]
    return [
        wire.PictureModel(
            kind=kind, step=bounds.step, url=f"/api/mission/pictures/{kind}.png?step={bounds.step}", corners=corners
        )
        for kind in kinds
    ]


def action_results(action: model.Action, results: Iterable[model.ActionResult]) -> wire.ActionResponse:
    """Convert what became of an action."""
    return wire.ActionResponse(
        action=action,
        results=[
            wire.ActionResultModel(vehicle_id=one.vehicle_id, accepted=one.accepted, text=one.text) for one in results
        ],
    )
