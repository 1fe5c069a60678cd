"""Visibility of the target to each vehicle: f(x_i, I(t)) and the leader (spec, section 2)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import project_points
from aos_gcs.imaging.detection.marks import Marks
from aos_gcs.imaging.focal_plane import grid_to_image
from aos_gcs.imaging.model import FocalGrid, VehicleMasks
from aos_gcs.imaging.step.blobs import BlobCells

TIE_TOLERANCE = 1e-9
"""Relative difference of two fitness values below which they are equal but for rounding."""

MASK_HALF_WIDTH_M = 4.0
"""Half the edge of the window around the largest blob in which the masks of the vehicles are passed on."""


def contribution_m2(blob: BlobCells, grid: FocalGrid, marks: Marks) -> float:
    """Return the area of a frame's own mask inside the blob."""
    return float(np.count_nonzero(marks.among(blob.rows, blob.columns))) * grid.resolution_m**2


def area_in_view_px(blob: BlobCells, grid: FocalGrid, camera: CameraModel, pose: Pose) -> float:
    """Return the area of the blob as the camera sees it, in pixels, without rendering its view.

    A homography scales the area about a point by det(H) / w³; summed over the cells in view this is the blob's area,
    holes and separate pieces included, where a contour through the cells' centres would lose half a cell on each side.
    """
    H = grid_to_image(grid, camera, pose)
    u, v, w = H @ np.stack((blob.columns, blob.rows, np.ones_like(blob.rows)))
    w = np.where(w > 0.0, w, np.nan)
    in_view = (np.abs(u / w - (camera.width_px - 1) / 2) <= camera.width_px / 2) & (
        np.abs(v / w - (camera.height_px - 1) / 2) <= camera.height_px / 2
    )
    return float(abs(np.linalg.det(H)) * np.sum(w[in_view] ** -3.0))


def distance_to_centre(point_enu_m: Sequence[float], camera: CameraModel, pose: Pose) -> float:
    """Return how far from the image centre a point is seen, in image widths; infinite if it is behind the camera."""
    pixel = project_points([point_enu_m], camera, pose)[0]
    offset = pixel - [(camera.width_px - 1) / 2, (camera.height_px - 1) / 2]
    return float(np.nan_to_num(np.linalg.norm(offset) / camera.width_px, nan=np.inf))


def choose_leader(fitness: NDArray[np.float64], distance_of: Callable[[int], float]) -> int:
    """Return the index of the greatest fitness; ties go to the smallest distance to the centre, then to the first.

    Args:
        fitness: fitness of the views.
        distance_of: distance to the centre of the view of an index; asked about those of the greatest fitness.
    """
    tied = np.flatnonzero(fitness >= fitness.max() * (1.0 - TIE_TOLERANCE))
    return min((int(index) for index in tied), key=distance_of)


def masks_around(
    centre_enu_m: Sequence[float],
    grid: FocalGrid,
    marks: Sequence[Marks],
) -> VehicleMasks:
    """Return the part of the vehicles' masks that lies in a square window around a point of the grid.

    Args:
        centre_enu_m: point on the grid.
        grid: raster of the marks.
        marks: cells that each vehicle marks.
    """
    column = (centre_enu_m[0] - grid.west_m) / grid.resolution_m
    row = (grid.north_m - centre_enu_m[1]) / grid.resolution_m
    half = MASK_HALF_WIDTH_M / grid.resolution_m
    first_row, end_row = max(0, math.floor(row - half)), min(grid.rows, math.ceil(row + half))
    first_column, end_column = max(0, math.floor(column - half)), min(grid.columns, math.ceil(column + half))
    marked = np.zeros((len(marks), end_row - first_row, end_column - first_column), dtype=np.bool_)
    for own, cells in zip(marked, marks, strict=True):
        rows, columns = cells.rows - first_row, cells.columns - first_column
        inside = (rows >= 0) & (rows < own.shape[0]) & (columns >= 0) & (columns < own.shape[1])
        own[rows[inside], columns[inside]] = True
    return VehicleMasks(
        marked=marked,
        west_m=grid.west_m + first_column * grid.resolution_m,
        north_m=grid.north_m - first_row * grid.resolution_m,
        resolution_m=grid.resolution_m,
    )
