"""A frame on the cells of the searched ground: warped once, on the part of the surface that it shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.groundmap.directions import MAX_TANGENT, ViewDirections
from aos_gcs.groundmap.tile import COLOUR_CELL_M, COLOURS_PER_CELL, VIEW_CELL_M
from aos_gcs.imaging.integral import check_frame
from aos_gcs.imaging.model import Frame, MapRaster
from aos_gcs.imaging.surfaces.ground import choose_raster
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.views import FocalSurface, ortho_view
from aos_gcs.imaging.warped import WarpedFrame, sample

_HALF_SEEN = COLOURS_PER_CELL**2 // 2
"""Cells of colour that a frame must cover for their cell of views to count as seen: half of them."""


@dataclass(frozen=True, slots=True, eq=False)
class GroundView:
    """What a frame shows of the ground; row 0 is the northern edge."""

    row: int
    """Row of the first cell of views, counted southwards from the origin."""
    column: int
    """Column of the first cell, counted eastwards."""
    values: NDArray[np.float32]
    """Bands of the frame, shape (4 · rows, 4 · columns, C); of no meaning where nothing is covered."""
    covered: NDArray[np.bool_]
    """Cells of colour that the frame covers, shape (4 · rows, 4 · columns)."""
    squares: NDArray[np.int32]
    """Square of directions of each cell of views, shape (rows, columns)."""
    seen: NDArray[np.bool_]
    """Cells of views that the frame shows."""


def project_frame(frame: Frame, surface: FocalSurface, directions: ViewDirections) -> GroundView:
    """Return what a frame shows of the ground, as far as it looks down on it.

    Args:
        frame: frame with its pose.
        surface: plane, level or tilted, or terrain; where the terrain is not known nothing is seen.
        directions: squares of directions.

    Raises:
        ImagingError: it shows nothing of the ground, or its image does not fit its camera.
    """
    check_frame(frame, frame.bands)
    coarse = _within_reach(choose_raster([(frame.camera, frame.pose)], surface, VIEW_CELL_M), frame, surface)
    fine = MapRaster(
        coarse.x_m,
        coarse.y_m,
        COLOUR_CELL_M,
        coarse.rows * COLOURS_PER_CELL,
        coarse.columns * COLOURS_PER_CELL,
        rows_along_y=False,
    )
    projection = ortho_view(fine, surface).project(frame)
    warped = None if projection is None else sample(frame.image, projection, 0, fine.rows, exact=False)
    if warped is None:
        raise ImagingError(f"The frame of vehicle {frame.vehicle_id} shows nothing of the ground.")
    values, covered = _whole(warped.without_gaps(), fine)
    blocks = covered.reshape(coarse.rows, COLOURS_PER_CELL, coarse.columns, COLOURS_PER_CELL)
    half_seen = blocks.sum(axis=(1, 3)) >= _HALF_SEEN
    squares, counts = directions.squares(frame.pose.position_enu_m, _cells_enu_m(coarse, surface))
    return GroundView(
        row=round(-coarse.y_m / VIEW_CELL_M),
        column=round(coarse.x_m / VIEW_CELL_M),
        values=values,
        covered=covered,
        squares=squares,
        seen=half_seen & counts,
    )


def _within_reach(raster: MapRaster, frame: Frame, surface: FocalSurface) -> MapRaster:
    """Return the part of a raster that a camera does not see too flat; north-up."""
    if raster.rows_along_y:
        raise ImagingError(f"The camera of vehicle {frame.vehicle_id} is below the ground.")
    east_m, north_m, up_m = map(float, frame.pose.position_enu_m)
    lowest_m = float(surface.lower_m[2]) if isinstance(surface, Terrain) else float(surface.z_m(east_m, north_m))
    reach_m = max(MAX_TANGENT * (up_m - lowest_m), VIEW_CELL_M)
    west, east = np.floor((east_m - reach_m) / VIEW_CELL_M), np.ceil((east_m + reach_m) / VIEW_CELL_M)
    south, north = np.floor((north_m - reach_m) / VIEW_CELL_M), np.ceil((north_m + reach_m) / VIEW_CELL_M)
    west_m = max(raster.x_m, float(west) * VIEW_CELL_M)
    north_edge_m = min(raster.y_m, float(north) * VIEW_CELL_M)
    east_m = min(raster.x_m + raster.columns * VIEW_CELL_M, float(east) * VIEW_CELL_M)
    south_m = max(raster.y_m - raster.rows * VIEW_CELL_M, float(south) * VIEW_CELL_M)
    rows, columns = round((north_edge_m - south_m) / VIEW_CELL_M), round((east_m - west_m) / VIEW_CELL_M)
    if rows < 1 or columns < 1:
        raise ImagingError(f"The frame of vehicle {frame.vehicle_id} shows the ground too flat, or not at all.")
    return MapRaster(west_m, north_edge_m, VIEW_CELL_M, rows, columns, rows_along_y=False)


def _whole(warped: WarpedFrame, raster: MapRaster) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Return values and coverage on the whole raster."""
    values = np.zeros((raster.rows, raster.columns, warped.values.shape[2]), dtype=np.float32)
    covered = np.zeros((raster.rows, raster.columns), dtype=np.bool_)
    values[warped.window] = warped.values
    covered[warped.window] = warped.coverage().view(np.bool_)
    return values, covered


def _cells_enu_m(raster: MapRaster, surface: FocalSurface) -> NDArray[np.float64]:
    """Return the centres of a raster's cells on the surface, shape (rows, columns, 3); NaN where it is not known."""
    x_m = raster.x_m + raster.resolution_m * (np.arange(raster.columns) + 0.5)
    y_m = raster.y_m - raster.resolution_m * (np.arange(raster.rows) + 0.5)
    east_m, north_m = np.meshgrid(x_m, y_m)
    return np.dstack((east_m, north_m, surface.z_m(east_m, north_m)))
