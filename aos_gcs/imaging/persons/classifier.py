"""Classifier of warm bodies: the probability that one is a person.

A logistic regression on what sharpened frames show of a body: how warm it is in the middle (clothes, fur, stone) and
at its warmest (skin, an animal's head), and how long it is. Each of three tells a person: a middle as warm as clothes,
a peak as warm as skin, or a face much warmer than the blanket below; high powers let one make up for the others. The
warmest stones are as warm as clothes, and equally warm all over: what is so, and longer than a person who stands or
sits, is rather a stone, since a person who lies shows some face. What a single vehicle sees is no evidence, and what is
hotter than any skin is no person; where cameras know the temperature of the forest, what is warmer than usual skin
is the less probably one. On a sunny day spots of sun make clothes and fur hotter than skin: there the middle of a body
counts instead. The model states how many other bodies there are for each person: the rarer persons
are, the more it takes.

The weights are fitted to simulated scenes by ``aos-gcs lab fit-person`` (docs/effectiveness.md); a model for another
season, camera or quarry is another file.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

import numpy as np
import scipy
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.imaging.persons.evidence import Evidence

FEATURES = (
    "eighth power of median contrast",
    "eighth power of peak contrast",
    "fourth power of spread of contrast",
    "log length of uniform warmth",
)
PERSON_ODDS = 0.25
"""Persons per other warm body that a swarm sees, unless the model says otherwise: missions show a person, if any, and
about four animals, stones and stumps."""
MAX_CONTRAST_K = 40.0
"""Skin is at most 37 °C warm, and surroundings in which people are searched for seldom colder than -3 °C."""
SKIN_C = 33.0
"""Usual temperature of skin. The warmer something is at its warmest, the less probably it is a person: on a clear day
stones in the sun are warmer by a few kelvin, on a warm day by ten."""
_SKIN_SIGMA_K = 2.0
"""Standard deviation of that, with the error of a camera's own temperatures. An assumption."""
_CLOTHES_C, _CLOTHES_SIGMA_K = 31.0, 3.0
"""Usual temperature of the middle of a clothed body on a sunny day, and its standard deviation. Assumptions."""
_SKIN_ABOVE_CLOTHES_K = 5.0
"""Contrast above the middle that counts on a sunny day; spots of sun make clothes warmer by more, and fur as well."""
_CLOTHES_IN_SUN_WEIGHT = 0.3
"""Weight of the log-odds of what is as warm as clothes on a sunny day."""
MIN_VEHICLES = 2
"""Vehicles that must agree; one alone may see a defective pixel, or a piece of another body beside its place."""
DAY_SIGMA_K = 2.0
"""Standard deviation of the contrasts of a day about those of the days that a model is fitted to: the air is warmer or
cooler, and the sun has shone for longer. An assumption."""
_DAYS_K, _DAYS_WEIGHT = np.polynomial.hermite_e.hermegauss(7) * np.array(
    [[DAY_SIGMA_K], [1.0 / math.sqrt(2.0 * math.pi)]]
)
"""Such differences, and their weights in a mean over days."""
_COOL_C = 16.0
"""Temperature of forest and ground up to which the days are such as the models are fitted to."""
_LEAST_SKIN_K = 7.0
"""Least contrast of skin that contrasts are related to: below, noise and spots of sun would count as clothes."""
_CLOTHES_K = 16.0
"""Median contrast above which a body is no more like clothes."""
_SKIN_K = 20.0
"""Peak contrast above which a body shows no more of skin."""
_FACE_K = 12.0
"""Peak above the median from which there is no more of a face above a blanket to be seen."""
_UNIFORM_K = 3.0
"""Peak above the median from which a body is not equally warm all over: a stone's top and sides differ by less."""
_SHORT_M = 0.9
"""Length of what is seen of a person who stands or sits; shorter things may be either."""
_LONG_M = 2.0
"""Length above which it says no more."""
_RIDGE = 1e-3
"""Penalty on the squares of the standardised weights, per observation: keeps them finite where classes separate."""


@dataclass(frozen=True, slots=True)
class PersonModel:
    """Weights of standardised features, in the order of :data:`FEATURES`."""

    centres: tuple[float, ...]
    scales: tuple[float, ...]
    weights: tuple[float, ...]
    bias: float
    odds: float = PERSON_ODDS
    """Persons per other warm body that the probability is computed for; the weights hold for equal numbers."""
    fitted_to: str = ""
    """Data that it is fitted to, in words; empty where nobody has said."""
    fitted_on: str = ""
    """Day of the fit, YYYY-MM-DD."""


def person_confidence(evidence: Evidence, model: PersonModel | None = None) -> float:
    """Return the probability, 0 to 1, that a warm body is a person; ``model`` None: the one fitted to simulations.

    What follows from it is said by :func:`aos_gcs.imaging.persons.decision.decide` alone.
    It holds where there are as many persons per other warm body as the model's ``odds`` say, and is the mean over days
    that are warmer and cooler than those that the model was fitted to, times how likely skin is to be so warm.
    """
    in_shade = _as_in_the_shade(evidence)
    if in_shade.contrast_peak_k > MAX_CONTRAST_K or evidence.vehicles < MIN_VEHICLES:
        return 0.0
    model = default_model() if model is None else model
    of_a_cool_day = _as_on_a_cool_day(in_shade)
    standardised = (np.array([_features(of_a_cool_day, day_k) for day_k in _DAYS_K]) - model.centres) / model.scales
    log_odds = standardised @ np.array(model.weights) + model.bias + math.log(model.odds)
    confidence = float(_DAYS_WEIGHT @ scipy.special.expit(log_odds)) * _may_be_so_hot(evidence)
    return _in_sun(confidence) if evidence.in_sun else confidence


