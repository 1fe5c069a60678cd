"""Fit of the model of detection to watched persons, and how far its predictions are from what was observed.

A person counts as noticed after some views when what these have marked of him, together, reaches the area from which
missions follow a target. Views are taken in random order, so that each person tells of every number of views.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from aos_gcs.groundmap.detection import Detectability, Posture, detection_by_views
from aos_gcs.groundmap.directions import ViewDirections
from aos_gcs.lab.detectability.study import WatchedForest, WatchedPerson

ORDERS: Final = 10
"""Random orders of each person's views."""
_LEAST: Final = 1e-6
"""Smallest probability that counts: one observation must not rule out a law."""
BINS: Final = 10
"""Bins of predicted probability in which predictions are compared with frequencies."""


@dataclass(frozen=True, slots=True)
class DetectionTrials:
    """Numbers of independent views of persons, and whether they were noticed by then."""

    views: NDArray[np.int64]
    """Shape (n,)."""
    occlusion: NDArray[np.float64]
    """Share of the ground that one image does not see in the forest, shape (n,)."""
    noticed: NDArray[np.bool_]
    """Shape (n,)."""


def occlusion_by_density(forests: Iterable[WatchedForest]) -> dict[float, float]:
    """Return the share of lying persons that single views do not see, by trees per hectare: they lie on the ground."""
    seen: dict[float, list[float]] = {}
    for forest in forests:
        for person in forest.persons:
            if person.posture is Posture.LYING:
                shares = np.array(person.seen_m2) / np.array(person.whole_m2)
                seen.setdefault(forest.key.trees_per_ha, []).append(float(shares.mean()))
    return {density: 1.0 - float(np.mean(shares)) for density, shares in sorted(seen.items())}


def looks_at(
    forests: Sequence[WatchedForest],
    posture: Posture,
    occlusion: Mapping[float, float],
    *,
    threshold_m2: float,
    directions: ViewDirections,
) -> DetectionTrials:
    """Return what views of the persons of a posture have shown, one after the other.

    Args:
        forests: watched forests.
        posture: posture; persons of others are left out.
        occlusion: share of the ground that one image does not see, by trees per hectare.
        threshold_m2: marked area from which a person counts as noticed.
        directions: squares of directions that are counted.
    """
    views: list[int] = []
    hidden: list[float] = []
    noticed: list[bool] = []
    for forest in forests:
        rng = np.random.default_rng([forest.key.seed, round(forest.key.trees_per_ha)])
        for person in forest.persons:
            if person.posture is posture:
                own = _looks_at_one(person, threshold_m2, directions, rng)
                views += [count for count, _ in own]
                noticed += [is_noticed for _, is_noticed in own]
                hidden += [occlusion[forest.key.trees_per_ha]] * len(own)
    return DetectionTrials(np.array(views, dtype=np.int64), np.array(hidden), np.array(noticed, dtype=np.bool_))


def _looks_at_one(
    person: WatchedPerson, threshold_m2: float, directions: ViewDirections, rng: np.random.Generator
) -> list[tuple[int, bool]]:
    """Return numbers of independent views of a person, and whether these have noticed him, in random orders."""
    place = np.zeros((1, 3))
    squares = [int(directions.squares(np.array([*tangent, 1.0]), place)[0][0]) for tangent in person.tangents]
    looks = []
    for _ in range(ORDERS):
        marked: set[int] = set()
        seen: set[int] = set()
        for view in rng.permutation(len(squares)):
            marked.update(person.marked[view])
            seen.add(squares[view])
            looks.append((len(seen), len(marked) * person.cell_m2 >= threshold_m2))
    return looks


def predicted(looks: DetectionTrials, model: Detectability) -> NDArray[np.float64]:
    """Return the probability of detection that a model gives to each look, shape (n,)."""
    result = np.empty(len(looks.views))
    for hidden in np.unique(looks.occlusion):
        chosen = looks.occlusion == hidden
        result[chosen] = detection_by_views(float(hidden), model)[looks.views[chosen]]
    return result


def fit(looks: DetectionTrials) -> Detectability:
    """Return the model of the greatest likelihood."""

    def model(x: NDArray[np.float64]) -> Detectability:
        return Detectability(*(float(value) for value in np.exp(x)))

    def loss(x: NDArray[np.float64]) -> float:
        return -log_likelihood(looks, predicted(looks, model(x)))

    found = minimize(loss, np.zeros(3), method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-7})
    return model(found.x)


@dataclass(frozen=True, slots=True)
class LawCalibration:
    """Predictions beside what was observed."""

    bins: tuple[tuple[float, float, int], ...]
    """Mean prediction, share noticed and number of looks, by bins of predicted probability."""
    error: float
    """Mean absolute difference of prediction and share over the bins, weighted by their looks."""


def calibrate(looks: DetectionTrials, prediction: NDArray[np.float64]) -> LawCalibration:
    """Compare predicted probabilities, shape (n,), with what was observed."""
    p = prediction
    index = np.minimum((p * BINS).astype(int), BINS - 1)
    rows = [
        (float(p[index == one].mean()), float(looks.noticed[index == one].mean()), int((index == one).sum()))
        for one in np.unique(index)
    ]
    error = sum(abs(mean - share) * count for mean, share, count in rows) / len(p)
    return LawCalibration(tuple(rows), float(error))


def log_likelihood(looks: DetectionTrials, prediction: NDArray[np.float64]) -> float:
    """Return the mean logarithm of the probability that was predicted for what was observed."""
    p = np.clip(prediction, _LEAST, 1.0 - _LEAST)
    return float(np.where(looks.noticed, np.log(p), np.log(1.0 - p)).mean())
