"""Views that a search along legs will give each place, and the probability of detection that follows from them.

The exposures of all vehicles are laid out along the legs, and their directions are counted at places of the search area
as the map of searched ground counts them (:mod:`aos_gcs.groundmap.directions`). Frames are expected at the rate that is
set, from cameras that look straight down and are turned with the leg; zones where no vehicle flies give none. Over
relief each place is seen from as far above as it lies below the layers, and not at all where the ground is not known.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.polygon import Polygon
from aos_gcs.airspace.raster import PlanRaster
from aos_gcs.groundmap.detection import DETECTABILITY, Posture, detection_by_views
from aos_gcs.groundmap.directions import ViewDirections, direction_step
from aos_gcs.groundmap.figures import DetectionFigures
from aos_gcs.groundmap.tile import MAX_VIEWS
from aos_gcs.planning.detection.mixed_line import mixed_layers
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.proposal import altitude_layers
from aos_gcs.planning.search_settings import SearchMode
from aos_gcs.planning.settings import ForestSettings
from aos_gcs.planning.terrain.viewed_ground import LEVEL_GROUND, ViewedGround
from aos_gcs.swarm.line import line_axis

FloatArray = NDArray[np.float64]

PLACES: Final = 1500
"""Places of an area at which views are counted: the mean over them errs by about a hundredth."""
MOST_EXPOSURES: Final = 50_000_000
"""Greatest number of exposures of places, each of one place by one camera, that a plan may have counted: about eight
seconds of a processor. A line of 250 vehicles at the usual speed and frame rate has fewer on a square kilometre."""
_CHUNK: Final = 500
"""Places that are counted at once: 2 MB of directions."""
_MOST_AT_ONCE: Final = 1_000_000
"""Exposures that one camera has of the places that are counted at once, at most: some 100 MB."""
_SAME_WAY = 1e-6
"""Cosine between legs below which they do not run against each other."""
_PLASTIC = 1.324717957244746
"""The plastic number: its powers spread places evenly over a plane, in no line with any legs."""


@dataclass(frozen=True, slots=True, eq=False)
class LineOfCameras:
    """A swarm's line on the legs."""

    aside_m: FloatArray
    """Place of each vehicle along the line, from its middle, shape (n,)."""
    heights_m: FloatArray
    """Height of each above the focal plane, where the ground is level with the origin, shape (n,), on the first leg."""
    half_view: float
    """Tangent of half the field of view."""
    interval_m: float
    """Distance between two exposures of a camera along the leg."""
    direction_enu: tuple[float, float] = (0.0, 1.0)
    """Unit vector along the first leg."""

    def heights_on_m(self, leg: ScanLeg) -> FloatArray:
        """Return the height of each place of the line on a leg, shape (n,).

        Vehicles keep their order over the ground, so that on the way back it is reversed along the line.
        """
        is_back = float(np.dot(self.direction_enu, leg.direction_enu)) < -_SAME_WAY
        return self.heights_m[::-1] if is_back else self.heights_m


def line_of(plan: MissionPlan, plane_height_m: float) -> LineOfCameras:
    """Return the line in which a plan flies its legs."""
    n = plan.vehicles
    heights_m = np.array(altitude_layers(n, plan.lowest_layer_m - plane_height_m, plan.layer_spacing_m))
    return LineOfCameras(
        aside_m=np.asarray(plan.on_legs_m * (np.arange(n) - (n - 1) / 2.0), dtype=np.float64),
        # Without a wanted probability layers are as the launch points have them: taken to ascend along the line.
        heights_m=heights_m if plan.pod is None else heights_m[mixed_layers(n)],
        half_view=math.tan(plan.camera_fov_rad / 2.0),
        interval_m=plan.leg_speed_mps / plan.rate_hz,
        direction_enu=(math.sin(plan.scan_heading_rad), math.cos(plan.scan_heading_rad)),
    )


