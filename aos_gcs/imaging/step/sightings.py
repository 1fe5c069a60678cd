"""Sightings: each blob with the views that the frames of a step have of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aos_gcs.imaging.model import Blob, BlobView, FocalGrid, Sighting
from aos_gcs.imaging.step.blobs import BlobCells
from aos_gcs.imaging.step.marking import MarkedFrame


def sight(cells: BlobCells, grid: FocalGrid, marked: Sequence[MarkedFrame]) -> Sighting:
    """Return a blob with one view per frame that marks it.

    Args:
        cells: cells of the blob.
        grid: raster that cells and marks lie on.
        marked: frames of the step.
    """
    views = tuple(view for one in marked if (view := _view(cells, grid, one)) is not None)
    blob = Blob(
        area_m2=cells.area_m2(grid),
        centroid_enu_m=cells.centroid_enu_m(grid),
        max_count=int(cells.counts.max()),
        vehicle_ids=tuple(dict.fromkeys(view.vehicle_id for view in views)),
    )
    return Sighting(blob, views)


def _view(cells: BlobCells, grid: FocalGrid, marked: MarkedFrame) -> BlobView | None:
    frame = marked.frame
    own = np.flatnonzero(marked.marks.among(cells.rows, cells.columns))
    if not own.size:
        return None
    east_m = grid.west_m + (cells.columns[own].mean() + 0.5) * grid.resolution_m
    north_m = grid.north_m - (cells.rows[own].mean() + 0.5) * grid.resolution_m
    area_m2 = own.size * grid.resolution_m**2
    point_enu_m, camera = np.array([east_m, north_m]), frame.camera.ideal()
    return BlobView(frame.vehicle_id, point_enu_m, area_m2, camera, frame.pose, frame.time_sigma_s)
