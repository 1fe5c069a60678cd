"""Figures about the searched ground: what share of an area was seen, and how likely a person there would be found."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.groundmap.detection import DETECTABILITY, Posture, detection_by_views
from aos_gcs.groundmap.tile import VIEW_CELL_M, VIEW_CELLS, TileIndex

Polygon = tuple[tuple[float, float], ...]
"""Corners, east and north in metres."""


@dataclass(frozen=True, slots=True)
class DetectionFigures:
    """Mean probability of detection over an area, by the posture of the person."""

    standing: float
    sitting: float
    lying: float


@dataclass(frozen=True, slots=True)
class SegmentFigures:
    """Figures of a segment after all flights that the map knows."""

    name: str
    area_m2: float
    seen_fraction: float
    """Share that was seen from at least one direction."""
    detection: float | None
    """Mean probability of detection of a standing person; None where the forest is not described."""
    probability: float | None
    """Probability before the search that the person is in the segment, within the search area; None without a prior."""
    success: float | None
    """Probability that the person is there and would have been noticed by now; None without a prior or a forest."""


@dataclass(frozen=True, slots=True)
class GroundFigures:
    """Figures about the searched ground."""

    frames: int
    """Frames on the map, those of former sorties included."""
    left_out: int
    """Frames of this mission that are not on it: unusable, or too many at a time."""
    seen_fraction: float
    """Share of the search area that was seen from at least one direction."""
    mean_views: float
    """Mean number of independent views over the search area."""
    detection: DetectionFigures | None
    """Mean probability of detection over the search area; None where the forest is not described."""
    soon: float | None = None
    """The same for a standing person after ten more minutes of flight where they gain most; None where unknown."""
    success: float | None = None
    """Probability that the person is in the search area and would have been noticed; None without a prior or forest."""
    segments: tuple[SegmentFigures, ...] = ()
    """Figures by segment, where segments are named."""


@dataclass(frozen=True, slots=True, eq=False)
class ViewRaster:
    """Numbers of independent views; north-up, cells of one metre."""

    row: int
    """Row of the first cell, counted southwards from the origin."""
    column: int
    """Column of the first cell, counted eastwards."""
    views: NDArray[np.uint8]
    """Shape (rows, columns)."""

    @property
    def west_m(self) -> float:
        """East coordinate of the western edge."""
        return self.column * VIEW_CELL_M

    @property
    def north_m(self) -> float:
        """North coordinate of the northern edge."""
        return -self.row * VIEW_CELL_M

    def at(self, places_m: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the views of places, shape (k, 2); none beyond the raster."""
        columns = np.floor((places_m[:, 0] - self.west_m) / VIEW_CELL_M).astype(np.int64)
        rows = np.floor((self.north_m - places_m[:, 1]) / VIEW_CELL_M).astype(np.int64)
        height, width = self.views.shape
        is_known = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        found = self.views[rows.clip(0, height - 1), columns.clip(0, width - 1)]
        return np.where(is_known, found, 0).astype(np.int64)

    def inside(self, area_enu_m: Polygon) -> NDArray[np.bool_]:
        """Return which cells have their centre in a polygon, shape (rows, columns)."""
        rows, columns = self.views.shape
        if not area_enu_m:
            return np.zeros((rows, columns), dtype=np.bool_)
        x, y = np.array(area_enu_m, dtype=np.float64).T
        x, y = (x - self.west_m) / VIEW_CELL_M - 0.5, (self.north_m - y) / VIEW_CELL_M - 0.5
        row = np.arange(rows)
        crossings = np.zeros((rows, columns + 1), dtype=np.uint8)
        for x_0, y_0, x_1, y_1 in zip(x, y, np.roll(x, -1), np.roll(y, -1), strict=True):
            crossed = row[(y_0 <= row) != (y_1 <= row)]
            # An even number of edges lies west of what is outside.
            at = np.ceil(x_0 + (crossed - y_0) * (x_1 - x_0) / (y_1 - y_0)) if len(crossed) else np.empty(0)
            crossings[crossed, at.clip(0, columns).astype(np.int64)] += 1
        return np.asarray(np.cumsum(crossings[:, :-1], axis=1, dtype=np.uint8) % 2 == 1)


def view_raster(tiles: Mapping[TileIndex, NDArray[np.uint8]], area_enu_m: Polygon = ()) -> ViewRaster:
    """Return the views of all tiles and of an area, as one raster.

    Args:
        tiles: numbers of views of tiles, shape (32, 32) each.
        area_enu_m: area that the raster holds as well.
    """
    indices = [*tiles, *(_tile_of(corner) for corner in area_enu_m)] or [(0, 0)]
    rows, columns = [row for row, _ in indices], [column for _, column in indices]
    first_row, first_column = min(rows), min(columns)
    shape = (max(rows) - first_row + 1) * VIEW_CELLS, (max(columns) - first_column + 1) * VIEW_CELLS
    views = np.zeros(shape, dtype=np.uint8)
    for (row, column), own in tiles.items():
        top, left = (row - first_row) * VIEW_CELLS, (column - first_column) * VIEW_CELLS
        views[top : top + VIEW_CELLS, left : left + VIEW_CELLS] = own
    return ViewRaster(first_row * VIEW_CELLS, first_column * VIEW_CELLS, views)


def _tile_of(corner_enu_m: tuple[float, float]) -> TileIndex:
    edge_m = VIEW_CELLS * VIEW_CELL_M
    return math.floor(-corner_enu_m[1] / edge_m), math.floor(corner_enu_m[0] / edge_m)


def ground_figures(
    raster: ViewRaster, area_enu_m: Polygon, occlusion: float | None, frames: int, left_out: int
) -> GroundFigures:
    """Return the figures of an area.

    Args:
        raster: views, of the whole area at least.
        area_enu_m: search area.
        occlusion: share of the ground that one image does not see; None where the forest is not described.
        frames: frames on the map.
        left_out: frames that are not on it.
    """
    views = raster.views[raster.inside(area_enu_m)]
    # As often as each number of views occurs: the same for each posture.
    # Nothing of an area without cells, such as one that is still to be drawn, was seen.
    shares = np.bincount(views, minlength=256) / views.size if views.size else np.eye(1, 256)[0]
    detection = None
    if occlusion is not None:
        detection = DetectionFigures(
            **{str(one): float(shares @ detection_by_views(occlusion, DETECTABILITY[one])) for one in Posture}
        )
    return GroundFigures(frames, left_out, float(1.0 - shares[0]), float(shares @ np.arange(256)), detection)
