"""Conversion of targets and findings."""

from __future__ import annotations

import math
from collections.abc import Callable

from aos_gcs.api.convert.places import finite, position, rounded, vertex
from aos_gcs.api.models.findings import EllipseModel, FindingModel, LeftPlaceModel, TargetModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.notations import dms, mgrs_text, utm_text
from aos_gcs.mission.model.decisions import LeftPlace
from aos_gcs.mission.model.findings import ErrorEllipse, Finding, TargetEstimate


def ellipse(error: ErrorEllipse) -> EllipseModel:
    """Convert an error ellipse."""
    return EllipseModel(
        semi_major_m=error.semi_major_m,
        semi_minor_m=error.semi_minor_m,
        heading_deg=math.degrees(error.heading_rad),
    )


def target(estimate: TargetEstimate, origin: GeodeticPosition | None) -> TargetModel:
    """Convert one target."""
    velocity_enu_mps = estimate.velocity_enu_mps
    return TargetModel(
        track_id=estimate.track_id,
        confirmed=estimate.confirmed,
        position=position(estimate.position_enu_m, origin),
        sigma_m=finite(estimate.sigma_m),
        ellipse=ellipse(estimate.ellipse) if estimate.ellipse else None,
        speed_mps=math.hypot(*velocity_enu_mps) if velocity_enu_mps else None,
        sightings=estimate.sightings,
        seen_at_s=finite(estimate.seen_at_s),
        person_confidence=estimate.person_confidence,
        kind=estimate.kind,
        reasons=list(estimate.reasons),
    )


def left_place(place: LeftPlace, origin: GeodeticPosition | None) -> LeftPlaceModel:
    """Convert a place that is left for a later look."""
    return LeftPlaceModel(position=vertex(place.place_enu_m, origin), person_confidence=round(place.probability, 3))


def finding(found: Finding, origin: GeodeticPosition | None) -> FindingModel:
    """Convert one finding, its place in all notations."""
    place = position(found.position_enu_m, origin)
    at_deg = (place.latitude_deg, place.longitude_deg)
    return FindingModel(
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
        kind=found.kind,
        reasons=list(found.reasons),
        significance=rounded(found.significance, 1),
        track_id=found.track_id,
        found_at_s=round(found.found_at_s, 1),
        seen_at_s=round(found.seen_at_s, 1),
        step=found.step,
        comment=found.comment,
        assignee=found.assignee,
        operator=found.operator,
        merged_into=found.merged_into,
        found_in=found.found_in,
    )


def _written(
    notation: Callable[[float, float], str | None], latitude_deg: float | None, longitude_deg: float | None
) -> str | None:
    return None if latitude_deg is None or longitude_deg is None else notation(latitude_deg, longitude_deg)
