"""What the frames of a step show of each blob."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.blobs import BlobCells
from aos_gcs.imaging.model import Blob, BlobView, FocalGrid, Frame, Sighting
from aos_gcs.imaging.warp import Patch


def sight(
    cells: BlobCells, grid: FocalGrid, frames: Sequence[Frame], masks: Sequence[tuple[Patch, NDArray[np.uint8]] | None]
) -> Sighting:
    """Return a blob with one view per frame that marks it.

    Args:
        cells: of the blob.
        grid: that cells and masks lie on.
        frames: without distortion.
        masks: of each frame, given on its patch; None marks nothing.
    """
    views = tuple(
        view
        for frame, mask in zip(frames, masks, strict=True)
        if mask is not None and (view := _view(cells, grid, frame, *mask)) is not None
    )
    blob = Blob(
        area_m2=cells.area_m2(grid),
        centroid_enu_m=cells.centroid_enu_m(grid),
        max_count=int(cells.counts.max()),
        vehicle_ids=tuple(dict.fromkeys(view.vehicle_id for view in views)),
    )
    return Sighting(blob, views)


def _view(cells: BlobCells, grid: FocalGrid, frame: Frame, patch: Patch, marked: NDArray[np.uint8]) -> BlobView | None:
    rows, columns = cells.rows - patch.row, cells.columns - patch.column
    inside = (rows >= 0) & (rows < marked.shape[0]) & (columns >= 0) & (columns < marked.shape[1])
    own = np.flatnonzero(inside)[marked[rows[inside], columns[inside]] > 0]
    if not own.size:
        return None
    east_m = grid.west_m + (cells.columns[own].mean() + 0.5) * grid.resolution_m
    north_m = grid.north_m - (cells.rows[own].mean() + 0.5) * grid.resolution_m
    area_m2 = own.size * grid.resolution_m**2
    return BlobView(frame.vehicle_id, np.array([east_m, north_m]), area_m2, frame.camera, frame.pose)
