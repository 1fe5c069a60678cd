"""One decision about a body that was looked at several times."""

from dataclasses import replace

import pytest
import scipy

from aos_gcs.imaging.persons.decision import (
    AT_ONCE,
    DECISION,
    SEVERAL_LOOKS,
    TOGETHER,
    FindingKind,
    Verdict,
    decide,
    pooled,
)
from aos_gcs.imaging.persons.evidence import Evidence


def look(probability: float | None, *, is_evidence: bool = True, is_uniform: bool = False) -> Verdict:
    kind = FindingKind.PERSON if probability is not None and probability >= DECISION else FindingKind.WARM_OBJECT
    return Verdict(kind, probability, (f"looks {probability}",), is_evidence=is_evidence, is_uniform=is_uniform)


def mean_probability(verdict: Verdict, looks: int) -> float:
    """Return the probability by the mean of so many looks of a verdict that states it as of several."""
    assert verdict.probability is not None
    worth = min(1.0 + (looks - 1) / 3.0, SEVERAL_LOOKS) if verdict.probability > 0.5 else 1.0
    return float(scipy.special.expit(scipy.special.logit(verdict.probability) / worth))


@pytest.mark.parametrize(
    ("probabilities", "probability", "decisive"),
    [
        ((0.8,), 0.8, 0.8),
        ((0.99, 0.3, 0.98), 0.927, 0.98),
        ((0.3, 0.3, 0.99), 0.725, 0.99),
        ((0.6, 0.2, 0.6), 0.452, 0.2),
        ((0.97, 0.4, 0.4), 0.709, 0.97),
        ((0.92, 0.4, 0.3), 0.598, 0.3),
        ((0.2, 0.1, 0.6), 0.257, 0.1),
    ],
)
def test_looks_count_by_the_mean_of_their_log_odds(
    probabilities: tuple[float, ...], probability: float, decisive: float
) -> None:
    verdict = pooled([look(one) for one in probabilities])
    assert mean_probability(verdict, len(probabilities)) == pytest.approx(probability, abs=1e-3)
    assert verdict.kind is look(decisive).kind
    assert verdict.reasons == look(decisive).reasons, "those of the latest look that says the same"


def test_half_a_chance_in_all_looks_is_undecided() -> None:
    verdict = pooled([look(0.55), look(0.6)])
    assert verdict.kind is FindingKind.UNDECIDED
    assert mean_probability(verdict, 2) == pytest.approx(0.575, abs=1e-3)


def test_a_person_is_stated_the_surer_the_more_looks_there_are_and_announced_by_the_mean_of_them() -> None:
    """All bodies without skin that looks took for persons with 80 to 90 % in the mean were persons."""
    stated = [pooled([look(0.8)] * looks).probability or 0.0 for looks in (1, 2, 4, 20)]
    assert stated[0] == pytest.approx(0.8)
    assert stated[0] < stated[1] < stated[2] == stated[3] < 0.95
    unlikely = [pooled([look(0.3)] * looks).probability for looks in (1, 20)]
    assert unlikely == pytest.approx([0.3, 0.3]), "what is left undecided is announced at the end by this"
    for probability in (0.55, 0.59, 0.61, 0.79, 0.81, 0.95):
        verdict = pooled([look(probability)] * 10)
        assert (verdict.kind is FindingKind.PERSON) == (probability >= TOGETHER)
        assert verdict.is_sure == (probability >= AT_ONCE)


def test_no_look_outweighs_all_the_others() -> None:
    assert pooled([look(0.0), look(0.0), look(1.0)]).kind is FindingKind.WARM_OBJECT
    assert pooled([look(1.0), look(1.0), look(0.0)]).kind is FindingKind.PERSON


def test_what_shows_no_skin_in_many_looks_is_rather_a_stone() -> None:
    """The hottest stones are as warm as clothes in every look; leaves hide hands and face in some looks only."""
    stone = look(0.9, is_uniform=True)
    likelihoods = [mean_probability(pooled([stone] * looks), looks) for looks in (1, 4, 10)]
    assert likelihoods == pytest.approx([0.9, 0.751, 0.405], abs=1e-3)
    assert pooled([stone] * 10).kind is not FindingKind.PERSON
    assert pooled([*[stone] * 9, look(0.9)]).kind is FindingKind.PERSON, "one look shows skin"


def test_what_is_warmer_than_any_stone_is_a_person_without_skin_too() -> None:
    assert pooled([look(0.99, is_uniform=True)] * 10).kind is FindingKind.PERSON


def test_a_look_tells_whether_a_body_is_equally_warm_all_over() -> None:
    evidence = Evidence(9, 5, 0.3, 0.7, 13.2, 14.4, frames=9, swarm=5)
    assert decide(evidence).is_uniform
    assert not decide(replace(evidence, contrast_peak_k=17.0)).is_uniform


def test_what_a_single_vehicle_sees_takes_no_part() -> None:
    nothing = look(0.0, is_evidence=False)
    assert pooled([look(0.9), nothing, nothing]).probability == pytest.approx(0.9)
    assert pooled([nothing]) == nothing


def test_without_temperatures_the_latest_look_decides() -> None:
    assert pooled([look(0.9), look(None)]) == look(None)
