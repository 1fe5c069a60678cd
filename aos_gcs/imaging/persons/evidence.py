"""Features of a warm body: a few numbers that tell persons from animals and stones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aos_gcs.imaging.persons.warm_bodies import WarmView


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
    contrast_median_k: float
    """Median of its pixels, above the background: clothes, fur, stone."""
    contrast_peak_k: float
    """99 % quantile of its pixels: bare skin, if a frame shows any."""


def gather_evidence(body: Sequence[WarmView]) -> Evidence:
    """Return what the views of one warm body, at least one, tell about it."""
    contrast_k = np.concatenate([view.contrast_k for view in body])
    median_k, peak_k = np.quantile(contrast_k, [0.5, 0.99])
    return Evidence(
        views=len(body),
        vehicles=len({view.vehicle_id for view in body}),
        area_m2=max(view.area_m2 for view in body),
        extent_m=max(float(np.ptp(view.points_enu_m, axis=0).max()) for view in body),
        contrast_median_k=float(median_k),
        contrast_peak_k=float(peak_k),
    )
