"""Heights of photographs above the terrain below them, against those above their place of takeoff."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from aos_gcs.geometry.heights import SEA_LEVEL, AmslM
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.surveys.model import Survey
from aos_gcs.surveys.takeoffs import TakeoffSite


@dataclass(frozen=True, slots=True)
class FlownHeights:
    """Heights at which the photographs of one takeoff were taken, medians in metres."""

    above_terrain_m: float
    above_takeoff_m: float
    excess_m: float
    """Height of the place of takeoff above the terrain below the cameras: what the terrain has to be raised by."""
    takeoff_amsl_m: AmslM
    first_name: str
    """Name of the first of the photographs."""


def flown_heights(survey: Survey, terrain: Terrain) -> Iterator[FlownHeights]:
    """Yield the heights of each takeoff whose photographs tell them, and below some of which the terrain is known."""
    everything = TakeoffSite(SEA_LEVEL, tuple(range(len(survey.images))))
    for takeoff in survey.takeoffs or (everything,):
        images = [survey.images[index] for index in takeoff.photographs]
        told = [(one, one.relative_altitude_m) for one in images if one.relative_altitude_m is not None]
        if not told:
            continue
        above_takeoff_m = np.array([height_m for _, height_m in told])
        x_m, y_m, z_m = np.array([image.pose.position_enu_m for image, _ in told]).T
        above_terrain_m = z_m - terrain.z_m(x_m, y_m)
        known = np.isfinite(above_terrain_m)
        if known.any():
            yield FlownHeights(
                float(np.median(above_terrain_m[known])),
                float(np.median(above_takeoff_m[known])),
                float(np.median((above_terrain_m - above_takeoff_m)[known])),
                takeoff.altitude_amsl_m,
                images[0].path.name,
            )
