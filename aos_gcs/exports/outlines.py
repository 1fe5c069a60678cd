"""Outlines of regions of a raster along the edges of their cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Ring = tuple[tuple[int, int], ...]
"""Corners (row, column) of cells; the last one is joined to the first."""


def outlines(labels: NDArray[np.integer]) -> dict[int, list[Ring]]:
    """Return the rings of each region: the outer one first, counter-clockwise with north up, then holes, clockwise.

    Args:
        labels: region of each cell, connected over edges, shape (rows, columns); 0 belongs to none.
    """
    rings: dict[int, list[Ring]] = {}
    for label, following in _edges(np.pad(labels, 1)).items():
        while following:
            rings.setdefault(label, []).append(_ring(following))
    # Only the outer ring has a positive area.
    return {label: sorted(found, key=_area, reverse=True) for label, found in rings.items()}


_Corner = tuple[int, int]


def _edges(padded: NDArray[np.integer]) -> dict[int, dict[_Corner, list[_Corner]]]:
    """Return the edges between a region and what is not, by region and starting corner, the region on their left."""
    edges: dict[int, dict[_Corner, list[_Corner]]] = {}
    # Neighbour of a cell, and start and end of the edge towards it, with rows counted southwards.
    sides = (
        ((1, 0), (1, 0), (1, 1)),
        ((0, 1), (1, 1), (0, 1)),
        ((-1, 0), (0, 1), (0, 0)),
        ((0, -1), (0, 0), (1, 0)),
    )
    for (down, right), start, end in sides:
        differs = (padded != np.roll(padded, (-down, -right), axis=(0, 1))) & (padded > 0)
        for row, column in np.argwhere(differs) - 1:
            label = int(padded[row + 1, column + 1])
            begin = int(row) + start[0], int(column) + start[1]
            edges.setdefault(label, {}).setdefault(begin, []).append((int(row) + end[0], int(column) + end[1]))
    return edges


def _ring(following: dict[_Corner, list[_Corner]]) -> Ring:
    """Take a ring out of edges, and return its corners without those on straight lines."""
    start = here = next(iter(following))
    direction = (0, 0)
    corners: list[_Corner] = []
    while True:
        ends = following[here]
        # Where two cells meet at a corner, a right turn goes on with the other cell: no ring comes to a corner twice.
        right = here[0] + direction[1], here[1] - direction[0]
        end = right if right in ends else ends[0]
        ends.remove(end)
        if not ends:
            del following[here]
        turned = end[0] - here[0], end[1] - here[1]
        if turned != direction:
            corners.append(here)
        here, direction = end, turned
        if here == start:
            break
    first = corners[1][0] - corners[0][0], corners[1][1] - corners[0][1]
    is_straight = direction[0] * first[1] == direction[1] * first[0]
    return tuple(corners[1:] if is_straight else corners)


def _area(ring: Ring) -> float:
    """Return the signed area of a ring, positive counter-clockwise with north up, in cells."""
    rows, columns = np.array(ring, dtype=np.float64).T
    return float(np.sum(np.roll(columns, -1) * rows - columns * np.roll(rows, -1)) / 2.0)
