"""Heights above the ground that altitude layers would have if they followed it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aos_gcs.airspace.reference_surface import reference_surface
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.planning.estimate import launch_place
from aos_gcs.planning.plan import plan_of
from aos_gcs.planning.settings import MissionSettings, TerrainSettings
from aos_gcs.planning.terrain import EnuBounds, ground_within
from aos_gcs.planning.terrain_check import place_text, ways_m

CLIMB_MPS = 1.0
"""Vertical speed that ArduCopter and PX4 keep by their defaults, upwards and downwards, with a reserve."""
_MARGIN_M = 50.0


@dataclass(frozen=True, slots=True)
class FollowedHeights:
    """Heights of layers that are offset from a reference surface, over a search area and the ways to it."""

    max_slope: float
    """Greatest slope of the surface: the climb at cruise speed."""
    lowest_m: float
    """Lowest place of the surface, above the origin."""
    highest_m: float
    least_above_ground_m: float
    """Least height of the lowest layer above the ground."""
    most_above_ground_m: float
    """Greatest height of the highest layer above the ground."""
    most_at: str
    """Place of that, in words."""
    ceiling_m: float
    """Ceiling above the ground."""

    @property
    def is_below_ceiling(self) -> bool:
        """Whether all layers are everywhere below the ceiling above the ground."""
        return self.most_above_ground_m <= self.ceiling_m


def followed_heights(settings: MissionSettings, terrain: TerrainSettings) -> FollowedHeights | None:
    """Return the heights above a model that a mission's layers would have; None where no ground is known.

    Raises:
        ConfigurationError: the mission has no origin or no search area, or the model cannot be used.
        InputDataError: a file of the model cannot be used or read.
    """
    plan, origin = plan_of(settings), settings.origin
    if origin is None or not plan.area_enu_m:
        raise ConfigurationError("mission.origin_deg and the search area are needed to know the ground below them.")
    points = [point for point in (launch_place(plan), plan.return_enu_m, (0.0, 0.0)) if point is not None]
    outline_m = ways_m(plan, points)
    ground = ground_within(terrain, origin, EnuBounds.around(outline_m, _MARGIN_M))
    max_slope = CLIMB_MPS / plan.cruise_speed_mps
    # Hills that nobody flies over do not count.
    (west_m, south_m), (east_m, north_m) = outline_m.min(axis=0).tolist(), outline_m.max(axis=0).tolist()
    surface = reference_surface(ground, (west_m, south_m, east_m, north_m), max_slope)
    cells = ground.within([outline_m])
    if np.isnan(cells.highest_m).all():
        return None
    heights_m = surface.height_m(cells.places_enu_m)
    highest_layer_m = plan.lowest_layer_m + (plan.vehicles - 1) * plan.layer_spacing_m
    above_m = heights_m + highest_layer_m - cells.lowest_m
    at = int(np.nanargmax(above_m))
    return FollowedHeights(
        max_slope=max_slope,
        lowest_m=float(heights_m.min()),
        highest_m=float(heights_m.max()),
        least_above_ground_m=float(np.nanmin(heights_m + plan.lowest_layer_m - cells.highest_m)),
        most_above_ground_m=float(above_m[at]),
        most_at=place_text(LocalFrame(origin), cells.places_enu_m[at]),
        ceiling_m=terrain.ceiling_above_ground_m,
    )
