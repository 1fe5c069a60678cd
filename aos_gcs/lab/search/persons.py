"""Places of the persons that are searched for: anywhere in the area, or about a last known point."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import AmslM
from aos_gcs.prior.file import Polygon, lay_over
from aos_gcs.prior.model import AreaPrior
from aos_gcs.prior.shapes import RingPrior

FloatArray = NDArray[np.float64]

RATIOS: Final = (0.35, 1.0, 1.9, 5.9)
"""Distances within which 25, 50, 75 and 95 % of the persons are, as multiples of the second: lost persons are spread
with a long tail."""
_ORIGIN: Final = GeodeticPosition(48.3, 14.3, AmslM(0.0))


def person_about_a_point(area_enu_m: Polygon, spread: float, rng: np.random.Generator) -> tuple[FloatArray, AreaPrior]:
    """Return the place of a person, drawn from a prior about a last known point anywhere in the area, and the prior.

    Args:
        area_enu_m: square area about the origin.
        spread: median distance of persons from the point, as a share of the side.
        rng: random generator.
    """
    half_m = area_enu_m[2][0]
    point_m = rng.uniform(-half_m, half_m, 2)
    place = LocalFrame(_ORIGIN).to_geodetic((*point_m, 0.0))
    near_m, median_m, far_m, tail_m = (2.0 * half_m * spread * ratio for ratio in RATIOS)
    rings = RingPrior((place.latitude_deg, place.longitude_deg), (near_m, median_m, far_m, tail_m))
    prior = lay_over(rings, _ORIGIN, area_enu_m)
    cell = int(rng.choice(prior.mass.size, p=prior.mass.ravel() / prior.mass.sum()))
    row, column = divmod(cell, prior.mass.shape[1])
    east, north = rng.uniform(0.0, 1.0, 2)
    drawn_m = np.array([prior.west_m + (column + east) * prior.cell_m, prior.north_m - (row + north) * prior.cell_m])
    return np.clip(drawn_m, -half_m, half_m), prior


def person_anywhere(hectares: float, rng: np.random.Generator) -> FloatArray:
    """Return the place of a person anywhere in a square area about the origin, shape (2,)."""
    return rng.uniform(-0.5, 0.5, 2) * math.sqrt(hectares * 1e4)
