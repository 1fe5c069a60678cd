"""Figures of the study of detectability: the law that fits, and how far it is from what was observed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aos_gcs.errors import ConfigurationError
from aos_gcs.groundmap.detection import DETECTABILITY, Detectability, Posture
from aos_gcs.groundmap.directions import ViewDirections
from aos_gcs.lab.detectability.calibration import (
    DetectionTrials,
    LawCalibration,
    calibrate,
    fit,
    log_likelihood,
    looks_at,
    occlusion_by_density,
    predicted,
)
from aos_gcs.lab.detectability.study import WatchedForest

STEPS = (0.12, 0.09, 0.06, 0.045, 1.0 / 32.0)
"""Edges of squares of directions that are compared."""
LEAST_FORESTS = 4
"""Fewest forests: two halves of two."""


@dataclass(frozen=True, slots=True)
class PostureFigures:
    """Figures about one posture."""

    posture: Posture
    persons: int
    fitted: Detectability
    """Law that fits all forests."""
    held_out: LawCalibration
    """Predictions for each half of the forests, by the law that fits the other half."""
    shipped: LawCalibration
    """Predictions by the law that the program uses."""
    likelihoods: tuple[float, ...]
    """Mean log-likelihood of the held-out predictions, by edge of the squares as in ``STEPS``."""


@dataclass(frozen=True, slots=True)
class DetectabilityFigures:
    """Figures of a study."""

    forests: int
    occlusion: tuple[tuple[float, float], ...]
    """Trees per hectare, and share of the ground that one image does not see."""
    postures: tuple[PostureFigures, ...]


def summarise(forests: Sequence[WatchedForest], threshold_m2: float, step: float) -> DetectabilityFigures:
    """Return the figures of a study.

    Args:
        forests: watched forests; those of even seeds are one half, those of odd ones the other.
        threshold_m2: marked area from which a person counts as noticed.
        step: edge of a square of directions.

    Raises:
        ConfigurationError: there are too few forests.
    """
    halves = [[one for one in forests if one.key.seed % 2 == rest] for rest in (0, 1)]
    if min(map(len, halves)) < LEAST_FORESTS // 2:
        raise ConfigurationError(f"--forests: at least {LEAST_FORESTS} are needed, of even and odd seeds.")
    occlusion = occlusion_by_density(forests)
    postures = []
    for posture in Posture:

        def looks(part: Sequence[WatchedForest], edge: float, posture: Posture = posture) -> DetectionTrials:
            directions = ViewDirections(edge)
            return looks_at(part, posture, occlusion, threshold_m2=threshold_m2, directions=directions)

        everything = looks(forests, step)
        joined, prediction = _held_out(*(looks(half, step) for half in halves))
        likelihoods = []
        for edge in STEPS:
            likelihoods.append(log_likelihood(*_held_out(*(looks(half, edge) for half in halves))))
        postures.append(
            PostureFigures(
                posture=posture,
                persons=sum(one.posture is posture for forest in forests for one in forest.persons),
                fitted=fit(everything),
                held_out=calibrate(joined, prediction),
                shipped=calibrate(everything, predicted(everything, DETECTABILITY[posture])),
                likelihoods=tuple(likelihoods),
            )
        )
    return DetectabilityFigures(len(forests), tuple(occlusion.items()), tuple(postures))


def _held_out(
    one: DetectionTrials, other: DetectionTrials
) -> tuple[DetectionTrials, np.ndarray[tuple[int], np.dtype[np.float64]]]:
    """Return the looks of both halves, and the probabilities by the law that fits the other half."""
    joined = DetectionTrials(
        np.concatenate((one.views, other.views)),
        np.concatenate((one.occlusion, other.occlusion)),
        np.concatenate((one.noticed, other.noticed)),
    )
    return joined, np.concatenate((predicted(one, fit(other)), predicted(other, fit(one))))


def as_markdown(figures: DetectabilityFigures) -> str:
    """Return the figures as tables."""
    shares = ", ".join(f"{hidden:.2f} at {density:g}/ha" for density, hidden in figures.occlusion)
    lines = [
        f"{figures.forests} forests; one image does not see {shares}.",
        "",
        "| posture | persons | r0 | s | g | error, held out | error of the program's law |",
        "|---|---|---|---|---|---|---|",
    ]
    for one in figures.postures:
        law = one.fitted
        lines.append(
            f"| {one.posture} | {one.persons} | {law.worth:.3f} | {law.slope:.2f} | {law.shape:.2f} | "
            f"{one.held_out.error:.3f} | {one.shipped.error:.3f} |"
        )
    lines += ["", "| posture | predicted, held out: noticed (looks) |", "|---|---|"]
    for one in figures.postures:
        bins = ", ".join(f"{mean:.2f}: {share:.2f} ({count})" for mean, share, count in one.held_out.bins)
        lines.append(f"| {one.posture} | {bins} |")
    edges = " | ".join(f"{edge:.3f}" for edge in STEPS)
    lines += ["", f"| log-likelihood, held out, by edge of the squares | {edges} |", "|---" * (len(STEPS) + 1) + "|"]
    for one in figures.postures:
        lines.append(f"| {one.posture} | {' | '.join(f'{value:.4f}' for value in one.likelihoods)} |")
    return "\n".join(lines) + "\n"
