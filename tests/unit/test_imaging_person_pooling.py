"""One decision about a body that was looked at several times."""

import pytest

from aos_gcs.imaging.persons.decision import DECISION, FindingKind, Verdict, pooled


def look(probability: float | None, *, is_evidence: bool = True) -> Verdict:
    kind = FindingKind.PERSON if probability is not None and probability >= DECISION else FindingKind.WARM_OBJECT
    return Verdict(kind, probability, (f"looks {probability}",), is_evidence=is_evidence)


@pytest.mark.parametrize(
    ("probabilities", "probability", "decisive"),
    [
        ((0.8,), 0.8, 0.8),
        ((0.99, 0.3, 0.98), 0.927, 0.98),
        ((0.3, 0.3, 0.99), 0.725, 0.99),
        ((0.6, 0.2, 0.6), 0.452, 0.2),
        ((0.9, 0.4, 0.5), 0.646, 0.4),
        ((0.2, 0.1, 0.6), 0.257, 0.1),
    ],
)
def test_looks_count_by_the_mean_of_their_log_odds(
    probabilities: tuple[float, ...], probability: float, decisive: float
) -> None:
    verdict = pooled([look(one) for one in probabilities])
    assert verdict.probability == pytest.approx(probability, abs=1e-3)
    assert verdict.kind is look(decisive).kind
    assert verdict.reasons == look(decisive).reasons, "those of the latest look that says the same"


def test_half_a_chance_in_all_looks_is_undecided() -> None:
    verdict = pooled([look(0.55), look(0.6)])
    assert verdict.kind is FindingKind.UNDECIDED
    assert verdict.probability == pytest.approx(0.575, abs=1e-3)


def test_no_look_outweighs_all_the_others() -> None:
    assert pooled([look(0.0), look(0.0), look(1.0)]).kind is FindingKind.WARM_OBJECT
    assert pooled([look(1.0), look(1.0), look(0.0)]).kind is FindingKind.PERSON


def test_what_a_single_vehicle_sees_takes_no_part() -> None:
    nothing = look(0.0, is_evidence=False)
    assert pooled([look(0.9), nothing, nothing]).probability == pytest.approx(0.9)
    assert pooled([nothing]) == nothing


def test_without_temperatures_the_latest_look_decides() -> None:
    assert pooled([look(0.9), look(None)]) == look(None)
