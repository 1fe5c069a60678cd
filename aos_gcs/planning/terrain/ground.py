"""The ground below a plan, from the elevation model that the configuration names."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.limits import GroundLimits, SafetyLimits
from aos_gcs.airspace.terrain import GroundRaster, Polynomials
from aos_gcs.elevation.geoid import find_egm2008, find_geoid
from aos_gcs.elevation.model import ElevationModel
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.planning.settings import ForestSettings, TerrainSettings

FloatArray = NDArray[np.float64]
FileVersions = tuple[tuple[str, int, int], ...]
"""Path, time of the last change in nanoseconds, and size of files."""

MAX_CELLS = 4_000_000
"""Greatest number of cells of a raster: 32 MB."""
FINE_CELL_M = 2.0
"""Edge below which cells of a model are not divided any more."""

_LEAST_FLOOR_M = 5.0
"""Floor above the ground where that above the origin is lower."""
_ABOVE_CANOPY_M = 5.0
"""Height above the canopy, where that is known, that a floor leaves."""
_BEYOND_FENCE_M = 50.0
_NODES = 12
"""Places along each axis to which the mapping from the local frame to the model's cells is fitted."""
_BAND_CELLS = 5_000_000


@dataclass(frozen=True, slots=True)
class EnuBounds:
    """A rectangle along the axes of the local frame, metres."""

    west_m: float
    south_m: float
    east_m: float
    north_m: float

    @classmethod
    def around(cls, places_enu_m: FloatArray, margin_m: float) -> EnuBounds:
        """Return the rectangle around places, shape (n, 2), rounded outwards to 100 m so that few differ."""
        low_m = np.floor((places_enu_m.min(axis=0) - margin_m) / 100.0) * 100.0
        high_m = np.ceil((places_enu_m.max(axis=0) + margin_m) / 100.0) * 100.0
        return cls(float(low_m[0]), float(low_m[1]), float(high_m[0]), float(high_m[1]))

    def nodes(self, count: int) -> FloatArray:
        """Return a grid of places that spans it, shape (count², 2)."""
        east_m, north_m = (
            np.linspace(*ends, count) for ends in ((self.west_m, self.east_m), (self.south_m, self.north_m))
        )
        return np.stack(np.meshgrid(east_m, north_m), axis=-1).reshape(-1, 2)


def open_model(settings: TerrainSettings) -> ElevationModel:
    """Return the elevation model of a mission.

    Raises:
        ConfigurationError: a setting cannot be used, or a library is missing.
        InputDataError: a file cannot be used.
    """
    return _open_model(settings, file_versions(settings))


def file_versions(settings: TerrainSettings) -> FileVersions:
    """Return what changes when a file is replaced; one that is gone has no version."""
    paths = [path for path in map(Path, settings.files) if path.is_file()]
    return tuple((str(path), path.stat().st_mtime_ns, path.stat().st_size) for path in paths)


@lru_cache(maxsize=2)
def _open_model(settings: TerrainSettings, _versions: FileVersions) -> ElevationModel:
    geoid = find_geoid(None if settings.geoid is None else Path(settings.geoid))
    paths = tuple(map(Path, settings.files))
    return ElevationModel(
        paths, settings.kind, datum=settings.datum, crs=settings.crs, geoid=geoid, egm2008=find_egm2008()
    )


def ground_heights_m(settings: TerrainSettings, origin: GeodeticPosition, places_enu_m: FloatArray) -> FloatArray:
    """Return the height of the ground above the origin at places, shape (n, 2); NaN where it is not known.

    Raises:
        ConfigurationError: a setting cannot be used, or a library is missing.
        InputDataError: a file cannot be used or read.
    """
    latitudes, longitudes, drops_m = _level_places(LocalFrame(origin), places_enu_m)
    return open_model(settings).heights_amsl_m(latitudes, longitudes) - origin.altitude_amsl_m - drops_m


