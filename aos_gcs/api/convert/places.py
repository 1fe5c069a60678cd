"""Points of the mission's frame on the wire: metres, and degrees beside them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from aos_gcs.api.models.base import GeodeticModel, PositionModel, ScanLegModel, VertexModel
from aos_gcs.geometry.geodesy import EnuPoint, GeodeticPosition, LocalFrame


def finite(value: float | None) -> float | None:
    """Return the value, or ``None`` for one that JSON cannot carry."""
    return value if value is not None and math.isfinite(value) else None


def rounded(value: float | None, digits: int) -> float | None:
    """Return a finite value to as many decimals as mean something: shorter text, and fewer changes to send."""
    return round(value, digits) if value is not None and math.isfinite(value) else None


def percent(fraction: float | None) -> float | None:
    """Return a share in per cent."""
    return None if fraction is None else round(100.0 * fraction, 1)


def geodetic(position: GeodeticPosition) -> GeodeticModel:
    """Convert a geodetic position."""
    return GeodeticModel(
        latitude_deg=position.latitude_deg,
        longitude_deg=position.longitude_deg,
        altitude_amsl_m=position.altitude_amsl_m,
    )


def position(point_enu_m: EnuPoint, origin: GeodeticPosition | None) -> PositionModel:
    """Convert an ENU point, with its place on the globe when the origin is known."""
    east_m, north_m, up_m = (float(coordinate) for coordinate in point_enu_m)
    place = LocalFrame(origin).to_geodetic((east_m, north_m, up_m)) if origin else None
    return place_model((east_m, north_m, up_m), place)


def positions(points_enu_m: Sequence[EnuPoint], origin: GeodeticPosition | None) -> list[PositionModel]:
    """Convert many ENU points at once."""
    return [position(point_enu_m, origin) for point_enu_m in points_enu_m]


def place_model(point_enu_m: EnuPoint, place: GeodeticPosition | None) -> PositionModel:
    """Join a point in both frames, to the centimetre."""
    east_m, north_m, up_m = point_enu_m
    return PositionModel(
        east_m=round(east_m, 2),
        north_m=round(north_m, 2),
        up_m=round(up_m, 2),
        latitude_deg=round(place.latitude_deg, 7) if place else None,
        longitude_deg=round(place.longitude_deg, 7) if place else None,
    )


def vertex(point_enu_m: tuple[float, float], origin: GeodeticPosition | None) -> VertexModel:
    """Convert a corner on the ground plane."""
    return _on_ground(position((*point_enu_m, 0.0), origin))


def vertices(points_enu_m: Sequence[tuple[float, float]], origin: GeodeticPosition | None) -> list[VertexModel]:
    """Convert corners on the ground plane at once, which is much faster than one by one."""
    return [_on_ground(full) for full in positions([(*point_enu_m, 0.0) for point_enu_m in points_enu_m], origin)]


def _on_ground(full: PositionModel) -> VertexModel:
    return VertexModel(
        east_m=full.east_m, north_m=full.north_m, latitude_deg=full.latitude_deg, longitude_deg=full.longitude_deg
    )


def scan_leg(
    start_enu_m: tuple[float, float], end_enu_m: tuple[float, float], origin: GeodeticPosition | None
) -> ScanLegModel:
    """Convert one sweep of the swarm."""
    return ScanLegModel(start=vertex(start_enu_m, origin), end=vertex(end_enu_m, origin))


def optional_position(point_enu_m: EnuPoint | None, origin: GeodeticPosition | None) -> PositionModel | None:
    """Convert an ENU point that may be unknown."""
    return position(point_enu_m, origin) if point_enu_m is not None else None
