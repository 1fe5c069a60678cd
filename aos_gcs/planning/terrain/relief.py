"""The relief about a mission for people: the shading of its slopes, and lines of equal height."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.extras import load_extra
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.planning.settings import TerrainSettings
from aos_gcs.planning.terrain.ground import EnuBounds, read_ground

FloatArray = NDArray[np.float64]

MAX_SIDE_CELLS: Final = 768
"""Greatest number of cells along one side of a relief."""
MAX_POINTS: Final = 40_000
"""Greatest number of points of all contour lines together."""

_FINEST_CELL_M = 2.0
_ABOUT_M = 400.0
"""Width of the strip about a mission that its relief shows."""
_LEAST_HALF_M = 800.0
"""Distance from the origin that a relief shows, also where nothing is planned yet."""
_GREATEST_HALF_M = 6000.0
"""Distance from the origin beyond which nothing is planned."""
_EARTH_RADIUS_M = 6.371e6
_MOST_LINES = 100
"""Number of heights that contour lines are drawn at, at most; maps leave most of them out when they show much."""
_SUN_AZIMUTH_RAD = math.radians(315.0)
_SUN_HEIGHT_RAD = math.radians(45.0)
_EXAGGERATION = 3.0
"""Factor of the heights in the shading, so that gentle slopes are seen."""
_DARKEST, _BRIGHTEST = 0.5, 0.4
"""Opacity of the darkest shadow, and of the brightest light."""


class HeightUnit(StrEnum):
    """Unit in which the heights of contour lines are round numbers."""

    METRE = "m"
    FOOT = "ft"


_INTERVALS: Final[Mapping[HeightUnit, Sequence[int]]] = {
    HeightUnit.METRE: (1, 2, 5, 10, 20, 50, 100, 200, 500),
    HeightUnit.FOOT: (5, 10, 20, 50, 100, 200, 500, 1000, 2000),
}
_METRES: Final[Mapping[HeightUnit, float]] = {HeightUnit.METRE: 1.0, HeightUnit.FOOT: 0.3048}


@dataclass(frozen=True, eq=False)
class Relief:
    """Heights of the ground at the nodes of a grid."""

    bounds: EnuBounds
    heights_amsl_m: NDArray[np.float32]
    """Heights above mean sea level, shape (rows, columns); row 0 is the northern one. NaN where they are not known."""

    @property
    def cell_m(self) -> tuple[float, float]:
        """Distance of neighbouring nodes towards north and towards east."""
        rows, columns = self.heights_amsl_m.shape
        bounds = self.bounds
        return (bounds.north_m - bounds.south_m) / (rows - 1), (bounds.east_m - bounds.west_m) / (columns - 1)


@dataclass(frozen=True, slots=True)
class Contour:
    """One line of equal height."""

    altitude_amsl_m: float
    points_enu_m: FloatArray
    """Shape (n, 2)."""


@dataclass(frozen=True, slots=True)
class Contours:
    """All contour lines of a relief, few enough to be sent at once."""

    interval_m: float
    spacing_m: float
    """Mean distance between neighbouring lines on the map; the relief's longer side where there is none."""
    lines: tuple[Contour, ...]


def relief_bounds(places_enu_m: Sequence[tuple[float, float]]) -> EnuBounds:
    """Return the rectangle whose relief is shown for a mission with these places; the origin is always in it."""
    corners = [(-_LEAST_HALF_M, -_LEAST_HALF_M), (_LEAST_HALF_M, _LEAST_HALF_M)]
    places_m = np.array(places_enu_m, dtype=np.float64).reshape(-1, 2)
    bounds = EnuBounds.around(np.vstack((corners, places_m - _ABOUT_M, places_m + _ABOUT_M)), 0.0)
    most_m = _GREATEST_HALF_M
    return EnuBounds(
        max(-most_m, bounds.west_m),
        max(-most_m, bounds.south_m),
        min(most_m, bounds.east_m),
        min(most_m, bounds.north_m),
    )


def read_relief(settings: TerrainSettings, origin: GeodeticPosition, bounds: EnuBounds) -> Relief:
    """Return the relief within a rectangle, from the elevation model's files.

    Raises:
        ConfigurationError: a setting cannot be used, or a library is missing.
        InputDataError: a file cannot be used or read, or has no height there.
    """
    ground = read_ground(settings, origin, bounds)
    sides_m = bounds.north_m - bounds.south_m, bounds.east_m - bounds.west_m
    cell_m = max(_FINEST_CELL_M, max(sides_m) / (MAX_SIDE_CELLS - 1))
    rows, columns = (int(side_m / cell_m) + 1 for side_m in sides_m)
    north_m, east_m = (
        np.linspace(bounds.north_m, bounds.south_m, rows),
        np.linspace(bounds.west_m, bounds.east_m, columns),
    )
    heights_m = np.empty((rows, columns), dtype=np.float32)
    middle = (ground.lowest_m + ground.highest_m) / np.float32(2.0)
    for row, north in enumerate(north_m):
        cells = ground.to_cells.at(np.column_stack((east_m, np.full(columns, north))))
        # The centres of the raster's cells have whole coordinates in OpenCV.
        rows_of_raster, columns_of_raster = (cells[None, :, axis].astype(np.float32) - 0.5 for axis in (0, 1))
        line_m = cv2.remap(
            middle,
            columns_of_raster,
            rows_of_raster,
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=math.nan,
        )
        # From heights above the local frame's plane to heights above the level surface through its origin.
        above_plane_m = (east_m**2 + north**2) / (2.0 * _EARTH_RADIUS_M)
        heights_m[row] = line_m[0] - cells[:, 2] + above_plane_m
    if np.isnan(heights_m).all():
        raise InputDataError(f"{', '.join(settings.files)}: the elevation model has no heights about the mission.")
    return Relief(bounds, heights_m + np.float32(origin.altitude_amsl_m))


