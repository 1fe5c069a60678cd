"""Probability that the missing person is at a place, before the search."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.geodesy import LocalFrame

FloatArray = NDArray[np.float64]


class Prior(Protocol):
    """Distribution of the person's place over the ground."""

    def density_per_m2(self, frame: LocalFrame, places_enu_m: FloatArray) -> FloatArray:
        """Return the probability per square metre at places, shape (k, 2): over all the ground it adds up to 1 at most.

        Args:
            frame: local frame of the places.
            places_enu_m: horizontal places.
        """
        ...


@dataclass(frozen=True, slots=True, eq=False)
class AreaPrior:
    """Prior within a search area; nothing is beyond it. North-up cells."""

    west_m: float
    north_m: float
    cell_m: float
    mass: NDArray[np.float64]
    """Probability that the person is in the part of the search area that lies in each cell, shape (rows, columns)."""

    @property
    def share(self) -> float:
        """Probability that the person is in the search area."""
        return min(1.0, float(self.mass.sum()))

    def at(self, places_enu_m: FloatArray) -> FloatArray:
        """Return the mass of the cells in which places lie, shape (k, 2); 0 beyond the raster."""
        columns = np.floor((places_enu_m[:, 0] - self.west_m) / self.cell_m).astype(np.int64)
        rows = np.floor((self.north_m - places_enu_m[:, 1]) / self.cell_m).astype(np.int64)
        height, width = self.mass.shape
        is_known = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        return np.where(is_known, self.mass[rows.clip(0, height - 1), columns.clip(0, width - 1)], 0.0)

    def weights(self, places_enu_m: FloatArray) -> FloatArray:
        """Return the weights of places spread evenly over the area, shape (k,): they add up to 1.

        Places of an area in which none has any probability weigh the same.
        """
        values = self.at(places_enu_m)
        total = float(values.sum())
        return values / total if total > 0.0 else np.full(len(values), 1.0 / max(1, len(values)))
