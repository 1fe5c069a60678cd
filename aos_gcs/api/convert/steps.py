"""Conversion of steps, with their waypoints and rasters."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.api.convert.places import finite, optional_position, positions, vertex
from aos_gcs.api.models.steps import (
    FitnessModel,
    MissingModel,
    PictureModel,
    StepFiguresModel,
    StepModel,
    WaypointModel,
)
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.mission.model.events import PicturesRecord
from aos_gcs.mission.model.steps import Picture, PictureKind, StepRecord


def step(record: StepRecord, origin: GeodeticPosition | None) -> StepModel:
    """Convert a step."""
    return StepModel(
        **dict(step_figures(record)),
        target=optional_position(record.target_enu_m, origin),
        fitness=[FitnessModel(vehicle_id=key, fitness=finite(f)) for key, f in sorted(record.fitness.items())],
        missing=[MissingModel(vehicle_id=key, reason=text) for key, text in sorted(record.missing.items())],
        waypoints=waypoints(record.waypoints, origin),
    )


def step_figures(record: StepRecord) -> StepFiguresModel:
    """Convert the figures of a step."""
    return StepFiguresModel(
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
        imaging_ms=record.imaging_ms,
        work_ms=record.work_ms,
        loop_lag_p99_ms=record.loop_lag_p99_ms,
    )


def waypoints(records: Sequence[WaypointRecord], origin: GeodeticPosition | None) -> list[WaypointModel]:
    """Convert the waypoints of a step."""
    requested = positions([record.requested_enu_m for record in records], origin)
    sent = iter(positions([record.sent_enu_m for record in records if record.sent_enu_m is not None], origin))
    return [
        WaypointModel(
            vehicle_id=record.vehicle_id,
            requested=place,
            sent=None if record.sent_enu_m is None else next(sent),
            verdict=record.verdict,
            reason=record.reason,
        )
        for record, place in zip(records, requested, strict=True)
    ]


def pictures(
    kinds: Iterable[PictureKind], bounds: Picture | PicturesRecord, origin: GeodeticPosition | None, seq: int
) -> list[PictureModel]:
    """Describe rasters of one step that share their bounds.

    Args:
        kinds: kinds of the rasters.
        bounds: their step and bounds.
        origin: origin of the mission's frame.
        seq: number of the event that announced them: each picture of a step that has several has its own address.
    """
    corners_enu_m = (
        (bounds.west_m, bounds.north_m),
        (bounds.east_m, bounds.north_m),
        (bounds.east_m, bounds.south_m),
        (bounds.west_m, bounds.south_m),
    )
    corners = [vertex(corner, origin) for corner in corners_enu_m]
    return [
        PictureModel(
            kind=kind,
            step=bounds.step,
            url=f"/api/mission/pictures/{kind}.png?step={bounds.step}&seq={seq}",
            corners=corners,
        )
        for kind in kinds
    ]
