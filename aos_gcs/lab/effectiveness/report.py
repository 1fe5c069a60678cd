"""Precision, recall and position error of the study of effectiveness, with their intervals."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from aos_gcs.imaging.persons.classifier import (
    MIN_VEHICLES,
    PersonModel,
    default_model,
    fit_person_model,
)
from aos_gcs.imaging.persons.decision import FindingKind
from aos_gcs.imaging.persons.decision import decide as decide_body
from aos_gcs.imaging.persons.evidence import Evidence
from aos_gcs.lab.effectiveness.study import IN_VIEW_M2, Anomaly, SceneResult
from aos_gcs.lab.scenes import PositionGrade
from aos_gcs.lab.statistics import CONFIDENCE, Share, expected_calibration_error

HERE_M = 3.0
"""A claim farther from the person than this is one about something else."""
_RESAMPLES = 2000
_MIN_FOR_INTERVAL = 3
"""Position errors below which their median has no interval worth the name."""


class ClaimResult(StrEnum):
    """Judgement of a scene."""

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


class Rule(StrEnum):
    """Rule by which the system decides that a person is here."""

    PERSON = "person"
    """The warm body that most frames show, among those that look like a person with sufficient confidence."""
    ANOMALY = "anomaly"
    """Every step has an anomaly of the size from which missions count a target as in view, whatever it is."""


@dataclass(frozen=True, slots=True)
class SceneDecision:
    """Statement of the system about one scene, and whether it is right."""

    trees_per_ha: float
    seed: int
    grade: PositionGrade
    rule: Rule
    claim_result: ClaimResult
    approached: str | None
    confidence: float
    """Confidence of the body that looks most like a person; 0 when nothing warm was seen."""
    person_seen: bool
    """Something warm was seen where the person is; False without a person."""
    error_m: float
    """Distance of the claim from the person; NaN unless it is a hit."""
    sigma_m: float
    """The estimate's own standard deviation per axis; NaN where it has none."""


@dataclass(frozen=True, slots=True)
class Effectiveness:
    """Figures of many scenes of one density, one grade of positions and one rule."""

    trees_per_ha: float
    grade: PositionGrade
    rule: Rule
    with_person: int
    without_person: int
    precision: Share
    recall: Share
    median_error_m: float
    error_interval_m: tuple[float, float]
    """Bootstrap interval of the median."""
    unseen: int
    """Scenes whose person no frame showed."""


def decide(result: SceneResult, grade: PositionGrade, rule: Rule, model: PersonModel | None = None) -> SceneDecision:
    """Judge one scene; ``model`` is that of persons, None for the program's own."""
    verdicts = [decide_body(body.evidence, model) for body in result.warm[grade]]
    persons = [body for body, one in zip(result.warm[grade], verdicts, strict=True) if one.kind is FindingKind.PERSON]
    claim_enu_m: tuple[float, float] | None = None
    sigma_m = math.nan
    if rule is Rule.ANOMALY:
        claim_enu_m = _lasting_anomaly(result.anomalies[grade])
    elif persons:
        claim = max(persons, key=lambda body: body.evidence.views)
        claim_enu_m, sigma_m = claim.position_enu_m, claim.sigma_m
    claim_result, error_m = _claim_result(result, claim_enu_m)
    return SceneDecision(
        trees_per_ha=result.key.trees_per_ha,
        seed=result.key.seed,
        grade=grade,
        rule=rule,
        claim_result=claim_result,
        approached=result.approached,
        confidence=max((one.probability or 0.0 for one in verdicts), default=0.0),
        person_seen=any(_is_person(result, body.position_enu_m) for body in result.warm[grade]),
        error_m=error_m,
        sigma_m=sigma_m,
    )


def summarise(decisions: Iterable[SceneDecision]) -> list[Effectiveness]:
    """Return the figures per rule, density and grade, in this order."""
    groups: dict[tuple[Rule, float, PositionGrade], list[SceneDecision]] = {}
    for decision in decisions:
        groups.setdefault((decision.rule, decision.trees_per_ha, decision.grade), []).append(decision)
    return [_summary(groups[group]) for group in sorted(groups, key=lambda group: (group[0] != Rule.PERSON, *group))]


def labelled_bodies(
    results: Iterable[SceneResult], grades: Sequence[PositionGrade] = tuple(PositionGrade)
) -> tuple[list[Evidence], list[bool]]:
    """Return the evidence on warm bodies, and whether each is the person: to fit a model with, or to judge one.

    A warm body is what it lies nearest to. What too few vehicles have seen is left out, as the model does not judge it.
    """
    evidence, is_person = [], []
    for result in results:
        for warm in itertools.chain.from_iterable(result.warm[grade] for grade in grades):
            if warm.evidence.vehicles >= MIN_VEHICLES:
                evidence.append(warm.evidence)
                nearest = min(result.bodies, key=lambda body: math.dist(body.position_enu_m, warm.position_enu_m))
                is_person.append(nearest is result.bodies[0] and result.key.has_person)
    return evidence, is_person