def exposures_of_places(plan: MissionPlan, plane_height_m: float, legs: int, places: int = PLACES) -> float:
    """Return about how many exposures of places have to be counted for a plan's views: cheap, however many they are.

    Args:
        plan: its shapes and numbers are valid.
        plane_height_m: height of the focal plane above the origin.
        legs: number of its legs in all passes.
        places: number of places.
    """
    line = line_of(plan, plane_height_m)
    direction = np.array([math.sin(plan.scan_heading_rad), math.cos(plan.scan_heading_rad)])
    corners_m = np.array(plan.area_enu_m) @ np.column_stack((direction, line_axis(direction)))
    along_m, across_m = np.maximum(np.ptp(corners_m, axis=0), 1e-3)
    views_m = 2.0 * line.heights_m * line.half_view
    exposures = np.minimum(views_m, along_m) / line.interval_m + 1.0
    return float(legs * places * (np.minimum(1.0, views_m / across_m) * exposures).sum())


def forest_directions(forest: ForestSettings) -> ViewDirections:
    """Return the squares of directions by which views of a forest are counted."""
    return ViewDirections(direction_step(forest.crown_base_m, forest.canopy_height_m, forest.occluder_size_m))


def predicted_detection(
    plan: MissionPlan,
    legs: Sequence[ScanLeg],
    plane_height_m: float,
    places: int = PLACES,
    ground: ViewedGround = LEVEL_GROUND,
) -> DetectionFigures | None:
    """Return the mean probability of detection over the search area that a plan's legs reach.

    Args:
        plan: to be flown.
        legs: its legs.
        plane_height_m: height of the focal plane above the ground.
        places: number of places of the area's bounding box that are looked at.
        ground: ground of the area, below the layers.

    Returns:
        None where the forest is not described, or the swarm stops for each frame.
    """
    if plan.forest is None or plan.search_mode is not SearchMode.CONTINUOUS:
        return None
    places_m = spread_places(plan.area_enu_m, places)
    directions = forest_directions(plan.forest)
    views = expected_views(places_m, legs, line_of(plan, plane_height_m), directions, plan.no_go_enu_m, ground=ground)
    shares = np.bincount(views, minlength=MAX_VIEWS + 1) / max(1, len(views))
    occlusion = plan.forest.occlusion
    return DetectionFigures(
        **{str(one): float(shares @ detection_by_views(occlusion, DETECTABILITY[one])) for one in Posture}
    )


def spread_places(area_enu_m: Polygon, count: int) -> FloatArray:
    """Return places spread evenly over an area, shape (k, 2): those of ``count`` over its bounding box."""
    raster = PlanRaster.around(area_enu_m)
    fractions = np.mod(0.5 + np.arange(count)[:, np.newaxis] / np.array([_PLASTIC, _PLASTIC**2]), 1.0)
    rows, columns = raster.shape
    inside = raster.inside([area_enu_m])[
        (fractions[:, 1] * rows).astype(np.int64), (fractions[:, 0] * columns).astype(np.int64)
    ]
    east_m = raster.west_m + fractions[:, 0] * columns * raster.resolution_m
    north_m = raster.north_m - fractions[:, 1] * rows * raster.resolution_m
    return np.asarray(np.column_stack((east_m, north_m))[inside], dtype=np.float64)


def expected_views(
    places_enu_m: FloatArray,
    legs: Sequence[ScanLeg],
    line: LineOfCameras,
    directions: ViewDirections,
    no_go_enu_m: Sequence[Polygon] = (),
    *,
    ground: ViewedGround = LEVEL_GROUND,
) -> NDArray[np.int64]:
    """Return the number of independent views of each place after all legs, at most ``MAX_VIEWS``, shape (k,).

    Args:
        places_enu_m: places on the ground, shape (k, 2).
        legs: legs that the line flies.
        line: the swarm's line.
        directions: squares of directions.
        no_go_enu_m: zones above which nothing is exposed.
        ground: ground below the layers.
    """
    views = np.zeros(len(places_enu_m), dtype=np.int64)
    size = _places_at_once(places_enu_m, legs, line, ground)
    for first in range(0, len(places_enu_m), size):
        chunk_m = places_enu_m[first : first + size]
        cells_at_m = np.column_stack((chunk_m, ground.ground.height_m(chunk_m)))
        seen = np.zeros((len(chunk_m), directions.side**2), dtype=np.bool_)
        for leg in legs:
            for place, cameras_m in _exposures(cells_at_m, leg, line, no_go_enu_m, ground):
                cells_m = cells_at_m[place]
                # Directions depend on differences alone.
                squares, counted = directions.squares(np.zeros(3), cells_m - cameras_m)
                seen[place[counted], squares[counted]] = True
        views[first : first + size] = seen.sum(axis=1)
    return np.minimum(views, MAX_VIEWS)


