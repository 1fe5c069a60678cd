"""Probability of detection: how likely a person at a place would have been noticed, by the views that the place got.

The law is that of search theory, P = 1 - exp(-C) with the coverage C (Koopman, *Search and Screening*, 1946), here with
C = (n r)^g: n independent views, each of the worth r = r0 (1 - D)^s with the occlusion D, the share of the ground that
one image does not see. As fitted s and g are 1: views are worth what they see, and neither help nor repeat each other.

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
    """Worth r0 of one view where all of the ground is seen."""
    slope: float = 1.0
    """Exponent s of the share of the ground that is seen."""
    shape: float = 1.0
    """Exponent g of the coverage: above 1 what several views mark adds up, below it places differ."""


DETECTABILITY: Final = {
    Posture.STANDING: Detectability(0.57),
    Posture.SITTING: Detectability(0.86),
    Posture.LYING: Detectability(2.5),
}
"""Postures differ in the worth of a view alone."""


def detection_by_views(occlusion: float, known: Detectability) -> NDArray[np.float64]:
    """Return the probability of detection after 0, 1, 2 … ``MAX_VIEWS`` independent views, shape (256,).

    Args:
        occlusion: share of the ground that one image does not see, 0 to 1.
        known: how well views show a person of the posture.
    """
    worth = known.worth * (1.0 - occlusion) ** known.slope
    return np.asarray(1.0 - np.exp(-((np.arange(MAX_VIEWS + 1) * worth) ** known.shape)))
