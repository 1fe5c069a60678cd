"""Altitude layers, and the safety limits that a flight has unless its settings say otherwise."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.polygon import Polygon, as_points, as_polygon
from aos_gcs.airspace.stopping import POSITION_ERROR_M, StoppingDistance
from aos_gcs.errors import ConfigurationError
from aos_gcs.planning.settings import MissionSettings

FloatArray = NDArray[np.float64]

FREE_GROUND_M = 30.0
"""Distance from the search area and the launch points to where the margin of the proposed geofence begins. The swarm's
line must fit: where it is wider than the area, its ends need the room."""
_LAYER_MARGIN_M = 5.0
"""Distance of the proposed floor and ceiling from the lowest and the highest altitude layer."""
_CORNERS = 16
"""Corners of the polygon that stands in for a circle around each point of a geofence."""
_SAME_POINT_M = 1e-5


def altitude_layers(n: int, lowest_m: float, spacing_m: float) -> tuple[float, ...]:
    """Return n heights above the origin, ascending, one per vehicle.

    Raises:
        ConfigurationError: n is below 1, or a height or spacing is not above 0.
    """
    if n < 1:
        raise ConfigurationError(f"n must be 1 or more, but is {n}.")
    _require_positive("lowest_m", lowest_m)
    _require_positive("spacing_m", spacing_m)
    return tuple(lowest_m + spacing_m * layer for layer in range(n))


def propose_limits(settings: MissionSettings, homes_enu_m: Sequence[FloatArray]) -> SafetyLimits:
    """Return the limits of a flight: proposed from the search area, launch points and layers, then as set.

    Args:
        settings: settings of the mission; its search area is a polygon.
        homes_enu_m: launch points of the vehicles that fly, shape (3,) each.

    Raises:
        ConfigurationError: a value that was set contradicts the proposal.
    """
    flight = settings.flight
    layers_m = altitude_layers(len(homes_enu_m), flight.lowest_layer_m, flight.layer_spacing_m)
    ground_enu_m = [home_enu_m[:2] for home_enu_m in homes_enu_m]
    if settings.return_enu_m is not None:
        ground_enu_m.append(np.array(settings.return_enu_m))
    margin_m = fence_margin_m(settings.safety.margin_m, flight.cruise_speed_mps)
    proposal = SafetyLimits(
        fence_enu_m=propose_fence(settings.area_enu_m, np.array(ground_enu_m), FREE_GROUND_M + margin_m),
        margin_m=margin_m,
        no_go_margin_m=no_go_margin_m(settings.safety.margin_m),
        floor_m=proposed_floor_m(min(layers_m)),
        ceiling_m=proposed_ceiling_m(max(layers_m)),
    )
    return settings.safety.applied_to(proposal)


def proposed_floor_m(lowest_layer_m: float) -> float:
    """Return the floor that is proposed below the lowest altitude layer."""
    return lowest_layer_m - _LAYER_MARGIN_M


def proposed_ceiling_m(highest_layer_m: float) -> float:
    """Return the ceiling that is proposed above the highest altitude layer."""
    return highest_layer_m + _LAYER_MARGIN_M


def fence_margin_m(given_m: float | None, cruise_speed_mps: float) -> float:
    """Return the margin that is kept from the geofence: the given one, or else the stopping distance."""
    return StoppingDistance(cruise_speed_mps).total_m if given_m is None else given_m


def no_go_margin_m(fence_margin_m: float | None) -> float | None:
    """Return the margin that is proposed for no-go zones; None: the margin of the geofence, which was given.

    Zones are drawn with the distance that is wanted, and vehicles approach them by the short segments of a scan: the
    stopping distance is not kept. Without any margin a vehicle that hovers at the edge of an uploaded zone would cross
    it by the error of its position alone, and its autopilot would return, or refuse its next waypoint.
    """
    return POSITION_ERROR_M if fence_margin_m is None else None


def propose_fence(
    area_enu_m: Sequence[Sequence[float]], ground_enu_m: Sequence[Sequence[float]] | FloatArray, margin_m: float
) -> Polygon:
    """Return the convex hull of the search area and some points, grown by at least ``margin_m``, counter-clockwise.

    Args:
        area_enu_m: simple polygon, shape (m, 2), metres.
        ground_enu_m: where vehicles start and land, shape (k, 2), metres; may be empty.
        margin_m: above 0.

    Raises:
        ConfigurationError: the area is no simple polygon, a point is not finite, or the margin is not above 0.
    """
    _require_positive("margin_m", margin_m)
    ground_m = np.array(ground_enu_m, dtype=np.float64).reshape(-1, 2)
    if not np.isfinite(ground_m).all():
        raise ConfigurationError("ground_enu_m must be finite positions in metres.")
    points_m = np.vstack([as_polygon(area_enu_m, "area_enu_m"), ground_m])
    # Corners outside the circle make the polygon around it, so that no side is closer than the margin.
    angles_rad = 2.0 * np.pi * np.arange(_CORNERS) / _CORNERS
    corners_m = margin_m / math.cos(math.pi / _CORNERS) * np.column_stack([np.cos(angles_rad), np.sin(angles_rad)])
    grown_m = (points_m[:, None] + corners_m[None]).reshape(-1, 2)
    hull_m = grown_m[scipy.spatial.ConvexHull(grown_m).vertices]
    # Points that all but coincide, such as a launch point at a corner of the area, give edges that all but touch.
    is_apart = np.linalg.norm(hull_m - np.roll(hull_m, 1, axis=0), axis=1) > _SAME_POINT_M
    return as_points(hull_m[is_apart])


def _require_positive(field: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise ConfigurationError(f"{field} must be a finite number above 0, but is {value}.")
