"""Precision, recall and position error of the study of effectiveness, with their intervals."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from scipy import stats

from aos_gcs.imaging.person import DECISION, PersonModel, person_confidence
from aos_gcs.imaging.person_evidence import Evidence
from aos_gcs.lab.effectiveness import SceneResult, WarmBody
from aos_gcs.lab.scenes import PositionGrade

HERE_M = 3.0
"""A claim farther from the person than this is one about something else."""
CONFIDENCE = 0.95
_RESAMPLES = 2000
_MIN_FOR_INTERVAL = 3
"""Position errors below which their median has no interval worth the name."""


class Verdict(StrEnum):
    """How a scene was judged."""

    HIT = "hit"
    """There is a person, and it was claimed where it is."""
    MISS = "miss"
    """There is a person, and nothing was claimed."""
    WRONG_PLACE = "wrong place"
    """There is a person, but something else was claimed to be it: a miss and a false alarm."""
    FALSE_ALARM = "false alarm"
    """There is no person, but one was claimed."""
    CLEAR = "clear"
    """There is no person, and none was claimed."""


@dataclass(frozen=True, slots=True)
class Decision:
    """What the system says about one scene, and whether that is right."""

    trees_per_ha: float
    seed: int
    grade: PositionGrade
    verdict: Verdict
    approached: str | None
    confidence: float
    """Of the body that looks most like a person; 0 when nothing warm was seen."""
    person_seen: bool
    """Something warm was seen where the person is; False without a person."""
    error_m: float
    """Distance of the claim from the person; NaN unless it is a hit."""
    sigma_m: float
    """The estimate's own standard deviation per axis; NaN unless it is a hit."""


@dataclass(frozen=True, slots=True)
class Share:
    """A proportion with Wilson's interval."""

    hits: int
    trials: int
    low: float
    high: float

    @property
    def value(self) -> float:
        """The proportion; NaN without trials."""
        return self.hits / self.trials if self.trials else math.nan

    @classmethod
    def of(cls, hits: int, trials: int) -> Share:
        """Return the proportion with its interval; without trials the interval is that of ignorance."""
        if not trials:
            return cls(0, 0, 0.0, 1.0)
        interval = stats.binomtest(hits, trials).proportion_ci(CONFIDENCE, method="wilson")
        return cls(hits, trials, float(interval.low), float(interval.high))


@dataclass(frozen=True, slots=True)
class Effectiveness:
    """Figures of many scenes of one density and one grade of positions."""

    trees_per_ha: float
    grade: PositionGrade
    with_person: int
    without_person: int
    precision: Share
    recall: Share
    median_error_m: float
    error_interval_m: tuple[float, float]
    """Bootstrap interval of the median."""
    unseen: int
    """Scenes whose person no frame showed."""


def decide(result: SceneResult, grade: PositionGrade, model: PersonModel | None = None) -> Decision:
    """Judge one scene: the body that looks most like a person is claimed to be one if its confidence suffices."""
    confidences = [person_confidence(body.evidence, model) for body in result.warm[grade]]
    best = int(np.argmax(confidences)) if confidences else None
    confidence = 0.0 if best is None else confidences[best]
    error_m, sigma_m = math.nan, math.nan
    claimed = best is not None and confidence >= DECISION
    verdict = _VERDICTS[result.key.has_person, claimed]
    if result.key.has_person and best is not None and claimed:
        error_m, sigma_m = _distance_m(result, result.warm[grade][best]), result.warm[grade][best].sigma_m
        if error_m > HERE_M:
            verdict, error_m, sigma_m = Verdict.WRONG_PLACE, math.nan, math.nan
    return Decision(
        trees_per_ha=result.key.trees_per_ha,
        seed=result.key.seed,
        grade=grade,
        verdict=verdict,
        approached=result.approached,
        confidence=confidence,
        person_seen=result.key.has_person and any(_distance_m(result, body) <= HERE_M for body in result.warm[grade]),
        error_m=error_m,
        sigma_m=sigma_m,
    )


def summarise(decisions: Iterable[Decision]) -> list[Effectiveness]:
    """Return the figures per density and grade, in this order."""
    groups: dict[tuple[float, PositionGrade], list[Decision]] = {}
    for decision in decisions:
        groups.setdefault((decision.trees_per_ha, decision.grade), []).append(decision)
    return [_summary(density, grade, groups[density, grade]) for density, grade in sorted(groups)]


def labelled_bodies(results: Iterable[SceneResult]) -> tuple[list[Evidence], list[bool]]:
    """Return the evidence on all warm bodies, and whether each is the person: to fit a model with.

    A warm body is what it lies nearest to.
    """
    evidence, is_person = [], []
    for result in results:
        for bodies in result.warm.values():
            for warm in bodies:
                evidence.append(warm.evidence)
                nearest = min(result.bodies, key=lambda body: math.dist(body.position_enu_m, warm.position_enu_m))
                is_person.append(nearest is result.bodies[0] and result.key.has_person)
    return evidence, is_person


def as_markdown(figures: Sequence[Effectiveness]) -> str:
    """Return the figures as a table."""
    lines = [
        "| trees/ha | positions | scenes with, without | precision | recall | median error, m | never seen |",
        "|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {one.trees_per_ha:g} | {one.grade} | {one.with_person}, {one.without_person} | {_percent(one.precision)} "
        f"| {_percent(one.recall)} | {one.median_error_m:.2f} ({one.error_interval_m[0]:.2f} to "
        f"{one.error_interval_m[1]:.2f}) | {one.unseen} |"
        for one in figures
    ]
    return "\n".join(lines) + "\n"


def _distance_m(result: SceneResult, body: WarmBody) -> float:
    return math.dist(result.bodies[0].position_enu_m, body.position_enu_m)


def _summary(trees_per_ha: float, grade: PositionGrade, decisions: Sequence[Decision]) -> Effectiveness:
    count = {verdict: sum(one.verdict is verdict for one in decisions) for verdict in Verdict}
    hits, wrong = count[Verdict.HIT], count[Verdict.WRONG_PLACE]
    with_person = hits + count[Verdict.MISS] + wrong
    errors_m = np.array([one.error_m for one in decisions if one.verdict is Verdict.HIT])
    return Effectiveness(
        trees_per_ha=trees_per_ha,
        grade=grade,
        with_person=with_person,
        without_person=len(decisions) - with_person,
        precision=Share.of(hits, hits + wrong + count[Verdict.FALSE_ALARM]),
        recall=Share.of(hits, with_person),
        median_error_m=float(np.median(errors_m)) if len(errors_m) else math.nan,
        error_interval_m=_median_interval(errors_m),
        unseen=with_person - sum(one.person_seen for one in decisions),
    )


def _median_interval(values: np.ndarray) -> tuple[float, float]:
    if len(values) < _MIN_FOR_INTERVAL:
        return math.nan, math.nan
    interval = stats.bootstrap(
        (values,), np.median, n_resamples=_RESAMPLES, confidence_level=CONFIDENCE, method="percentile", rng=0
    ).confidence_interval
    return float(interval.low), float(interval.high)


def _percent(share: Share) -> str:
    return f"{100 * share.value:.1f} % ({100 * share.low:.1f} to {100 * share.high:.1f})"


_VERDICTS = {
    (True, True): Verdict.HIT,
    (True, False): Verdict.MISS,
    (False, True): Verdict.FALSE_ALARM,
    (False, False): Verdict.CLEAR,
}
"""By whether there is a person, and whether one was claimed."""
