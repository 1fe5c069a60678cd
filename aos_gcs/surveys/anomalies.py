"""Connected anomalies of a map, all of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.imaging.connected import connected
from aos_gcs.imaging.model import GroundRaster
from aos_gcs.imaging.views import FocalSurface

MAX_MARKED_CELLS = 2_000_000
"""More are no anomalies, but a detector that does not fit the images."""


@dataclass(frozen=True, slots=True)
class MapBlob:
    """A connected anomaly on the focal surface."""

    position_m: tuple[float, float, float]
    """Mean of its cells, weighted by the frames that mark them; in the world of the poses."""
    area_m2: float
    max_count: int
    """The largest number of frames that agree on one cell."""
    agreement: float
    """Share of the frames that see its cells and mark them, 0 to 1."""


def map_blobs(
    anomaly_count: NDArray[np.uint16],
    coverage: NDArray[np.uint16],
    raster: GroundRaster,
    surface: FocalSurface,
    *,
    minimum_count: int = 1,
    gap_cells: int = 1,
) -> list[MapBlob]:
    """Return the blobs of a map, the largest first.

    Args:
        anomaly_count: frames that mark each cell, shape (rows, columns).
        coverage: frames that see each cell, of the same shape.
        raster: raster of the cells.
        surface: surface that the map shows.
        minimum_count: frames that must mark a cell.
        gap_cells: cells belong together as in :func:`~aos_gcs.imaging.step.blobs.find_blobs`.

    Raises:
        ImagingError: if so much is marked that nothing stands out.
    """
    rows, columns = np.nonzero(anomaly_count >= minimum_count)
    if rows.size > MAX_MARKED_CELLS:
        raise ImagingError(
            f"{rows.size} cells are marked as anomalies, more than {MAX_MARKED_CELLS}: ask for more frames that must "
            "agree on a cell, or for a coarser map."
        )
    if not rows.size:
        return []
    counts, seen = anomaly_count[rows, columns].astype(float), coverage[rows, columns].astype(float)
    labels = connected(rows, columns, gap_cells + 1, math.inf)
    count = int(labels.max()) + 1
    weights = np.bincount(labels, counts)
    mean_column = np.bincount(labels, counts * columns) / weights
    mean_row = np.bincount(labels, counts * rows) / weights
    x_m, y_m, _ = raster.to_plane @ np.stack((mean_column, mean_row, np.ones(count)))
    z_m = surface.z_m(x_m, y_m)
    areas_m2 = np.bincount(labels) * raster.resolution_m**2
    largest = np.zeros(count)
    np.maximum.at(largest, labels, counts)
    agreement = weights / np.bincount(labels, seen)
    return [
        MapBlob((float(x_m[i]), float(y_m[i]), float(z_m[i])), float(areas_m2[i]), int(largest[i]), float(agreement[i]))
        for i in np.argsort(-areas_m2, kind="stable")
    ]
