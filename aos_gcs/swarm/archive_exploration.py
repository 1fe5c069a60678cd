"""Where drones that explore should look next: at what nobody has looked through yet, and beside what was seen well."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm.archive_raster import BoolArray, FloatArray
from aos_gcs.swarm.archive_selection import Outlook

PRIOR_VISIBILITY = 0.2
"""Share of a target that a view through an unknown part of a forest shows: 0.16 in the simulator's at 300 trees/ha."""
PRIOR_WEIGHT = 0.3
"""Of that share, in looks."""
KNOWN = 0.9
"""Familiarity from which it is not worth looking again."""
SAMPLED = 0.5
"""Familiarity from which a spot of the aperture counts as sampled."""
TIE_BREAK = 1e-3
"""Random part of a spot's value, so that equal ones do not draw all drones into one corner."""


@lru_cache(maxsize=8)
def lattice(radius_m: float, pitch_m: float) -> FloatArray:
    """Return the points of a triangular lattice within a circle about the origin, shape (n, 2)."""
    reach = int(2.0 * radius_m / pitch_m) + 2
    column, row = np.meshgrid(np.arange(-reach, reach + 1), np.arange(-reach, reach + 1))
    points = pitch_m * np.column_stack([(column + 0.5 * row).ravel(), (np.sqrt(0.75) * row).ravel()])
    points = np.asarray(points[np.linalg.norm(points, axis=1) <= radius_m])
    points.flags.writeable = False
    return points


def kernel(distances_m: FloatArray, width_m: float) -> FloatArray:
    """Return how much lines of sight at these distances tell about each other, from 0 to 1."""
    return np.asarray(np.exp(-0.5 * (distances_m / width_m) ** 2))


def predicted(weights: FloatArray, masks: NDArray[np.floating], footprints: NDArray[np.floating]) -> FloatArray:
    """Return the probability of each cell to be seen from places nobody has looked from: kernel regression.

    Args:
        weights: of k looks for p places, shape (p, k).
        masks: what the looks have shown, shape (k, cells).
        footprints: what the places would show without forest, shape (p, cells).
    """
    evidence = weights @ masks + PRIOR_WEIGHT * PRIOR_VISIBILITY * footprints
    return np.asarray(np.minimum(evidence / (weights.sum(axis=1) + PRIOR_WEIGHT)[:, None], 1.0))


def values(
    outlook: Outlook,
    shown: FloatArray,
    footprints: NDArray[np.floating],
    familiarity: FloatArray,
    never_seen: NDArray[np.floating],
    *,
    area_exponent: float,
    curiosity: float,
    history_weight: float,
) -> FloatArray:
    """Return what looking from places is worth, shape (p,): the expected gain, and more where less is known.

    Args:
        outlook: of the views that are held.
        shown: expected, see :func:`predicted`, shape (p, cells).
        footprints: shape (p, cells).
        familiarity: greatest weight of any look, shape (p,); places that are known have a value of minus infinity.
        never_seen: 1 for cells that no look has shown, else 0, shape (cells,).
        area_exponent: see :func:`aos_gcs.swarm.archive_selection.score`.
        curiosity: value of a place nothing is known about, in shares of the score.
        history_weight: value of showing what was never seen, for as much of it as is seen now.
    """
    held = max(outlook.score(area_exponent), 1e-9)
    gains = outlook.scores_with(shown, footprints, area_exponent) / held - 1.0
    new_shares = shown @ never_seen / max(float(np.sum(1.0 - outlook.hidden)), 1.0)
    # Before anything is held every gain would be infinite.
    value = np.minimum(gains, 1.0) + curiosity * (1.0 - familiarity) + history_weight * np.minimum(new_shares, 1.0)
    return np.where(familiarity > KNOWN, -np.inf, value)


def choose_goals(
    value: FloatArray,
    places_m: FloatArray,
    explorers: FloatArray,
    taken_m: FloatArray,
    *,
    spacing_m: float,
    cost_per_m: float,
) -> list[int | None]:
    """Return the index of the place that each explorer should go to; None where none is left.

    Args:
        value: of the places, shape (p,); minus infinity for those not worth it.
        places_m: on one plane, shape (p, 2).
        explorers: where each explorer is, or the way to go: its distance to every place, shape (e, p).
        taken_m: where others will be on that plane, shape (t, 2).
        spacing_m: distance that goals keep from each other and from those.
        cost_per_m: what a metre of way costs, in units of value.
    """
    open_places = value > -np.inf
    open_places &= _clear_of(places_m, taken_m, spacing_m)
    goals: list[int | None] = []
    for ways_m in explorers:
        worth = np.where(open_places, value - cost_per_m * ways_m, -np.inf)
        best = int(worth.argmax())
        if worth[best] == -np.inf:
            goals.append(None)
            continue
        goals.append(best)
        open_places &= _clear_of(places_m, places_m[best : best + 1], spacing_m)
    return goals


def _clear_of(places_m: FloatArray, others_m: FloatArray, spacing_m: float) -> BoolArray:
    distances_m = np.linalg.norm(places_m[:, None] - others_m, axis=2)
    return np.asarray((distances_m >= spacing_m).all(axis=1))