def _places_at_once(
    places_enu_m: FloatArray, legs: Sequence[ScanLeg], line: LineOfCameras, ground: ViewedGround
) -> int:
    """Return for how many places the exposures of a camera fit into memory."""
    lowest_m = ground.ground.height_m(places_enu_m)
    deepest_m = ground.layers.highest_m - float(lowest_m[np.isfinite(lowest_m)].min(initial=0.0))
    views_m = 2.0 * (float(line.heights_m.max()) + deepest_m) * line.half_view
    longest_m = max((leg.length_m for leg in legs), default=0.0)
    return int(np.clip(_MOST_AT_ONCE / (min(views_m, longest_m) / line.interval_m + 1.0), 1, _CHUNK))


def _exposures(
    cells_m: FloatArray, leg: ScanLeg, line: LineOfCameras, no_go_enu_m: Sequence[Polygon], ground: ViewedGround
) -> Iterator[tuple[NDArray[np.int64], FloatArray]]:
    """Yield per vehicle the cells, shape (k,), that its exposures on a leg show, and the cameras' places, shape (k, 3).

    Cells that are not known, with NaN for their height, are in none.
    """
    along, start_m = np.array(leg.direction_enu), np.array(leg.start_enu_m)
    across = line_axis(along)
    along_m, across_m = (cells_m[:, :2] - start_m) @ along, (cells_m[:, :2] - start_m) @ across
    # What cameras may see at most, from above the highest place of the layers; narrowed down below.
    depths_m = ground.layers.highest_m - cells_m[:, 2]
    last = math.floor(leg.length_m / line.interval_m)
    for aside_m, height_m in zip(line.aside_m.tolist(), line.heights_on_m(leg).tolist(), strict=True):
        reaches_m = (height_m + depths_m) * line.half_view
        (near,) = np.nonzero(np.abs(across_m - aside_m) <= reaches_m)
        reach_m = reaches_m[near]
        first_shown = np.ceil((along_m[near] - reach_m) / line.interval_m).clip(0.0).astype(np.int64)
        last_shown = np.floor((along_m[near] + reach_m) / line.interval_m).clip(max=last).astype(np.int64)
        counts = np.maximum(last_shown - first_shown + 1, 0)
        place = np.repeat(near, counts)
        exposure = np.arange(len(place)) - np.repeat(np.cumsum(counts) - counts - first_shown, counts)
        cameras_m = np.full((len(place), 3), height_m)
        cameras_m[:, :2] = start_m + aside_m * across + (exposure * line.interval_m)[:, np.newaxis] * along
        flown = np.ones(len(place), dtype=np.bool_)
        cameras_m[:, 2] += ground.layers.height_m(cameras_m[:, :2])
        if not ground.layers.is_level:
            away_m = np.maximum(np.abs(exposure * line.interval_m - along_m[place]), np.abs(across_m[place] - aside_m))
            flown &= away_m <= (cameras_m[:, 2] - cells_m[place, 2]) * line.half_view
        for zone_enu_m in no_go_enu_m:
            flown &= ~_within(cameras_m[:, :2], zone_enu_m)
        yield place[flown], cameras_m[flown]


def _within(points_m: FloatArray, polygon_enu_m: Polygon) -> NDArray[np.bool_]:
    """Return which points, shape (k, 2), lie in a polygon, by the number of edges that lie west of each."""
    inside = np.zeros(len(points_m), dtype=np.bool_)
    corners_m = np.array(polygon_enu_m, dtype=np.float64)
    for (x_0, y_0), (x_1, y_1) in zip(corners_m, np.roll(corners_m, -1, axis=0), strict=True):
        crossed = (y_0 <= points_m[:, 1]) != (y_1 <= points_m[:, 1])
        if crossed.any():
            at = x_0 + (points_m[crossed, 1] - y_0) * (x_1 - x_0) / (y_1 - y_0)
            inside[crossed] ^= at < points_m[crossed, 0]
    return inside
