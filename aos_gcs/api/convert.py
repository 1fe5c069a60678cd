"""From the mission's dataclasses to wire models: plain functions, one per kind of data."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import lru_cache

from aos_gcs.api import models as wire
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.mission import model
from aos_gcs.mission.phases import ACTIONS

_PLACES_KEPT = 8192
"""Polygons, homes and waypoints come again with every snapshot; converting them each time would cost the loop."""


@lru_cache(maxsize=_PLACES_KEPT)
def _to_geodetic(origin: GeodeticPosition, point_enu_m: model.EnuPoint) -> GeodeticPosition:
    return LocalFrame(origin).to_geodetic(point_enu_m)


@lru_cache(maxsize=1024)
def _to_enu(origin: GeodeticPosition, position: GeodeticPosition) -> model.EnuPoint:
    east_m, north_m, up_m = LocalFrame(origin).to_enu(position)
    return float(east_m), float(north_m), float(up_m)


def finite(value: float | None) -> float | None:
    """Return the value, or ``None`` for one that JSON cannot carry."""
    return value if value is not None and math.isfinite(value) else None


def geodetic(position: GeodeticPosition) -> wire.GeodeticModel:
    """Convert a geodetic position."""
    return wire.GeodeticModel(
        latitude_deg=position.latitude_deg,
        longitude_deg=position.longitude_deg,
        altitude_amsl_m=position.altitude_amsl_m,
    )


def position(point_enu_m: model.EnuPoint, origin: GeodeticPosition | None) -> wire.PositionModel:
    """Convert an ENU point, with its place on the globe when the origin is known."""
    east_m, north_m, up_m = (float(coordinate) for coordinate in point_enu_m)
    place = _to_geodetic(origin, (east_m, north_m, up_m)) if origin else None
    return wire.PositionModel(
        east_m=east_m,
        north_m=north_m,
        up_m=up_m,
        latitude_deg=place.latitude_deg if place else None,
        longitude_deg=place.longitude_deg if place else None,
    )


def vertex(point_enu_m: tuple[float, float], origin: GeodeticPosition | None) -> wire.VertexModel:
    """Convert a corner on the ground plane."""
    full = position((*point_enu_m, 0.0), origin)
    return wire.VertexModel(
        east_m=full.east_m, north_m=full.north_m, latitude_deg=full.latitude_deg, longitude_deg=full.longitude_deg
    )


def _optional_position(
    point_enu_m: model.EnuPoint | None, origin: GeodeticPosition | None
) -> wire.PositionModel | None:
    return position(point_enu_m, origin) if point_enu_m is not None else None


def vehicle_position(vehicle: model.VehicleSnapshot) -> wire.PositionModel | None:
    """Join the ENU position with the reported degrees, which need no conversion."""
    if vehicle.position_enu_m is None:
        return None
    east_m, north_m, up_m = vehicle.position_enu_m
    reported = vehicle.telemetry.position
    return wire.PositionModel(
        east_m=east_m,
        north_m=north_m,
        up_m=up_m,
        latitude_deg=reported.latitude_deg if reported else None,
        longitude_deg=reported.longitude_deg if reported else None,
    )


def focus(state: model.FocusSnapshot) -> wire.FocusModel:
    """Convert the focal plane."""
    return wire.FocusModel(height_m=state.height_m, source=state.source, sigma_m=finite(state.sigma_m))


def vehicle(vehicle: model.VehicleSnapshot, origin: GeodeticPosition | None) -> wire.VehicleModel:
    """Convert one vehicle."""
    state = vehicle.telemetry
    heard = state.heard_at_s is not None
    velocity_enu_mps = state.velocity_enu_mps
    position_age_s = None
    if vehicle.link_age_s is not None and state.heard_at_s is not None and state.position_at_s is not None:
        position_age_s = vehicle.link_age_s + state.heard_at_s - state.position_at_s
    return wire.VehicleModel(
        vehicle_id=state.vehicle_id,
        autopilot=state.autopilot,
        mode=state.mode,
        mode_name=state.mode_name,
        task=vehicle.task,
        landed=state.landed,
        armed=state.armed if heard else None,
        ready_to_arm=state.ready_to_arm,
        position=vehicle_position(vehicle),
        position_age_s=position_age_s,
        altitude_amsl_m=state.position.altitude_amsl_m if state.position else None,
        height_above_home_m=finite(state.height_above_home_m),
        ground_speed_mps=math.hypot(*velocity_enu_mps[:2]) if velocity_enu_mps else None,
        climb_rate_mps=velocity_enu_mps[2] if velocity_enu_mps else None,
        heading_deg=math.degrees(state.heading_rad) % 360.0 if state.heading_rad is not None else None,
        home=position(_to_enu(origin, state.home), origin) if origin and state.home else None,
        battery_percent=100.0 * state.battery_fraction if state.battery_fraction is not None else None,
        battery_voltage_v=finite(state.battery_voltage_v),
        gps_fix=state.gps_fix,
        satellites=state.satellites,
        link_age_s=vehicle.link_age_s,
        packet_loss_percent=100.0 * state.packet_loss_fraction if state.packet_loss_fraction is not None else None,
        layer_height_m=vehicle.layer_height_m,
        waypoint=_optional_position(vehicle.waypoint_enu_m, origin),
        refusal=vehicle.refusal,
        text=state.text,
    )


def allowed_actions(snapshot: model.MissionSnapshot) -> list[model.Action]:
    """Return the actions worth offering: those of the phase, and resume only when something is suspended."""
    suspended = snapshot.suspension is not model.Suspension.NONE or any(
        one.task is model.Task.HELD for one in snapshot.vehicles
    )
    useless = model.Action.PAUSE if snapshot.suspension is not model.Suspension.NONE else None
    return [
        action
        for action, phases in ACTIONS.items()
        if snapshot.phase in phases and action is not useless and (suspended or action is not model.Action.RESUME)
    ]


def target(estimate: model.TargetEstimate, origin: GeodeticPosition | None) -> wire.TargetModel:
    """Convert one target."""
    ellipse, velocity_enu_mps = estimate.ellipse, estimate.velocity_enu_mps
    return wire.TargetModel(
        track_id=estimate.track_id,
        confirmed=estimate.confirmed,
        position=position(estimate.position_enu_m, origin),
        sigma_m=finite(estimate.sigma_m),
        ellipse=wire.EllipseModel(
            semi_major_m=ellipse.semi_major_m,
            semi_minor_m=ellipse.semi_minor_m,
            heading_deg=math.degrees(ellipse.heading_rad),
        )
        if ellipse
        else None,
        speed_mps=math.hypot(*velocity_enu_mps) if velocity_enu_mps else None,
        sightings=estimate.sightings,
        seen_at_s=finite(estimate.seen_at_s),
    )


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


def mission(snapshot: model.MissionSnapshot) -> wire.MissionModel:
    """Convert a whole snapshot."""
    origin = snapshot.origin
    return wire.MissionModel(
        mission_id=snapshot.mission_id,
        strategy=snapshot.strategy,
        phase=snapshot.phase,
        suspension=snapshot.suspension,
        outcome=snapshot.outcome,
        message=snapshot.message,
        elapsed_s=snapshot.elapsed_s,
        step=snapshot.step,
        origin=geodetic(origin) if origin else None,
        area=[vertex(point, origin) for point in snapshot.area_enu_m],
        fence=[vertex(point, origin) for point in snapshot.fence_enu_m],
        vehicles=[vehicle(one, origin) for one in snapshot.vehicles],
        preflight=[preflight_check(check) for check in snapshot.preflight],
        target=target(snapshot.target, origin) if snapshot.target else None,
        targets=[target(one, origin) for one in snapshot.targets],
        min_separation_m=finite(snapshot.min_separation_m),
        focus=focus(snapshot.focus) if snapshot.focus else None,
        allowed_actions=allowed_actions(snapshot),
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
        target=_optional_position(record.target_enu_m, origin),
        fitness=[wire.FitnessModel(vehicle_id=key, fitness=finite(f)) for key, f in sorted(record.fitness.items())],
        missing=[wire.MissingModel(vehicle_id=key, reason=text) for key, text in sorted(record.missing.items())],
        waypoints=[
            wire.WaypointModel(
                vehicle_id=waypoint.vehicle_id,
                requested=position(waypoint.requested_enu_m, origin),
                sent=_optional_position(waypoint.sent_enu_m, origin),
                verdict=waypoint.verdict,
                reason=waypoint.reason,
            )
            for waypoint in record.waypoints
        ],
        imaging_ms=record.imaging_ms,
        work_ms=record.work_ms,
        loop_lag_p99_ms=record.loop_lag_p99_ms,
    )


def notice(record: model.NoticeRecord) -> wire.NoticeModel:
    """Convert a notice."""
    return wire.NoticeModel(
        severity=record.severity, text=record.text, vehicle_id=record.vehicle_id, elapsed_s=record.elapsed_s
    )


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
