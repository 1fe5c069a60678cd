"""Connected anomalies of a map, all of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.imaging.connected import connected
from aos_gcs.imaging.model import MapRaster
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.surveys.levels import REACH_M
from aos_gcs.surveys.significance import DEFAULT_FALSE_ALARMS_PER_HA, AnomalySums, significance_limit

MAX_MARKED_CELLS = 2_000_000
"""More are no anomalies, but a detector that does not fit the images."""
PERSON_M = 1.8
"""Length of a person, lying: fragments that lie as near are one anomaly."""
LONGER_THAN_A_PERSON_M = 3.0
"""Length that is more than a person's: 1.8 m, stretched arms, and errors of the poses."""
CORE = 0.3
"""Share of the largest significance that the cells of a length have: the more images, the wider chance and errors of
the poses spread what just exceeds the limit."""
_DIRECTIONS = 12
"""Directions in which lengths are measured; between two of them they are 1 % longer."""
_BLOCK_M = 0.45
"""Edge of the blocks of cells that are joined: a quarter of a person."""


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
    significance: float | None = None
    """Largest of its cells, see :mod:`aos_gcs.surveys.significance`; None where it was not computed."""
    length_m: float | None = None
    """Largest distance of its cells that stand out :data:`CORE` as much as the most significant, without the reach of
    marks; None where it was not computed."""

    @property
    def is_longer_than_a_person(self) -> bool:
        """Whether it is no single person: a line, an edge, several things or persons side by side."""
        return self.length_m is not None and self.length_m > LONGER_THAN_A_PERSON_M


def significant_blobs(
    sums: AnomalySums,
    significances: NDArray[np.float32],
    coverage: NDArray[np.uint16],
    raster: MapRaster,
    surface: FocalSurface,
    *,
    false_alarms_per_ha: float = DEFAULT_FALSE_ALARMS_PER_HA,
) -> list[MapBlob]:
    """Return what stands out of a map more than chance does, the most significant first.

    Args:
        sums: marks of the images.
        significances: see :func:`~aos_gcs.surveys.significance.significance`.
        coverage: images that see each cell.
        raster: raster of the cells.
        surface: surface that the map shows.
        false_alarms_per_ha: places per hectare at which chance may exceed the limit.

    Raises:
        ImagingError: if so much stands out that nothing does.
        ConfigurationError: if the rate cannot be.
    """
    rows, columns = np.nonzero(significances > significance_limit(false_alarms_per_ha))
    if rows.size > MAX_MARKED_CELLS:
        raise ImagingError(
            f"{rows.size} cells stand out as anomalies, more than {MAX_MARKED_CELLS}: allow fewer false alarms per "
            "hectare, or choose a coarser map."
        )
    if not rows.size:
        return []
    labels = _joined(rows, columns, raster.resolution_m)
    size, cells = int(labels.max()) + 1, raster.resolution_m**2
    strength = significances[rows, columns].astype(np.float64)
    weights = np.bincount(labels, strength)
    means = (np.bincount(labels, strength * axis) / weights for axis in (columns, rows))
    x_m, y_m, _ = raster.to_plane @ np.stack((*means, np.ones(size)))
    z_m = surface.z_m(x_m, y_m)
    areas_m2 = np.bincount(labels) * cells
    counts = sums.count[rows, columns].astype(np.float64)
    agreement = np.bincount(labels, counts) / np.bincount(labels, coverage[rows, columns].astype(np.float64))
    peak, most = np.zeros(size), np.zeros(size)
    np.maximum.at(peak, labels, strength)
    np.maximum.at(most, labels, counts)
    core = strength >= CORE * peak[labels]
    lengths_m = np.maximum(raster.resolution_m * _lengths(rows[core], columns[core], labels[core]) - 2.0 * REACH_M, 0.0)
    return [
        MapBlob(
            (float(x_m[i]), float(y_m[i]), float(z_m[i])),
            float(areas_m2[i]),
            int(most[i]),
            float(agreement[i]),
            float(peak[i]),
            float(lengths_m[i]),
        )
        for i in np.argsort(-peak, kind="stable")
    ]


def _lengths(rows: NDArray[np.intp], columns: NDArray[np.intp], labels: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the largest extent of each set of cells in any direction, in cells, shape (sets,)."""
    order = np.argsort(labels, kind="stable")
    starts = np.flatnonzero(np.diff(labels[order], prepend=-1))
    lengths = np.zeros(len(starts))
    for angle_rad in np.linspace(0.0, math.pi, _DIRECTIONS, endpoint=False):
        along = math.cos(angle_rad) * columns[order] + math.sin(angle_rad) * rows[order]
        extents = np.maximum.reduceat(along, starts) - np.minimum.reduceat(along, starts)
        np.maximum(lengths, extents, out=lengths)
    return lengths + 1.0


def _joined(rows: NDArray[np.intp], columns: NDArray[np.intp], cell_m: float) -> NDArray[np.intp]:
    """Return the number of the set of each cell, shape (n,): those within a person's length are one."""
    edge = max(1, round(_BLOCK_M / cell_m))
    blocks, of_cell = np.unique(np.stack((rows // edge, columns // edge)), axis=1, return_inverse=True)
    labels = connected(blocks[0], blocks[1], max(1.0, PERSON_M / (edge * cell_m)))
    return np.asarray(labels[of_cell.reshape(-1)], dtype=np.intp)
