"""Cells of a lattice that belong together because they are near one another."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray


def connected(
    rows: NDArray[np.intp] | NDArray[np.float64],
    columns: NDArray[np.intp] | NDArray[np.float64],
    reach: float,
) -> NDArray[np.intp]:
    """Return the number of the set that each cell belongs to, shape (n,); sets are numbered by their first cells.

    Args:
        rows: rows of the cells, shape (n,).
        columns: columns of the cells, shape (n,).
        reach: largest distance of two cells that belong together, along a straight line, in cells.
    """
    pairs = scipy.spatial.cKDTree(np.column_stack((rows, columns))).query_pairs(reach, output_type="ndarray")
    graph = scipy.sparse.coo_array(
        (np.ones(len(pairs), dtype=np.bool_), (pairs[:, 0], pairs[:, 1])), shape=(len(rows), len(rows))
    )
    return np.asarray(scipy.sparse.csgraph.connected_components(graph, directed=False)[1], dtype=np.intp)
