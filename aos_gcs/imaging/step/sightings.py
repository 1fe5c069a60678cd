"""Sightings: each blob with the views that the frames of a step have of it."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.model import Blob, BlobView, FocalGrid, Sighting, Viewpoint
from aos_gcs.imaging.step.blobs import BlobCells
from aos_gcs.imaging.step.marking import MarkedFrame


def sight(
    cells: BlobCells, own_cells: Sequence[NDArray[np.intp]], grid: FocalGrid, marked: Sequence[MarkedFrame]
) -> Sighting:
    """Return a blob with one view per frame that marks it.

    Args:
        cells: cells of the blob.
        own_cells: indices of those that each frame marks, see :func:`cells_by_frame`.
        grid: raster that cells and marks lie on.
        marked: frames of the step.
    """
    views = tuple(_view(cells, own, grid, one.frame) for one, own in zip(marked, own_cells, strict=True) if own.size)
    blob = Blob(
        area_m2=cells.area_m2(grid),
        centroid_enu_m=cells.centroid_enu_m(grid),
        max_count=int(cells.counts.max()),
    )
    return Sighting(blob, views)


def cells_by_frame(
    blobs: Sequence[BlobCells], grid: FocalGrid, marked: Sequence[MarkedFrame]
) -> list[list[NDArray[np.intp]]]:
    """Return the indices of the cells that each frame marks of each blob, ascending: a list per blob, by frame.

    Args:
        blobs: disjoint blobs.
        grid: raster that cells and marks lie on.
        marked: frames of the step.
    """
    if not blobs:
        return []
    # All cells of all blobs, and the marks of all frames among them, at once: a search per blob and frame takes longer.
    places = np.concatenate([cells.rows * grid.columns + cells.columns for cells in blobs])
    blob_of = np.repeat(np.arange(len(blobs)), [cells.rows.size for cells in blobs])
    index_of = np.concatenate([np.arange(cells.rows.size) for cells in blobs])
    by_place = np.argsort(places)
    marks = np.concatenate([one.marks.rows * grid.columns + one.marks.columns for one in marked])
    frame_of = np.repeat(np.arange(len(marked)), [one.marks.rows.size for one in marked])
    found = by_place[np.searchsorted(places, marks, sorter=by_place).clip(max=places.size - 1)]
    among = places[found] == marks
    found, frame_of = found[among], frame_of[among]
    group_of = blob_of[found] * len(marked) + frame_of
    order = np.lexsort((index_of[found], group_of))
    own, groups = index_of[found][order], len(blobs) * len(marked)
    ends = np.searchsorted(group_of[order], np.arange(groups + 1)).tolist()
    by_group = [own[first:end] for first, end in itertools.pairwise(ends)]
    return [by_group[first : first + len(marked)] for first in range(0, groups, len(marked))]


def _view(cells: BlobCells, own: NDArray[np.intp], grid: FocalGrid, frame: Viewpoint) -> BlobView:
    east_m = grid.west_m + (cells.columns[own].mean() + 0.5) * grid.resolution_m
    north_m = grid.north_m - (cells.rows[own].mean() + 0.5) * grid.resolution_m
    point_enu_m, camera = np.array([east_m, north_m]), frame.camera.ideal()
    return BlobView(frame.vehicle_id, point_enu_m, camera, frame.pose, frame.time_sigma_s, frame.speed_mps)
