"""Probability of detection: how likely a person at a place would have been noticed, by the views that the place got.

The law is that of search theory, P = 1 - exp(-C) with the coverage C (Koopman, *Search and Screening*, 1946), here with
C = (n r)^g: n independent views, each of the worth r. With g > 1 views help each other, since what several mark of a
person adds up; with g < 1 places differ, and further views of a place that is well covered by leaves are of little use.
r grows with the odds of seeing the ground in one image, by a power law.

The numbers are fitted to simulated forests; docs/ground-map.md has the study, and how far the law errs.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.groundmap.tile import MAX_VIEWS


class Posture(StrEnum):
    """Posture of the person that is looked for."""

    STANDING = "standing"
    SITTING = "sitting"
    LYING = "lying"


@dataclass(frozen=True, slots=True)
class Detectability:
    """Worth of views for finding a person of a posture."""

    worth: float
    """Worth r of one view where half of the ground is seen."""
    slope: float
    """Exponent of the odds of seeing the ground in r."""
    shape: float
    """Exponent g of the coverage."""


_SLOPE: Final = 0.80
_SHAPE: Final = 1.04
DETECTABILITY: Final = {
    posture: Detectability(worth, _SLOPE, _SHAPE)
    for posture, worth in ((Posture.STANDING, 0.308), (Posture.SITTING, 0.45), (Posture.LYING, 1.20))
}
"""Postures differ in the worth of a view alone."""
_LEAST_SHARE = 1e-6
"""Share of the ground below which none, or above its complement all, counts as seen: odds are finite."""


def detection_by_views(occlusion: float, known: Detectability) -> NDArray[np.float64]:
    """Return the probability of detection after 0, 1, 2 … ``MAX_VIEWS`` independent views, shape (256,).

    Args:
        occlusion: share of the ground that one image does not see, 0 to 1.
        known: how well views show a person of the posture.
    """
    share = min(max(1.0 - occlusion, _LEAST_SHARE), 1.0 - _LEAST_SHARE)
    worth = known.worth * (share / (1.0 - share)) ** known.slope
    return np.asarray(1.0 - np.exp(-((np.arange(MAX_VIEWS + 1) * worth) ** known.shape)))
