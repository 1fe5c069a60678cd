"""Judging scenes: claim_results, proportions with intervals, and what a model is fitted to."""

import math
from dataclasses import replace

import pytest

from aos_gcs.imaging.persons.classifier import PersonModel, fit_person_model, person_confidence
from aos_gcs.imaging.persons.evidence import Evidence
from aos_gcs.lab.effectiveness.report import (
    ClaimResult,
    Rule,
    Share,
    as_markdown,
    calibration_as_text,
    calibration_error,
    decide,
    decide_by_others,
    describe,
    labelled_bodies,
    summarise,
)
from aos_gcs.lab.effectiveness.study import Anomaly, SceneKey, SceneResult, WarmBody
from aos_gcs.lab.scenes import PositionGrade, SceneBody

PERSON_ENU_M, DEER_ENU_M = (0.0, 30.0), (10.0, 30.0)
MODEL = PersonModel(((7.0 / 16.0) ** 8, 0.0, 0.0, 0.0), (1e-3,) * 4, (15.0, 0.0, 0.0, 0.0), 0.0, odds=1.0)
"""Whatever is warmer than 7 K is a person."""


ANOMALIES = (Anomaly(0.3, (10.0, 30.0)), Anomaly(0.2, (0.0, 30.0)))


def warm(east_m: float, contrast_k: float, north_m: float = 30.0, *, views: int = 5, vehicles: int = 3) -> WarmBody:
    evidence = Evidence(views, vehicles, 0.2, 0.5, contrast_k, contrast_k)
    return WarmBody(evidence, (east_m, north_m), 0.3)


def scene(*bodies: WarmBody, has_person: bool = True, seed: int = 1, density: float = 300.0) -> SceneResult:
    persons = (SceneBody("person lying", PERSON_ENU_M),) if has_person else ()
    return SceneResult(
        key=SceneKey(density, seed, has_person),
        bodies=(*persons, SceneBody("deer", DEER_ENU_M)),
        approached="deer",
        anomalies=dict.fromkeys(PositionGrade, ANOMALIES),
        warm={PositionGrade.GNSS: bodies, PositionGrade.RTK: bodies},
    )


@pytest.mark.parametrize(
    ("result", "claim_result", "seen"),
    [
        (scene(warm(0.4, 9.0), warm(10.0, 5.0)), ClaimResult.HIT, True),
        (scene(warm(0.4, 6.0), warm(10.0, 5.0)), ClaimResult.MISS, True),
        (scene(warm(10.0, 5.0)), ClaimResult.MISS, False),
        (scene(), ClaimResult.MISS, False),
        (scene(warm(0.4, 6.0), warm(10.0, 9.5)), ClaimResult.WRONG_PLACE, True),
        (scene(warm(10.0, 9.5), has_person=False), ClaimResult.FALSE_ALARM, False),
        (scene(warm(10.0, 5.0), has_person=False), ClaimResult.CLEAR, False),
        (scene(has_person=False), ClaimResult.CLEAR, False),
    ],
)
def test_verdicts(result: SceneResult, claim_result: ClaimResult, seen: bool) -> None:
    decision = decide(result, PositionGrade.GNSS, Rule.PERSON, MODEL)
    assert decision.claim_result is claim_result
    assert decision.person_seen is seen
    assert math.isnan(decision.error_m) == (claim_result is not ClaimResult.HIT)


def test_of_bodies_like_persons_the_one_seen_most_is_the_claim() -> None:
    decision = decide(scene(warm(10.0, 9.9), warm(0.3, 9.5, 30.4, views=9)), PositionGrade.RTK, Rule.PERSON, MODEL)
    assert decision.claim_result is ClaimResult.HIT
    assert decision.error_m == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("steps", "has_person", "claim_result"),
    [
        (ANOMALIES, True, ClaimResult.HIT),
        (ANOMALIES[::-1], True, ClaimResult.WRONG_PLACE),
        (ANOMALIES, False, ClaimResult.FALSE_ALARM),
        ((*ANOMALIES, None), True, ClaimResult.MISS),
        ((*ANOMALIES, Anomaly(0.01, (0.0, 30.0))), False, ClaimResult.CLEAR),
    ],
)
def test_anomalies_alone_are_claimed_whatever_they_are(
    steps: tuple[Anomaly | None, ...], has_person: bool, claim_result: ClaimResult
) -> None:
    result = replace(scene(has_person=has_person), anomalies={PositionGrade.RTK: steps, PositionGrade.GNSS: ()})
    assert decide(result, PositionGrade.RTK, Rule.ANOMALY, MODEL).claim_result is claim_result