def _as_in_the_shade(evidence: Evidence) -> Evidence:
    """Return the evidence with no warmer parts than skin among clothes, which spots of sun may have warmed."""
    if not evidence.in_sun:
        return evidence
    most_k = evidence.contrast_median_k + _SKIN_ABOVE_CLOTHES_K
    return replace(evidence, contrast_peak_k=min(evidence.contrast_peak_k, most_k))


def _as_on_a_cool_day(evidence: Evidence) -> Evidence:
    """Return the evidence with contrasts of a cool day: of a warmer forest a body stands out less, as skin does."""
    if evidence.background_c is None or evidence.background_c <= _COOL_C:
        return evidence
    skin_k = max(SKIN_C - evidence.background_c, _LEAST_SKIN_K)
    stretch = (SKIN_C - _COOL_C) / skin_k
    return replace(
        evidence,
        contrast_median_k=stretch * evidence.contrast_median_k,
        contrast_peak_k=stretch * evidence.contrast_peak_k,
    )


def _in_sun(confidence: float) -> float:
    """Return the probability on a sunny day, on which fur may be as warm as clothes."""
    if not 0.5 < confidence < 1.0:
        return confidence
    return float(scipy.special.expit(_CLOTHES_IN_SUN_WEIGHT * math.log(confidence / (1.0 - confidence))))


def hotter_than_usual_k(evidence: Evidence) -> float | None:
    """Return by how much a body is hotter than a person usually is; None where it is hardly or is not known.

    Its warmest parts are compared with skin; on a sunny day its middle is with clothes.
    """
    hotter_k, sigma_k = _hotter_k(evidence)
    return hotter_k if hotter_k >= sigma_k else None


def _hotter_k(evidence: Evidence) -> tuple[float, float]:
    """Return by how much a body is hotter than usual, or 0, and the standard deviation of what is usual."""
    background_c = evidence.background_c
    if background_c is None:
        return 0.0, _SKIN_SIGMA_K
    if evidence.in_sun:
        return max(0.0, background_c + evidence.contrast_median_k - _CLOTHES_C), _CLOTHES_SIGMA_K
    return max(0.0, background_c + evidence.contrast_peak_k - SKIN_C), _SKIN_SIGMA_K


def _may_be_so_hot(evidence: Evidence) -> float:
    """Return how likely a person is to be so hot, relative to one as warm as usual, 0 to 1."""
    hotter_k, sigma_k = _hotter_k(evidence)
    return math.exp(-0.5 * (hotter_k / sigma_k) ** 2)


def fit_person_model(evidence: Sequence[Evidence], is_person: Sequence[bool], odds: float = PERSON_ODDS) -> PersonModel:
    """Return the model that explains labelled bodies best; both classes weigh the same, however many each has.

    Args:
        evidence: of the bodies.
        is_person: what they are.
        odds: persons per other warm body where the model is to be used.

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
        return float(value), standardised.T @ (share * (scipy.special.expit(score) - labels)) + _RIDGE * penalised

    # Fitted in the laboratory alone: missions need not load it.
    from scipy.optimize import minimize  # noqa: PLC0415

    fitted = minimize(loss, np.zeros(standardised.shape[1]), jac=True, method="L-BFGS-B")
    return PersonModel(tuple(centres), tuple(scales), tuple(fitted.x[:-1]), float(fitted.x[-1]), odds)


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
        model = PersonModel(centres, scales, weights, float(table["bias"]), float(table["odds"]), *origin)
    except (ValueError, KeyError, TypeError) as error:
        raise InputDataError(f"The model of persons {name} is damaged ({error}); fit it anew.") from error
    if any(len(values) != len(FEATURES) for values in (centres, scales, weights)):
        raise InputDataError(f"The model of persons {name} does not have {len(FEATURES)} numbers of each kind.")
    if not (math.isfinite(model.odds) and model.odds > 0.0):
        raise InputDataError(f"The model of persons {name}: odds must be above 0, but is {model.odds}.")
    return model


def _features(evidence: Evidence, day_k: float = 0.0) -> NDArray[np.float64]:
    """Return the features of a body whose contrasts were greater by ``day_k``."""
    median_k, peak_k = evidence.contrast_median_k + day_k, evidence.contrast_peak_k + day_k
    clothes, skin, face = (
        min(max(contrast_k, 0.0), most_k) / most_k
        for contrast_k, most_k in ((median_k, _CLOTHES_K), (peak_k, _SKIN_K), (peak_k - median_k, _FACE_K))
    )
    uniformity = 1.0 - min(max(peak_k - median_k, 0.0), _UNIFORM_K) / _UNIFORM_K
    length = math.log(min(max(evidence.extent_m, _SHORT_M), _LONG_M) / _SHORT_M)
    return np.array([clothes**8, skin**8, face**4, uniformity * length])