def shading_png(relief: Relief) -> bytes:
    """Return the shading of a relief lit from the north-west as a picture: black in the shade, white in the light.

    Level ground, and ground whose height is not known, is transparent.
    """
    north_m, east_m = relief.cell_m
    to_south, to_east = np.gradient(_EXAGGERATION * relief.heights_amsl_m, north_m, east_m)
    # The light that falls on a slope: the cosine between its normal (-dz/de, -dz/dn, 1) and the sun.
    sun_east = math.cos(_SUN_HEIGHT_RAD) * math.sin(_SUN_AZIMUTH_RAD)
    sun_north = math.cos(_SUN_HEIGHT_RAD) * math.cos(_SUN_AZIMUTH_RAD)
    level = math.sin(_SUN_HEIGHT_RAD)
    light = (level - to_east * sun_east + to_south * sun_north) / np.sqrt(1.0 + to_east**2 + to_south**2)
    brighter = np.nan_to_num(np.maximum(light, 0.0) - level)
    opacity = np.where(brighter < 0.0, -brighter / level * _DARKEST, brighter / (1.0 - level) * _BRIGHTEST)
    # In steps of 4, which nobody sees and which halve the file.
    alpha = (np.round(255.0 * opacity / 4.0) * 4.0).clip(0.0, 255.0).astype(np.uint8)
    white = np.where(brighter < 0.0, 0, 255).astype(np.uint8)
    return cv2.imencode(".png", cv2.merge((white, white, white, alpha)))[1].tobytes()


def contours(relief: Relief, unit: HeightUnit = HeightUnit.METRE) -> Contours:
    """Return the contour lines of a relief, at the smallest interval of which there are not too many.

    Args:
        relief: heights.
        unit: unit in which the interval, and with it each height, is a round number.

    Raises:
        ConfigurationError: a library is missing.
    """
    heights_m = relief.heights_amsl_m
    least_m, most_m = float(np.nanmin(heights_m)), float(np.nanmax(heights_m))
    for interval in _INTERVALS[unit]:
        interval_m = interval * _METRES[unit]
        if (most_m - least_m) / interval_m > _MOST_LINES and interval != _INTERVALS[unit][-1]:
            continue
        numbers = np.arange(math.ceil(least_m / interval_m), math.floor(most_m / interval_m) + 1)
        lines = tuple(_lines(relief, (interval_m * numbers).tolist()))
        if sum(len(line.points_enu_m) for line in lines) <= MAX_POINTS:
            break
    else:
        lines = ()
    return Contours(interval_m, _spacing_m(relief, lines), lines)


def _spacing_m(relief: Relief, lines: Sequence[Contour]) -> float:
    """Return the known area per length of the lines: the distance between them if they were evenly spread."""
    bounds = relief.bounds
    wide_m, high_m = bounds.east_m - bounds.west_m, bounds.north_m - bounds.south_m
    area_m2 = wide_m * high_m * float(np.isfinite(relief.heights_amsl_m).mean())
    length_m = sum(float(np.hypot(*np.diff(line.points_enu_m, axis=0).T).sum()) for line in lines)
    return min(max(wide_m, high_m), area_m2 / max(length_m, 1.0))


def _lines(relief: Relief, levels_m: Sequence[float]) -> Iterator[Contour]:
    """Yield the lines at some heights, without points that they do not need."""
    contourpy: Any = load_extra("contourpy", "geo", "Drawing contour lines")
    bounds, heights_m = relief.bounds, relief.heights_amsl_m[::-1]
    rows, columns = heights_m.shape
    generator = contourpy.contour_generator(
        np.linspace(bounds.west_m, bounds.east_m, columns),
        np.linspace(bounds.south_m, bounds.north_m, rows),
        np.ma.masked_invalid(heights_m),
        line_type=contourpy.LineType.Separate,
    )
    slack_m = max(relief.cell_m) / 8.0
    for level_m in levels_m:
        for line_m in generator.lines(level_m):
            is_closed = bool((line_m[0] == line_m[-1]).all())
            corners_m = line_m[: -1 if is_closed else None].astype(np.float32)
            points_m = cv2.approxPolyDP(corners_m, slack_m, closed=is_closed)[:, 0].astype(np.float64)
            if np.ptp(points_m, axis=0).max() > 16.0 * slack_m:
                yield Contour(level_m, np.vstack((points_m, points_m[:1])) if is_closed else points_m)
