"""Intervals and paired comparisons: coverage, correction, and what missing runs do."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.lab.statistics import PerHectare, holm_correction, mean_band, mean_interval, paired_differences


def test_interval_covers_the_true_mean_as_often_as_it_says() -> None:
    samples = np.random.default_rng(1).normal(3.0, 2.0, (2000, 8))
    intervals = [mean_interval(sample) for sample in samples]
    covered = np.mean([interval.low <= 3.0 <= interval.high for interval in intervals])
    assert covered == pytest.approx(0.95, abs=0.015)  # three standard errors of 2000 trials


def test_interval_leaves_missing_runs_out_and_one_run_unbounded() -> None:
    assert mean_interval(np.array([1.0, np.nan, 3.0])).count == 2
    assert mean_interval(np.array([1.0])).half_width == np.inf
    assert np.isnan(mean_interval(np.array([np.nan])).mean)


def test_band_is_the_interval_of_each_time() -> None:
    curves = np.random.default_rng(2).random((12, 5))
    mean, low, high = mean_band(curves)
    for time in range(5):
        interval = mean_interval(curves[:, time])
        assert (mean[time], low[time], high[time]) == pytest.approx((interval.mean, interval.low, interval.high))


def test_pairing_finds_a_small_gain_between_very_different_initialisations() -> None:
    rng = np.random.default_rng(3)
    easy_or_hard = rng.random(40)
    values = {
        "base": easy_or_hard,
        "better": easy_or_hard + rng.normal(0.05, 0.02, 40),
        "same": easy_or_hard + rng.normal(0.0, 0.02, 40),
    }
    better, same = paired_differences(values, "base")
    assert better.variant == "better"
    assert 0.03 < better.difference.low < better.difference.mean < better.difference.high < 0.07
    assert better.p_corrected < 0.001
    assert better.share_better > 0.9
    assert same.p_corrected > 0.05
    unpaired = mean_interval(values["better"])
    assert unpaired.half_width > 5 * better.difference.half_width


def test_pairs_with_a_missing_run_are_left_out() -> None:
    (difference,) = paired_differences(
        {"base": np.array([0.0, 1.0, 2.0]), "other": np.array([1.0, np.nan, 4.0])}, "base"
    )
    assert difference.difference.count == 2
    assert difference.difference.mean == pytest.approx(1.5)


def test_equal_results_are_no_difference() -> None:
    (difference,) = paired_differences({"base": np.ones(5), "copy": np.ones(5)}, "base")
    assert difference.p_value == 1.0
    assert difference.share_better == 0.5


def test_holm_correction_of_a_known_example() -> None:
    assert holm_correction([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=8))
def test_correction_keeps_the_order_and_never_lowers(p_values: list[float]) -> None:
    corrected = holm_correction(p_values)
    assert all(p <= c <= 1.0 for p, c in zip(p_values, corrected, strict=True))
    order = np.argsort(p_values)
    assert np.all(np.diff(np.array(corrected)[order]) >= 0.0)


@pytest.mark.parametrize(("events", "low", "high"), [(0, 0.0, 3.689), (1, 0.02532, 5.572), (10, 4.795, 18.39)])
def test_rate_has_the_exact_interval_of_poisson_counts(events: int, low: float, high: float) -> None:
    rate = PerHectare.of(events, 4.0)
    assert rate.value == events / 4.0
    assert (rate.low, rate.high) == (pytest.approx(low / 4.0, rel=1e-3), pytest.approx(high / 4.0, rel=1e-3))


def test_of_a_rate_without_an_area_nothing_is_known() -> None:
    rate = PerHectare.of(0, 0.0)
    assert math.isnan(rate.value)
    assert (rate.low, rate.high) == (0.0, math.inf)