def ground_within(settings: TerrainSettings, origin: GeodeticPosition, bounds: EnuBounds) -> GroundRaster:
    """Return the ground within a rectangle, as a raster in memory.

    Raises:
        ConfigurationError: a setting cannot be used, or a library is missing.
        InputDataError: a file cannot be used or read.
    """
    return _ground_within(settings, file_versions(settings), origin, bounds)


@lru_cache(maxsize=2)
def _ground_within(
    settings: TerrainSettings, _versions: FileVersions, origin: GeodeticPosition, bounds: EnuBounds
) -> GroundRaster:
    return read_ground(settings, origin, bounds)


def read_ground(settings: TerrainSettings, origin: GeodeticPosition, bounds: EnuBounds) -> GroundRaster:
    """Return the ground within a rectangle, as ``ground_within`` does, and keep nothing of it."""
    model = open_model(settings)
    nodes_m = bounds.nodes(_NODES)
    latitudes, longitudes, drops_m = _level_places(LocalFrame(origin), nodes_m)
    cells = np.column_stack(model.row_column(latitudes, longitudes))
    first, last = np.floor(cells.min(axis=0)).astype(np.int64) - 1, np.ceil(cells.max(axis=0)).astype(np.int64) + 1
    parts, merged = _resolution(model, last - first)
    shape = tuple(int(count) for count in np.ceil((last - first) * parts / merged))
    lowest_m, highest_m = (np.empty(shape, dtype=np.float32) for _ in range(2))
    band = max(1, _BAND_CELLS * parts // (int(last[1] - first[1]) * merged * max(1, parts * parts)))
    for begin in range(0, shape[0], band):
        end = min(shape[0], begin + band)
        low_m, high_m = _extremes(model, first, (begin, end, shape[1]), parts, merged)
        lowest_m[begin:end], highest_m[begin:end] = low_m - origin.altitude_amsl_m, high_m - origin.altitude_amsl_m
    scaled = (cells - first) * parts / merged
    drops_m = drops_m + model.undulation_m(latitudes, longitudes)
    to_cells = Polynomials.fitted(nodes_m, np.column_stack((scaled, drops_m)))
    return GroundRaster(lowest_m, highest_m, to_cells, Polynomials.fitted(scaled, nodes_m))


def ground_limits(
    terrain: TerrainSettings, origin: GeodeticPosition, homes_enu_m: FloatArray, floor_m: float
) -> GroundLimits:
    """Return the limits above the ground of vehicles that stand at their launch points, shape (n, 3).

    What they know well is their height above where they stand; the altitude of that may err by metres. A launch point
    below which the ground is not known counts as agreeing with the model. ``floor_m`` is the smallest height above the
    ground.

    Raises:
        ConfigurationError: a setting cannot be used, or a library is missing.
        InputDataError: a file cannot be used or read.
    """
    offsets_m = homes_enu_m[:, 2] - ground_heights_m(terrain, origin, homes_enu_m[:, :2])
    offsets_m = offsets_m[np.isfinite(offsets_m)] if np.isfinite(offsets_m).any() else np.zeros(1)
    bounds_m = float(offsets_m.min()), float(offsets_m.max())
    return GroundLimits(floor_m=floor_m, ceiling_m=terrain.ceiling_above_ground_m, offsets_m=bounds_m)


def ground_of_limits(
    terrain: TerrainSettings | None, origin: GeodeticPosition, limits: SafetyLimits
) -> GroundRaster | None:
    """Return the ground within the geofence that limits refer to; None where it counts as level.

    Raises:
        ConfigurationError: a setting cannot be used, or a library is missing.
        InputDataError: a file cannot be used or read.
    """
    if terrain is None or limits.above_ground is None:
        return None
    return replace(ground_in_fence(terrain, origin, limits), offsets_m=limits.above_ground.offsets_m)


def ground_in_fence(terrain: TerrainSettings, origin: GeodeticPosition, limits: SafetyLimits) -> GroundRaster:
    """Return the ground within a geofence and about it, by the model alone.

    Raises:
        ConfigurationError: a setting cannot be used, or a library is missing.
        InputDataError: a file cannot be used or read.
    """
    return ground_within(terrain, origin, EnuBounds.around(np.array(limits.fence_enu_m), _BEYOND_FENCE_M))


def floor_above_ground_m(terrain: TerrainSettings, forest: ForestSettings | None, floor_above_origin_m: float) -> float:
    """Return the smallest height above the ground: the one that is set, else 5 m above the canopy where that is known.

    It is never more than the floor above the origin, which keeps clear of the trees on level ground.
    """
    if terrain.floor_above_ground_m is not None:
        return terrain.floor_above_ground_m
    most_m = max(_LEAST_FLOOR_M, floor_above_origin_m)
    return most_m if forest is None else min(most_m, forest.canopy_height_m + _ABOVE_CANOPY_M)


def _resolution(model: ElevationModel, extent: NDArray[np.int64]) -> tuple[int, int]:
    """Return into how many parts cells are divided along each axis, and how many are then merged."""
    cells = float(np.prod(extent))
    if cells > MAX_CELLS:
        return 1, math.ceil(math.sqrt(cells / MAX_CELLS))
    parts = min(math.ceil(max(model.cell_m) / FINE_CELL_M), math.floor(math.sqrt(MAX_CELLS / cells)))
    return max(1, parts), 1


def _extremes(
    model: ElevationModel, first: NDArray[np.int64], wanted: tuple[int, int, int], parts: int, merged: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the lowest and the highest ground in rows of the raster, shape (end - begin, columns) each.

    The ground is bilinear between the centres of the model's cells, so that its extremes are at the corners of any
    rectangle between four of them.
    """
    begin, end, columns = wanted
    rows_of_model = first[0] + begin * merged // parts, first[0] + -(-end * merged // parts) + 1
    columns_of_model = first[1], first[1] + -(-columns * merged // parts) + 1
    heights = model.cells_of_files(np.arange(*rows_of_model), np.arange(*columns_of_model))
    corners = _divided(_divided(heights, parts).T, parts).T
    skipped = (begin * merged) % parts
    corners = corners[skipped : skipped + (end - begin) * merged + 1, : columns * merged + 1]
    low, high = (
        _merged(_merged(corners, merged, extreme).T, merged, extreme).T for extreme in (np.minimum, np.maximum)
    )
    return low, high


def _merged(heights: NDArray[np.float32], count: int, extreme: np.ufunc) -> NDArray[np.float32]:
    """Return the extreme of every ``count + 1`` of n * count + 1 rows; neighbours share one. Shape (n, columns)."""
    found = extreme(heights[:-1:count], heights[count::count])
    for row in range(1, count):
        extreme(found, heights[row:-1:count], out=found)
    return np.asarray(found)


def _divided(heights: NDArray[np.float32], parts: int) -> NDArray[np.float32]:
    """Return heights with ``parts - 1`` linear ones between each two rows."""
    if parts == 1:
        return heights
    shares = (np.arange(parts, dtype=np.float32) / parts)[None, :, None]
    between = heights[:-1, None] * (1.0 - shares) + heights[1:, None] * shares
    between[:, 0] = heights[:-1]
    return np.vstack((between.reshape(-1, heights.shape[1]), heights[-1:])).astype(np.float32)


def _level_places(frame: LocalFrame, places_enu_m: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return latitudes, longitudes, and how far the level surface through the origin is below the frame's plane."""
    origin_m = frame.origin.altitude_amsl_m
    places = [frame.to_geodetic((*place_m, 0.0)) for place_m in places_enu_m]
    return (
        np.array([place.latitude_deg for place in places]),
        np.array([place.longitude_deg for place in places]),
        np.array([place.altitude_amsl_m - origin_m for place in places]),
    )
