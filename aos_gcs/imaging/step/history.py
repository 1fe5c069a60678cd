"""Earlier views of a target that stays in the integral: I(t) holds more than the frames of step t (spec, section 2).

What is kept of a frame is not its image but the cells that it has marked of the largest blob: a few hundred bytes that
are laid on the raster of a later step in microseconds, while an image would have to be searched and warped again.

After each step the views that together cover most of the blob are chosen, one after the other, as long as each adds
enough (greedy maximum coverage, within 1 - 1/e of the optimum: Nemhauser, Wolsey and Fisher, 1978). A view from before
is dropped when the blob has moved away from it, or it does not add anything any more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.detection.marks import NO_MARKS, Marks
from aos_gcs.imaging.model import FocalGrid, KeptView, Viewpoint
from aos_gcs.imaging.step.blobs import BlobCells
from aos_gcs.imaging.step.marking import MarkedFrame

MIN_GAIN = 0.03
"""Share of the blob's area that a view must add to be kept."""

AGREEMENT_M = 1.0
"""Largest distance between the centre of what the present frames mark and of what an earlier view has marked: beyond
it, the target has moved. Views of a still target differ by their poses' errors and by the height of its body."""


@dataclass(frozen=True, slots=True, eq=False)
class MarkedView:
    """A view of an earlier step with the cells of the present raster that it marks."""

    view: KeptView
    marks: Marks


@dataclass(frozen=True, slots=True)
class _Candidate:
    view: KeptView
    marked: NDArray[np.bool_]
    """Cells of the blob that the view marks, shape (n,)."""


def marks_on(view: KeptView, grid: FocalGrid) -> Marks:
    """Return the cells of a grid whose centres lie in the cells that a view has marked.

    On a focal plane of another height, what the view has marked moves along its lines of sight.
    """
    centre = view.pose.position_enu_m
    scale = float((grid.height_m - centre[2]) / (view.height_m - centre[2]))
    rows, columns = view.marked.shape
    low = _scaled(np.array([view.west_m, view.north_m - rows * view.resolution_m]), centre[:2], scale)
    high = _scaled(np.array([view.west_m + columns * view.resolution_m, view.north_m]), centre[:2], scale)
    first_column = max(0, math.floor((low[0] - grid.west_m) / grid.resolution_m))
    end_column = min(grid.columns, math.ceil((high[0] - grid.west_m) / grid.resolution_m))
    first_row = max(0, math.floor((grid.north_m - high[1]) / grid.resolution_m))
    end_row = min(grid.rows, math.ceil((grid.north_m - low[1]) / grid.resolution_m))
    if first_column >= end_column or first_row >= end_row:
        return NO_MARKS
    east_m = grid.west_m + (np.arange(first_column, end_column) + 0.5) * grid.resolution_m
    north_m = grid.north_m - (np.arange(first_row, end_row) + 0.5) * grid.resolution_m
    own_column = _cell(_scaled(east_m, centre[0], 1.0 / scale) - view.west_m, view.resolution_m)
    own_row = _cell(view.north_m - _scaled(north_m, centre[1], 1.0 / scale), view.resolution_m)
    inside = ((own_row >= 0) & (own_row < rows))[:, np.newaxis] & (own_column >= 0) & (own_column < columns)
    marked = inside & view.marked[np.ix_(own_row.clip(0, rows - 1), own_column.clip(0, columns - 1))]
    found_rows, found_columns = np.nonzero(marked)
    return Marks(found_rows + first_row, found_columns + first_column)


def views_to_keep(
    cells: BlobCells,
    grid: FocalGrid,
    frames: Sequence[MarkedFrame],
    history: Sequence[MarkedView],
    at_most: int,
) -> tuple[KeptView, ...]:
    """Return the views that the next step should have.

    Args:
        cells: cells of the largest blob.
        grid: raster that cells and marks lie on.
        frames: frames of this step; at least one marks the blob.
        history: views of earlier steps that this step had.
        at_most: largest number of views.
    """
    present = [
        _Candidate(_kept(one.frame, cells, marked, grid), marked)
        for one in frames
        if (marked := one.marks.among(cells.rows, cells.columns)).any()
    ]
    centre_m = _centre_m(cells, np.sum([one.marked for one in present], axis=0), grid)
    past = [
        _Candidate(one.view, marked)
        for one in history
        if (marked := one.marks.among(cells.rows, cells.columns)).any()
        and np.linalg.norm(_centre_m(cells, marked.astype(np.int64), grid) - centre_m) <= AGREEMENT_M
    ]
    return tuple(one.view for one in _best(present + past, MIN_GAIN * cells.rows.size, at_most))


def _best(candidates: list[_Candidate], min_gain: float, at_most: int) -> list[_Candidate]:
    """Return the candidates that together cover most, each adding at least so many cells."""
    chosen: list[_Candidate] = []
    while candidates and len(chosen) < at_most:
        covered = np.any([one.marked for one in chosen], axis=0) if chosen else np.zeros(1, dtype=np.bool_)
        gains = [np.count_nonzero(one.marked & ~covered) for one in candidates]
        best = int(np.argmax(gains))
        if gains[best] < min_gain:
            break
        chosen.append(candidates.pop(best))
    return chosen


def _kept(frame: Viewpoint, cells: BlobCells, marked: NDArray[np.bool_], grid: FocalGrid) -> KeptView:
    rows, columns = cells.rows[marked], cells.columns[marked]
    window = np.zeros((np.ptp(rows) + 1, np.ptp(columns) + 1), dtype=np.bool_)
    window[rows - rows.min(), columns - columns.min()] = True
    return KeptView(
        vehicle_id=frame.vehicle_id,
        pose=frame.pose,
        marked=window,
        west_m=grid.west_m + float(columns.min()) * grid.resolution_m,
        north_m=grid.north_m - float(rows.min()) * grid.resolution_m,
        resolution_m=grid.resolution_m,
        height_m=grid.height_m,
    )


def _centre_m(cells: BlobCells, weights: NDArray[np.int64], grid: FocalGrid) -> NDArray[np.float64]:
    """Return the weighted mean of cells, shape (2,), metres right and down from the grid's corner."""
    return np.array([np.average(cells.columns, weights=weights), np.average(cells.rows, weights=weights)]) * (
        grid.resolution_m
    )


def _scaled(places_m: NDArray[np.float64], centre_m: NDArray[np.float64] | float, scale: float) -> NDArray[np.float64]:
    return np.asarray(centre_m + scale * (places_m - centre_m))


def _cell(distance_m: NDArray[np.float64], resolution_m: float) -> NDArray[np.intp]:
    return np.floor(distance_m / resolution_m).astype(np.intp)
