"""The ground among the spots of a scene: their lowest layer, if it is one.

Trunks leave a gap between the ground and the crowns: spots of the ground lie in a thin layer with little close above it
and nothing below. Crowns are thick, and stand out of single frames more than the ground does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.focus.geometry import COMMON_SIGMA_M, MAX_SLOPE
from aos_gcs.imaging.focus.spots import Spots

MAX_SPOT_SIGMA_M = 1.5
"""Spots whose heights are known worse than that take no part."""

SEED_SIGNIFICANCE, MIN_SIGNIFICANCE = 9.0, 40.0
"""Significance of a spot from which a layer is looked for about it, and the sum over a layer that makes it one.

Where rays meet by chance, in recorded and simulated frames turned against each other, single spots reach 8.
"""

MIN_SPOTS = 3
SLOPE_SIGMA = 0.3
"""Standard deviation of the ground's slopes, before its spots are known."""

ROUGHNESS_M = 0.5
"""Standard deviation of spots about the plane of the ground: things stand on it, and it is not flat."""

GATE_SIGMAS, THICKNESS_M = 2.5, 2.0
"""Distances from its plane up to which spots belong to a layer, whichever is smaller."""

LOW_M, TRUNKS_M = 1.5, 6.0
"""Heights above a layer between which the ground has few spots."""

MAX_ABOVE, MAX_BELOW = 0.2, 0.1
"""Significance between the trunks and below the layer, as shares of that of the layer, up to which it is the ground."""

MAX_SCATTER = 1.2
"""Mean square of the distances from its plane, in standard deviations, from which on a layer is as thick as crowns."""

CROWNS_SIGNIFICANCE = 80.0
"""Sum over the spots close above a height, or below it, from which it is not the ground: chance alone makes some."""

MIN_SEEN_THROUGH = 2
"""Spots below any slope of the ground that show that it is lower: there is nothing below it."""

MAX_SIGMA_M = 1.0
"""Standard deviation of the height at the region's centre from which on spots elsewhere do not tell it."""

_ROUNDS = 10


@dataclass(frozen=True, slots=True)
class GroundLayer:
    """Lowest layer of spots."""

    height_m: float
    """z at the region's centre."""
    sigma_m: float
    """Standard deviation of the height."""
    significance: float
    """Sum over its spots."""


@dataclass(frozen=True, slots=True, eq=False)
class _Plane:
    """Height at the centre and slopes along x and y, with their covariance."""

    estimate: NDArray[np.float64]
    covariance: NDArray[np.floating]
    members: NDArray[np.bool_]
    gaps_m: NDArray[np.float64]
    """Heights of all spots above it, shape (n,)."""


def ground_layer(spots: Spots, centre_m: NDArray[np.float64]) -> GroundLayer | None:
    """Return the lowest layer of spots if it has the marks of the ground; None otherwise.

    Args:
        spots: spots of the whole range, crowns included.
        centre_m: x and y of the region's centre.
    """
    known = spots.sigmas_m < MAX_SPOT_SIGMA_M
    heights_m, sigmas_m = spots.up * spots.points_m[known, 2], spots.sigmas_m[known]
    significances = spots.significances[known]
    rows = np.column_stack((np.ones(len(heights_m)), spots.points_m[known, :2] - centre_m))
    for seed in np.argsort(heights_m, kind="stable"):
        if significances[seed] < SEED_SIGNIFICANCE:
            continue
        plane = _plane_about(int(seed), rows, heights_m, sigmas_m)
        total = float(significances[plane.members].sum())
        if total < MIN_SIGNIFICANCE or int(plane.members.sum()) < MIN_SPOTS:
            continue
        above = float(significances[(plane.gaps_m > LOW_M) & (plane.gaps_m < TRUNKS_M)].sum())
        below = float(significances[plane.gaps_m < -LOW_M].sum())
        if above > MAX_ABOVE * total or below > MAX_BELOW * total:
            continue
        scatter = _scatter(plane, sigmas_m)
        sigma_m = math.sqrt(float(plane.covariance[0, 0]) * max(scatter, 1.0) + COMMON_SIGMA_M**2)
        if scatter > MAX_SCATTER or sigma_m > MAX_SIGMA_M:
            continue
        return GroundLayer(spots.up * float(plane.estimate[0]), sigma_m, total)
    return None


def is_among_crowns(spots: Spots, height_m: float) -> bool:
    """Return whether many spots lie close above a level plane, or below it: then it is not the ground."""
    gaps_m = spots.up * (spots.points_m[:, 2] - height_m)
    on_it = float(spots.significances[np.abs(gaps_m) <= LOW_M].sum())
    above = float(spots.significances[(gaps_m > LOW_M) & (gaps_m < TRUNKS_M)].sum())
    below = float(spots.significances[gaps_m < -LOW_M].sum())
    return max(above, below) >= max(CROWNS_SIGNIFICANCE, MAX_ABOVE * on_it)


def is_seen_through(spots: Spots, height_m: float, centre_m: NDArray[np.float64]) -> bool:
    """Return whether spots beyond chance lie further below a height than the steepest ground falls from there.

    Args:
        spots: spots of the whole range.
        height_m: z in question.
        centre_m: x and y of the region's centre, where that height was found.
    """
    sure = (spots.significances >= SEED_SIGNIFICANCE) & (spots.sigmas_m < MAX_SPOT_SIGMA_M)
    depths_m = spots.up * (height_m - spots.points_m[:, 2])
    falls_m = MAX_SLOPE * np.linalg.norm(spots.points_m[:, :2] - centre_m, axis=1)
    return int(np.count_nonzero(sure & (depths_m > falls_m + LOW_M))) >= MIN_SEEN_THROUGH


def _plane_about(
    seed: int, rows: NDArray[np.float64], heights_m: NDArray[np.float64], sigmas_m: NDArray[np.float64]
) -> _Plane:
    """Fit a plane to the spots that agree with one of them."""
    members = np.zeros(len(heights_m), dtype=bool)
    members[seed] = True
    variances = sigmas_m**2 + ROUGHNESS_M**2
    # What is known of slopes before; of the height, nothing.
    prior = np.diag([1e-6, SLOPE_SIGMA**-2, SLOPE_SIGMA**-2])
    for _ in range(_ROUNDS):
        weighted = rows[members] / variances[members, np.newaxis]
        covariance = np.linalg.inv(prior + weighted.T @ rows[members])
        estimate = covariance @ (weighted.T @ heights_m[members])
        gaps_m = heights_m - rows @ estimate
        spread_m = np.sqrt(np.einsum("ij,jk,ik->i", rows, covariance, rows) + variances)
        agreeing = np.abs(gaps_m) < np.minimum(GATE_SIGMAS * spread_m, THICKNESS_M)
        agreeing[seed] = True
        if np.array_equal(agreeing, members):
            break
        members = agreeing
    return _Plane(estimate, covariance, members, gaps_m)


def _scatter(plane: _Plane, sigmas_m: NDArray[np.float64]) -> float:
    """Return the mean square of how far the spots of a layer lie from its plane, in their standard deviations."""
    own_m2 = sigmas_m[plane.members] ** 2 + ROUGHNESS_M**2
    return float(np.sum(plane.gaps_m[plane.members] ** 2 / own_m2)) / max(int(plane.members.sum()) - 1, 1)