def decide_by_others(results: Sequence[SceneResult], folds: int) -> list[SceneDecision]:
    """Judge each scene by a model that is fitted to the others: cross-validation.

    Scenes with and without a person of one draw lie in one fold, at all densities.

    Raises:
        InputDataError: the scenes of the other folds do not show bodies of both kinds.
    """
    draws = sorted({result.key.seed // 2 for result in results})
    fold_of_draw = {draw: rank % folds for rank, draw in enumerate(draws)}
    decisions = []
    for fold in range(folds):
        judged = [result for result in results if fold_of_draw[result.key.seed // 2] == fold]
        others = [result for result in results if fold_of_draw[result.key.seed // 2] != fold]
        model = fit_person_model(*labelled_bodies(others))
        decisions += [decide(result, grade, Rule.PERSON, model) for grade in PositionGrade for result in judged]
    return decisions


def calibration_error(results: Iterable[SceneResult], grade: PositionGrade, model: PersonModel | None = None) -> float:
    """Return the expected calibration error of the probability that bodies are persons; NaN without either kind.

    It is the difference of probability and share of persons, averaged over bodies. Persons and other bodies weigh as
    much as the model says that there are of each.
    """
    model = default_model() if model is None else model
    evidence, is_person = labelled_bodies(results, (grade,))
    persons = sum(is_person)
    if not 0 < persons < len(is_person):
        return math.nan
    labels = np.array(is_person, dtype=np.float64)
    share = model.odds / (1.0 + model.odds)
    weights = np.where(labels == 1.0, share / persons, (1.0 - share) / (len(labels) - persons))
    probabilities = np.array([decide_body(one, model).probability for one in evidence])
    return expected_calibration_error(probabilities, labels, weights)


def describe(results: Sequence[SceneResult]) -> str:
    """Return which scenes these are, in words: what a model that is fitted to them says of its data."""
    if not results:
        return "no scenes"
    densities = ", ".join(f"{density:g}" for density in sorted({result.key.trees_per_ha for result in results}))
    seeds = [result.key.seed for result in results]
    return f"{len(results)} scenes at {densities} trees/ha, seeds {min(seeds)} to {max(seeds)}"


def calibration_as_text(results: Sequence[SceneResult], model: PersonModel | None = None) -> str:
    """Return the calibration errors of all grades as a line of text."""
    errors = {grade: calibration_error(results, grade, model) for grade in PositionGrade}
    parts = (f"{'unknown' if math.isnan(error) else f'{error:.3f}'} ({grade})" for grade, error in errors.items())
    return f"Expected calibration error of the probability that a warm body is a person: {', '.join(parts)}\n"


def as_markdown(figures: Sequence[Effectiveness]) -> str:
    """Return the figures as a table."""
    lines = [
        "| rule | trees/ha | positions | scenes with, without | precision | recall | median error, m | never seen |",
        "|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {one.rule} | {one.trees_per_ha:g} | {one.grade} | {one.with_person}, {one.without_person} "
        f"| {_percent(one.precision)} | {_percent(one.recall)} "
        f"| {one.median_error_m:.2f} ({one.error_interval_m[0]:.2f} to {one.error_interval_m[1]:.2f}) "
        f"| {one.unseen} |"
        for one in figures
    ]
    return "\n".join(lines) + "\n"


def _lasting_anomaly(steps: Sequence[Anomaly | None]) -> tuple[float, float] | None:
    """Return where the last step's anomaly is if every step has one."""
    seen = [step for step in steps if step is not None and step.area_m2 >= IN_VIEW_M2]
    return seen[-1].position_enu_m if seen and len(seen) == len(steps) else None


def _claim_result(result: SceneResult, claim_enu_m: tuple[float, float] | None) -> tuple[ClaimResult, float]:
    """Return the claim_result on a claim, None for no claim, and its error, NaN unless it is a hit."""
    if claim_enu_m is None:
        return (ClaimResult.MISS if result.key.has_person else ClaimResult.CLEAR), math.nan
    if not result.key.has_person:
        return ClaimResult.FALSE_ALARM, math.nan
    if not _is_person(result, claim_enu_m):
        return ClaimResult.WRONG_PLACE, math.nan
    return ClaimResult.HIT, math.dist(result.bodies[0].position_enu_m, claim_enu_m)


def _is_person(result: SceneResult, position_enu_m: tuple[float, float]) -> bool:
    return result.key.has_person and math.dist(result.bodies[0].position_enu_m, position_enu_m) <= HERE_M


def _summary(decisions: Sequence[SceneDecision]) -> Effectiveness:
    count = {claim_result: sum(one.claim_result is claim_result for one in decisions) for claim_result in ClaimResult}
    hits, wrong = count[ClaimResult.HIT], count[ClaimResult.WRONG_PLACE]
    with_person = hits + count[ClaimResult.MISS] + wrong
    errors_m = np.array([one.error_m for one in decisions if one.claim_result is ClaimResult.HIT])
    return Effectiveness(
        trees_per_ha=decisions[0].trees_per_ha,
        grade=decisions[0].grade,
        rule=decisions[0].rule,
        with_person=with_person,
        without_person=len(decisions) - with_person,
        precision=Share.of(hits, hits + wrong + count[ClaimResult.FALSE_ALARM]),
        recall=Share.of(hits, with_person),
        median_error_m=float(np.median(errors_m)) if len(errors_m) else math.nan,
        error_interval_m=_median_interval(errors_m),
        unseen=with_person - sum(one.person_seen for one in decisions),
    )


def _median_interval(values: np.ndarray) -> tuple[float, float]:
    if len(values) < _MIN_FOR_INTERVAL:
        return math.nan, math.nan
    from scipy import stats  # noqa: PLC0415

    interval = stats.bootstrap(
        (values,), np.median, n_resamples=_RESAMPLES, confidence_level=CONFIDENCE, method="percentile", rng=0
    ).confidence_interval
    return float(interval.low), float(interval.high)


def _percent(share: Share) -> str:
    return f"{100 * share.value:.1f} % ({100 * share.low:.1f} to {100 * share.high:.1f})"
