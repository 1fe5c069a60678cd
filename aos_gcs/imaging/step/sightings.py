"""Sightings: each blob with the views that the frames of a step have of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.detection.marks import Marks
from aos_gcs.imaging.model import Blob, BlobView, FocalGrid, Sighting, Viewpoint
from aos_gcs.imaging.step.blobs import BlobCells
from aos_gcs.imaging.step.marking import MarkedFrame


def sight(cells: BlobCells, grid: FocalGrid, marked: Sequence[MarkedFrame]) -> Sighting:
    """Return a blob with one view per frame that marks it.

    Args:
        cells: cells of the blob.
        grid: raster that cells and marks lie on.
        marked: frames of the step.
    """
    first_row, first_column = int(cells.rows.min()), int(cells.columns.min())
    # Indices of the blob's cells in its window, -1 beside them: laid out once for all frames.
    index_at = np.full((np.ptp(cells.rows) + 1, np.ptp(cells.columns) + 1), -1, dtype=np.intp)
    index_at[cells.rows - first_row, cells.columns - first_column] = np.arange(cells.rows.size)
    own_cells = [_own_cells(one.marks, index_at, first_row, first_column) for one in marked]
    views = tuple(_view(cells, own, grid, one.frame) for one, own in zip(marked, own_cells, strict=True) if own.size)
    blob = Blob(
        area_m2=cells.area_m2(grid),
        centroid_enu_m=cells.centroid_enu_m(grid),
        max_count=int(cells.counts.max()),
        vehicle_ids=tuple(dict.fromkeys(view.vehicle_id for view in views)),
    )
    return Sighting(blob, views)


def _own_cells(marks: Marks, index_at: NDArray[np.intp], first_row: int, first_column: int) -> NDArray[np.intp]:
    """Return the indices of a blob's cells that a frame marks, ascending."""
    rows, columns = marks.rows - first_row, marks.columns - first_column
    inside = np.flatnonzero((rows >= 0) & (rows < index_at.shape[0]) & (columns >= 0) & (columns < index_at.shape[1]))
    if not inside.size:
        return inside
    own = index_at[rows[inside], columns[inside]]
    return np.asarray(np.sort(own[own >= 0]), dtype=np.intp)


def _view(cells: BlobCells, own: NDArray[np.intp], grid: FocalGrid, frame: Viewpoint) -> BlobView:
    east_m = grid.west_m + (cells.columns[own].mean() + 0.5) * grid.resolution_m
    north_m = grid.north_m - (cells.rows[own].mean() + 0.5) * grid.resolution_m
    area_m2 = own.size * grid.resolution_m**2
    point_enu_m, camera = np.array([east_m, north_m]), frame.camera.ideal()
    return BlobView(frame.vehicle_id, point_enu_m, area_m2, camera, frame.pose, frame.time_sigma_s, frame.speed_mps)
