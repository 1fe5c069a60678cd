"""Local and thermal detectors against naive computations, and what they are for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.special import chdtri

from aos_gcs.imaging.detection.detectors import DETECTORS, detect
from aos_gcs.imaging.detection.local_rx import LOADING, local_rx_scores
from aos_gcs.imaging.detection.rx import rx_scores
from aos_gcs.imaging.detection.thermal_anomaly import _block_medians, _known_block_medians, warm_scores
from aos_gcs.imaging.model import Detector


def naive_local_rx(image: NDArray[np.float64], guard_px: int, background_px: int) -> NDArray[np.float64]:
    """One window after the other, on channels of unit variance."""
    image = (image - image.mean(axis=(0, 1))) / image.std(axis=(0, 1))
    height, width, channels = image.shape
    rows, columns = np.mgrid[:height, :width]
    scores = np.full((height, width), np.nan)
    for row in range(height):
        for column in range(width):
            distance = np.maximum(abs(rows - row), abs(columns - column))
            around = image[(distance <= background_px // 2) & (distance > guard_px // 2)]
            if len(around) >= 10 * channels:
                covariance = np.cov(around, rowvar=False).reshape(channels, channels) + LOADING * np.eye(channels)
                offset = image[row, column] - around.mean(axis=0)
                scores[row, column] = offset @ np.linalg.solve(covariance, offset)
    return scores


@settings(max_examples=15, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    channels=st.integers(1, 4),
    rows=st.integers(9, 24),
    columns=st.integers(9, 24),
    guard_px=st.sampled_from([1, 3, 5]),
)
def test_local_scores_are_those_of_a_window_around_each_pixel(
    seed: int, channels: int, rows: int, columns: int, guard_px: int
) -> None:
    rng = np.random.default_rng(seed)
    image = rng.normal(size=(rows, columns, channels)) @ rng.normal(size=(channels, channels)) * 5 + 1000
    expected = naive_local_rx(image, guard_px, 11)
    scores = local_rx_scores(image.astype(np.float32), guard_px, 11)
    np.testing.assert_array_equal(np.isnan(scores), np.isnan(expected))
    np.testing.assert_allclose(scores, expected, rtol=2e-2, atol=1e-2)


def test_local_scores_of_a_gaussian_background_are_chi_square() -> None:
    image = np.random.default_rng(0).normal(size=(120, 140, 3)).astype(np.float32)
    scores = local_rx_scores(image)
    assert scores.mean() == pytest.approx(3.0, rel=0.05)
    assert (scores > chdtri(3, 0.01)).mean() == pytest.approx(0.01, rel=0.3)


def test_a_target_in_the_calmer_half_is_found_only_by_its_surroundings() -> None:
    rng = np.random.default_rng(1)
    image = rng.normal(size=(160, 240, 1)).astype(np.float32)
    image[:, :120] *= 40.0
    image[80:84, 200:204] = 25.0
    target = np.zeros((160, 240), dtype=np.uint8)
    target[80:84, 200:204] = 1
    np.testing.assert_array_equal(detect(image, ("grey",), Detector.LOCAL_RX, 0.99), target)
    assert not detect(image, ("grey",), Detector.RX, 0.99)[target > 0].any()


def test_constant_channels_and_gaps_do_not_disturb_local_scores() -> None:
    rng = np.random.default_rng(2)
    image = rng.normal(size=(90, 100, 2)).astype(np.float32)
    with_constant = np.dstack((image, np.full((90, 100), 21.7, dtype=np.float32)))
    np.testing.assert_allclose(local_rx_scores(with_constant), local_rx_scores(image), rtol=1e-5)
    gap = image.copy()
    gap[30:40, 30:45, 1] = np.nan
    gap[:, :20] = np.inf
    scores = local_rx_scores(gap)
    np.testing.assert_array_equal(np.isnan(scores), ~np.isfinite(gap).all(axis=2))
    far = np.s_[:, 80:]
    np.testing.assert_allclose(scores[far], local_rx_scores(image)[far], rtol=0.2, atol=0.3)
    assert not local_rx_scores(np.full((70, 70, 3), 9, dtype=np.uint8)).any()
    assert np.isnan(local_rx_scores(np.full((70, 70, 3), np.nan, dtype=np.float32))).all()


def test_what_is_flat_nearby_has_finite_scores() -> None:
    image = np.random.default_rng(3).normal(size=(150, 200, 1)).astype(np.float32)
    image[:, 90:] = 0.5
    image[75, 160] = 3.0
    scores = local_rx_scores(image)
    assert np.isfinite(scores).all()
    assert 4e3 < scores[75, 160] < 2e4


def test_windows_that_do_not_nest_are_refused() -> None:
    for guard_px, background_px in ((9, 9), (4, 9), (3, 8), (-1, 9)):
        with pytest.raises(ValueError, match="windows must be odd"):
            local_rx_scores(np.zeros((20, 20, 1)), guard_px, background_px)


@pytest.mark.parametrize("unit", [1.0, 100.0])
def test_only_what_is_warm_scores_whatever_the_gradient(unit: float) -> None:
    rng = np.random.default_rng(4)
    rows, columns = np.mgrid[:256, :320]
    kelvin = 280.0 + 0.02 * rows + 0.01 * columns + rng.normal(0.0, 0.1, rows.shape)
    kelvin[100:108, 200:204] += 4.0
    kelvin[60:68, 40:44] -= 4.0
    thermal = (kelvin * unit).astype(np.uint16 if unit == 100.0 else np.float32)
    scores = warm_scores(thermal)
    mask = scores > DETECTORS[Detector.THERMAL].min_score(1)
    assert mask[100:108, 200:204].all()
    assert mask.sum() == 32
    assert not scores[60:68, 40:44].any()


def test_warm_scores_of_a_gaussian_background_are_half_a_chi_square() -> None:
    scores = warm_scores(np.random.default_rng(5).normal(300.0, 2.0, (256, 256)).astype(np.float32))
    assert (scores == 0.0).mean() == pytest.approx(0.5, abs=0.02)
    assert (scores > chdtri(1, 0.02)).mean() == pytest.approx(0.01, rel=0.2)


def test_gaps_and_constant_bands_are_not_warm() -> None:
    assert not warm_scores(np.full((50, 60), 17, dtype=np.uint8)).any()
    assert np.isnan(warm_scores(np.full((50, 60), np.nan))).all()
    thermal = np.random.default_rng(6).normal(size=(100, 100)).astype(np.float32)
    thermal[:50, :50] = np.nan
    scores = warm_scores(thermal)
    np.testing.assert_array_equal(np.isnan(scores), np.isnan(thermal))
    assert np.nanmax(scores) < 40.0


def test_one_warm_pixel_on_a_constant_band_stands_out() -> None:
    thermal = np.full((64, 64), 20.0, dtype=np.float32)
    thermal[30, 31] = 21.0
    mask = detect(thermal[:, :, np.newaxis], ("thermal",), Detector.THERMAL)
    assert np.argwhere(mask).tolist() == [[30, 31]]


@given(st.integers(1, 90), st.integers(1, 90), st.integers(8, 40), st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_medians_of_blocks_are_the_same_at_once_and_one_by_one(
    height: int, width: int, block_px: int, seed: int
) -> None:
    band = np.random.default_rng(seed).integers(0, 200, (height, width)).astype(np.float32)
    whole = np.vstack([band, np.full((block_px, width), 100.0, dtype=np.float32)])
    row_edges = np.linspace(0, len(whole), max(1, round(len(whole) / block_px)) + 1).astype(int)
    column_edges = np.linspace(0, width, max(1, round(width / block_px)) + 1).astype(int)
    known = np.ones(whole.shape, dtype=np.bool_)
    np.testing.assert_array_equal(
        _block_medians(whole, row_edges, column_edges, np.empty_like(whole)),
        _known_block_medians(whole, known, row_edges, column_edges),
    )


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_scores_of_bytes_are_those_of_the_same_floats(channels: int) -> None:
    image = np.random.default_rng(3).integers(0, 256, (70, 90, channels), dtype=np.uint8)
    np.testing.assert_array_equal(rx_scores(image), rx_scores(image.astype(np.float32)))
    np.testing.assert_array_equal(rx_scores(image[::2, ::3]), rx_scores(image[::2, ::3].astype(np.float32)))