def test_figures_of_many_scenes() -> None:
    results = [scene(warm(0.1 * i, 9.0), seed=i) for i in range(1, 10)]
    results += [scene(warm(10.0, 9.5), seed=20), scene(seed=21)]
    results += [scene(warm(10.0, 9.5), has_person=False, seed=30), scene(has_person=False, seed=31)]
    results += [scene(warm(0.2, 9.0), seed=40, density=500.0)]
    dense, sparse = sorted(
        summarise(decide(result, PositionGrade.GNSS, Rule.PERSON, MODEL) for result in results),
        key=lambda one: -one.trees_per_ha,
    )
    assert (sparse.with_person, sparse.without_person, sparse.unseen) == (11, 2, 2)
    assert (sparse.recall.hits, sparse.recall.trials) == (9, 11)
    assert (sparse.precision.hits, sparse.precision.trials) == (9, 11)
    assert sparse.median_error_m == pytest.approx(0.5)
    assert sparse.error_interval_m[0] < 0.5 < sparse.error_interval_m[1]
    assert (dense.with_person, dense.recall.value) == (1, 1.0)
    assert "| person | 300 | gnss | 11, 2 | 81.8 % (52.3 to 94.9) | 81.8 %" in as_markdown([sparse])


def test_wilsons_interval_and_ignorance() -> None:
    assert Share.of(96, 100).low == pytest.approx(0.9016, abs=1e-3)
    assert Share.of(96, 100).high == pytest.approx(0.9843, abs=1e-3)
    nothing = Share.of(0, 0)
    assert math.isnan(nothing.value)
    assert (nothing.low, nothing.high) == (0.0, 1.0)


def test_bodies_are_labelled_by_what_they_lie_nearest_to() -> None:
    evidence, is_person = labelled_bodies(
        [scene(warm(1.0, 9.0), warm(9.0, 5.0)), scene(warm(0.0, 5.5), has_person=False)]
    )
    assert is_person == [True, False, True, False, False, False]
    assert len(evidence) == 6
    assert labelled_bodies([scene(warm(0.0, 9.0, vehicles=1))]) == ([], [])


def test_calibration_compares_probabilities_with_shares_and_kinds_weigh_as_the_model_says() -> None:
    """The model of these tests gives a probability of one half at 7 K."""
    person, other = warm(0.0, 7.0), warm(10.0, 7.0)
    honest = [scene(person, other)]
    assert calibration_error(honest, PositionGrade.RTK, MODEL) == pytest.approx(0.0, abs=1e-6)
    assert calibration_error([*honest, scene(other, other)], PositionGrade.RTK, MODEL) == pytest.approx(0.0, abs=1e-6)
    sure = [scene(warm(0.0, 0.0), warm(10.0, 0.0))]
    assert calibration_error(sure, PositionGrade.GNSS, MODEL) == pytest.approx(0.5, abs=1e-3)
    rare = replace(MODEL, odds=0.25)
    stated = person_confidence(person.evidence, rare)
    assert calibration_error(honest, PositionGrade.RTK, rare) == pytest.approx(abs(stated - 0.2), abs=1e-6)
    assert calibration_error(sure, PositionGrade.RTK, rare) == pytest.approx(0.2, abs=1e-3)
    assert calibration_as_text(sure, MODEL).endswith(": 0.499 (gnss), 0.499 (rtk)\n")


def test_calibration_is_unknown_without_persons() -> None:
    assert math.isnan(calibration_error([scene(warm(10.0, 5.0), has_person=False)], PositionGrade.GNSS, MODEL))
    assert calibration_as_text([]).endswith(": unknown (gnss), unknown (rtk)\n")


def test_scenes_are_described_by_densities_and_seeds() -> None:
    assert describe([scene(seed=7), scene(seed=3, density=500.0)]) == "2 scenes at 300, 500 trees/ha, seeds 3 to 7"
    assert describe([]) == "no scenes"


def test_scenes_are_judged_by_models_of_the_others() -> None:
    """The person of the odd scene alone has a blanket and a face: only its own model would know it."""
    usual = [scene(warm(0.0, 15.0), warm(10.0, 5.0), seed=seed) for seed in (3, 5, 7, 9)]
    covered = warm(0.0, 5.0)
    odd = scene(replace(covered, evidence=replace(covered.evidence, contrast_peak_k=12.0)), warm(10.0, 5.0), seed=1)
    decisions = {(one.seed, one.grade): one.claim_result for one in decide_by_others([*usual, odd], 5)}
    own = fit_person_model(*labelled_bodies([*usual, odd]))
    assert decide(odd, PositionGrade.RTK, Rule.PERSON, own).claim_result is ClaimResult.HIT
    assert len(decisions) == 10
    assert decisions[1, PositionGrade.RTK] is ClaimResult.MISS
    assert decisions[5, PositionGrade.RTK] is ClaimResult.HIT
