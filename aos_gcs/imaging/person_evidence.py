"""What is known of a warm body, as a few numbers that tell persons from animals and stones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aos_gcs.imaging.warmth import WarmView


@dataclass(frozen=True, slots=True)
class Evidence:
    """A warm body as the frames of one or several steps show it."""

    views: int
    """Frames that show it."""
    vehicles: int
    """Vehicles that took them."""
    area_m2: float
    """Largest area that one frame shows of it, on the focal plane; a lower bound of its size."""
    extent_m: float
    """Largest distance of two warm pixels in one frame, along an axis of the grid; a lower bound of its length."""
    contrast_low_k: float
    """10 % of its pixels differ less from the background."""
    contrast_median_k: float
    contrast_high_k: float
    """10 % of its pixels differ more."""
    colour_score: float
    """Median squared Mahalanobis distance of its colours to those of the frames; NaN without colour."""


def gather_evidence(body: Sequence[WarmView]) -> Evidence:
    """Return what the views of one warm body, at least one, tell about it."""
    contrast_k = np.concatenate([view.contrast_k for view in body])
    low_k, median_k, high_k = np.quantile(contrast_k, [0.1, 0.5, 0.9])
    return Evidence(
        views=len(body),
        vehicles=len({view.vehicle_id for view in body}),
        area_m2=max(view.area_m2 for view in body),
        extent_m=max(float(np.ptp(view.points_enu_m, axis=0).max()) for view in body),
        contrast_low_k=float(low_k),
        contrast_median_k=float(median_k),
        contrast_high_k=float(high_k),
        colour_score=float(np.median(np.concatenate([view.colour_score for view in body]))),
    )
