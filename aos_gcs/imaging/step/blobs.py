"""The connected anomalies of an integral."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.model import MAX_SIGHTINGS, FocalGrid


@dataclass(frozen=True, slots=True, eq=False)
class BlobCells:
    """The cells of one blob; arrays of shape (n,)."""

    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    counts: NDArray[np.uint16]
    """Number of frames that mark each cell."""

    def area_m2(self, grid: FocalGrid) -> float:
        """Return the area of the marked cells."""
        return self.rows.size * grid.resolution_m**2

    def centroid_enu_m(self, grid: FocalGrid) -> tuple[float, float, float]:
        """Return the mean position, weighted by the number of frames that mark each cell."""
        column = float(np.average(self.columns, weights=self.counts))
        row = float(np.average(self.rows, weights=self.counts))
        east_m = grid.west_m + (column + 0.5) * grid.resolution_m
        north_m = grid.north_m - (row + 0.5) * grid.resolution_m
        return east_m, north_m, grid.height_m


def joined(blobs: Sequence[BlobCells]) -> BlobCells:
    """Return one blob of the cells of several, at least one."""
    return BlobCells(
        np.concatenate([cells.rows for cells in blobs]),
        np.concatenate([cells.columns for cells in blobs]),
        np.concatenate([cells.counts for cells in blobs]),
    )


def find_blobs(
    anomaly_count: NDArray[np.uint16], minimum_count: int = 1, gap_cells: int = 1, at_most: int = MAX_SIGHTINGS
) -> list[BlobCells]:
    """Return the largest connected sets of cells that at least ``minimum_count`` frames mark, in falling order of size.

    Args:
        anomaly_count: number of frames that mark each cell, shape (rows, columns).
        minimum_count: at least 1.
        gap_cells: cells belong together when at most so many unmarked ones lie between them in a row, a column or a
            diagonal; 0 is plain 8-connectivity. Two pixels that touch at a corner of their image can come to lie one
            cell apart on a raster turned against it, hence the default. Gaps do not count as area.
        at_most: smaller ones are left out.
    """
    marked = (anomaly_count >= minimum_count).view(np.uint8)
    column, row, width, height = cv2.boundingRect(marked)
    if width == 0:
        return []
    window = marked[row : row + height, column : column + width]
    # Boxes of edge k grown from two cells touch when the cells are at most k apart, so k = gap + 1.
    edge = gap_cells + 1
    grown = cv2.dilate(window, np.ones((edge, edge), dtype=np.uint8), anchor=(0, 0), borderType=cv2.BORDER_CONSTANT)
    labels = cv2.connectedComponents(grown, connectivity=8)[1]
    rows, columns = np.nonzero(window)
    label_of_cell = labels[rows, columns]
    sizes = np.bincount(label_of_cell)
    largest = np.argsort(-sizes, kind="stable")[: min(at_most, np.count_nonzero(sizes))]
    rows, columns = rows + row, columns + column
    counts = anomaly_count[rows, columns]
    members = [label_of_cell == label for label in largest]
    return [BlobCells(rows[chosen], columns[chosen], counts[chosen]) for chosen in members]
