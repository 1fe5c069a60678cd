"""Heights above the ground of altitude layers that follow it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from aos_gcs.airspace.reference_surface import ReferenceSurface
from aos_gcs.airspace.terrain import GroundRaster
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.planning.checks.sites import planned_boundaries
from aos_gcs.planning.estimate import launch_place
from aos_gcs.planning.plan import MissionPlan, plan_of
from aos_gcs.planning.settings import MissionSettings, TerrainSettings
from aos_gcs.planning.terrain.check import place_text, ways_m
from aos_gcs.planning.terrain.ground import ground_in_fence
from aos_gcs.planning.terrain.layer_surface import followed_surface, max_slope


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
    """Return the heights above a model that layers have that follow it; None where no ground is known.

    Raises:
        ConfigurationError: the mission has no origin or no search area, or the model cannot be used.
        InputDataError: a file of the model cannot be used or read.
    """
    origin = settings.origin
    if origin is None or not settings.area_enu_m:
        raise ConfigurationError("mission.origin_deg and the search area are needed to know the ground below them.")
    plan = plan_of(settings)
    plan = replace(plan, launch_enu_m=launch_place(plan))
    limits = planned_boundaries(plan, {})
    ground = ground_in_fence(terrain, origin, limits)
    surface = followed_surface(ground, limits, plan.cruise_speed_mps)
    points = [point for point in (plan.launch_enu_m, plan.return_enu_m) if point is not None]
    cells = ground.within([ways_m(plan, points)])
    if np.isnan(cells.highest_m).all():
        return None
    heights_m = surface.height_m(cells.places_enu_m)
    above_m = heights_m + plan.highest_layer_m - cells.lowest_m
    at = int(np.nanargmax(above_m))
    return FollowedHeights(
        max_slope=max_slope(plan.cruise_speed_mps),
        lowest_m=float(heights_m.min()),
        highest_m=float(heights_m.max()),
        least_above_ground_m=float(np.nanmin(heights_m + plan.lowest_layer_m - cells.highest_m)),
        most_above_ground_m=float(above_m[at]),
        most_at=place_text(LocalFrame(origin), cells.places_enu_m[at]),
        ceiling_m=terrain.ceiling_above_ground_m,
    )


def highest_return(
    plan: MissionPlan,
    points_enu_m: Sequence[tuple[float, float]],
    ground: GroundRaster,
    surface: ReferenceSurface,
    frame: LocalFrame,
) -> tuple[float, str] | None:
    """Return how far above the ground autopilots return by themselves at most, and where; None where none is known.

    They return at their layers above the highest place of the surface, wherever they are.
    """
    cells = ground.within([ways_m(plan, points_enu_m)])
    if np.isnan(cells.lowest_m).all():
        return None
    at = int(np.nanargmin(cells.lowest_m))
    return surface.highest_m + plan.highest_layer_m - float(cells.lowest_m[at]), place_text(
        frame, cells.places_enu_m[at]
    )
