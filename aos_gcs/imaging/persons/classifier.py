"""Classifier of warm bodies: the probability that one is a person.

A logistic regression on what frames show of a body: how warm it is in the middle, and how much warmer at its warmest
(skin above clothes; a stone is warm all over); how large its visible part, from how many vehicles it is seen. The area
counts up to where blur no longer takes from the contrast: a person in the open is no less one. What a single vehicle
sees is no evidence, and what is hotter than any skin is no person.

The weights are fitted to simulated scenes by ``aos-gcs lab fit-person`` (docs/effectiveness.md); a model for another
season, camera or quarry is another file.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from aos_gcs.errors import InputDataError
from aos_gcs.imaging.persons.evidence import Evidence

FEATURES = (
    "log median contrast",
    "log spread of contrast",
    "log area",
    "log vehicles",
)
MAX_CONTRAST_K = 40.0
"""Skin is at most 37 °C warm, and surroundings in which people are searched for seldom colder than -3 °C."""
MIN_VEHICLES = 2
"""Vehicles that must agree; one alone may see a defective pixel, or a piece of another body beside its place."""
_MIN_CONTRAST_K = 1.0
"""Smallest difference of temperatures that says more than noise and shading."""
_SKIN_K = 5.0
"""Peak above the median from which a body shows skin; the median of simulated persons is 5.3 K. More is no more."""
_AREA_M2 = 0.3
"""Visible area beyond which a body's middle pixels show its own temperature."""
_RIDGE = 1e-3
"""Penalty on the squares of the standardised weights, per observation: keeps them finite where classes separate."""


@dataclass(frozen=True, slots=True)
class PersonModel:
    """Weights of standardised features, in the order of :data:`FEATURES`."""

    centres: tuple[float, ...]
    scales: tuple[float, ...]
    weights: tuple[float, ...]
    bias: float
    fitted_to: str = ""
    """Data that it is fitted to, in words; empty where nobody has said."""
    fitted_on: str = ""
    """Day of the fit, YYYY-MM-DD."""


def person_confidence(evidence: Evidence, model: PersonModel | None = None) -> float:
    """Return the probability, 0 to 1, that a warm body is a person; ``model`` None: the one fitted to simulations.

    What follows from it is said by :func:`aos_gcs.imaging.persons.decision.decide` alone.
    It holds for a body that is as likely a person as not. Where persons are rarer, so is a true alarm.
    """
    if evidence.contrast_peak_k > MAX_CONTRAST_K or evidence.vehicles < MIN_VEHICLES:
        return 0.0
    model = default_model() if model is None else model
    standardised = (_features(evidence) - model.centres) / model.scales
    return float(expit(standardised @ np.array(model.weights) + model.bias))


def fit_person_model(evidence: Sequence[Evidence], is_person: Sequence[bool]) -> PersonModel:
    """Return the model that explains labelled bodies best; both classes weigh the same, however many each has.

    Raises:
        InputDataError: if one of the classes is missing.
    """
    labels = np.array(is_person, dtype=np.float64)
    if not 0.0 < labels.sum() < len(labels):
        raise InputDataError("A model of persons needs bodies of both kinds, persons and others; study more scenes.")
    features = np.array([_features(one) for one in evidence])
    centres, scales = features.mean(axis=0), np.maximum(features.std(axis=0), 1e-9)
    standardised = np.column_stack(((features - centres) / scales, np.ones(len(features))))
    share = np.where(labels == 1.0, 0.5 / labels.sum(), 0.5 / (1.0 - labels).sum())

    def loss(weights: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        score = standardised @ weights
        penalised = np.append(weights[:-1], 0.0)
        value = share @ (np.logaddexp(0.0, score) - labels * score) + _RIDGE / 2 * penalised @ penalised
        return float(value), standardised.T @ (share * (expit(score) - labels)) + _RIDGE * penalised

    # Fitted in the laboratory alone: missions need not load it.
    from scipy.optimize import minimize  # noqa: PLC0415

    fitted = minimize(loss, np.zeros(standardised.shape[1]), jac=True, method="L-BFGS-B")
    return PersonModel(tuple(centres), tuple(scales), tuple(fitted.x[:-1]), float(fitted.x[-1]))


@lru_cache(maxsize=1)
def default_model() -> PersonModel:
    """Return the model that comes with the program."""
    return _parse(
        files("aos_gcs.imaging.persons").joinpath("person_model.json").read_text(encoding="utf-8"), "person_model.json"
    )


def read_model(path: Path) -> PersonModel:
    """Return the model in a file that :func:`write_model` has written.

    Raises:
        InputDataError: if it cannot be read; the text names it.
    """
    try:
        return _parse(path.read_text(encoding="utf-8"), str(path))
    except (OSError, UnicodeDecodeError) as error:
        raise InputDataError(f"Cannot read the model of persons {path}: {error}.") from error


def write_model(path: Path, model: PersonModel) -> None:
    """Write a model as JSON."""
    path.write_text(json.dumps({"features": FEATURES, **asdict(model)}, indent=1) + "\n", encoding="utf-8")


def _parse(text: str, name: str) -> PersonModel:
    try:
        table = json.loads(text)
        if tuple(table["features"]) != FEATURES:
            raise InputDataError(f"The model of persons {name} has other features than this program; fit it anew.")
        centres, scales, weights = (
            tuple(float(value) for value in table[key]) for key in ("centres", "scales", "weights")
        )
        origin = (str(table.get(key, "")) for key in ("fitted_to", "fitted_on"))
        model = PersonModel(centres, scales, weights, float(table["bias"]), *origin)
    except (ValueError, KeyError, TypeError) as error:
        raise InputDataError(f"The model of persons {name} is damaged ({error}); fit it anew.") from error
    if any(len(values) != len(FEATURES) for values in (centres, scales, weights)):
        raise InputDataError(f"The model of persons {name} does not have {len(FEATURES)} numbers of each kind.")
    return model


def _features(evidence: Evidence) -> NDArray[np.float64]:
    spread_k = evidence.contrast_peak_k - evidence.contrast_median_k
    return np.array(
        [
            math.log(max(evidence.contrast_median_k, _MIN_CONTRAST_K)),
            math.log(min(max(spread_k, _MIN_CONTRAST_K), _SKIN_K)),
            math.log(min(evidence.area_m2, _AREA_M2)),
            math.log(evidence.vehicles),
        ]
    )
