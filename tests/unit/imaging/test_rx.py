from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.special import chdtri

from aos_gcs.imaging.detection.rx import anomaly_mask, default_min_score, rx_scores

RECORDED = Path(__file__).resolve().parents[4] / "shared" / "data" / "rx" / "rx_512x512x4.npz"


def reference_scores(image: NDArray[np.generic]) -> NDArray[np.float64]:
    pixels = image.reshape(-1, image.shape[2]).astype(np.float64)
    pixels -= pixels.mean(axis=0)
    inverse = np.linalg.pinv(pixels.T @ pixels / (len(pixels) - 1), rcond=1e-12, hermitian=True)
    return np.einsum("ij,jk,ik->i", pixels, inverse, pixels).reshape(image.shape[:2])


def background(rng: np.random.Generator, shape: tuple[int, int], channels: int) -> NDArray[np.float32]:
    mixing = rng.normal(size=(channels, channels)) + 2 * np.eye(channels)
    return (rng.normal(size=(*shape, channels)) @ mixing + 100).astype(np.float32)


@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_scores_agree_with_the_recorded_ones(dtype: type[np.generic]) -> None:
    if not RECORDED.exists():
        pytest.skip(f"recorded scores are absent: {RECORDED.name}")
    with np.load(RECORDED) as recorded:
        scores = rx_scores(recorded["image"].astype(dtype))
        np.testing.assert_allclose(scores, recorded["score"], atol=2e-3)


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), channels=st.integers(1, 6), rows=st.integers(6, 40), columns=st.integers(6, 40))
def test_scores_are_mahalanobis_distances(seed: int, channels: int, rows: int, columns: int) -> None:
    image = background(np.random.default_rng(seed), (rows, columns), channels)
    np.testing.assert_allclose(rx_scores(image), reference_scores(image), rtol=0.02, atol=1e-2)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_all_pixel_types_give_the_same_scores(dtype: type[np.generic]) -> None:
    image = background(np.random.default_rng(1), (64, 48), 4).clip(0, 255).round()
    np.testing.assert_allclose(rx_scores(image.astype(dtype)), reference_scores(image), atol=1e-3)


@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_colours_of_the_night_do_not_stand_out_and_a_body_does(dtype: type[np.generic]) -> None:
    rng = np.random.default_rng(7)
    colours = np.rint(rng.normal(1.6, 1.2, (256, 256, 1)) + np.zeros(3)).clip(0, 255).astype(np.uint8)
    # A coder that keeps brightness better than colour lets a pixel in two hundred differ in one channel.
    colours[..., 0] += rng.uniform(size=(256, 256)) < 0.005
    frame = np.dstack([colours, rng.normal(7.0, 0.4, (256, 256)) * (10.0 if dtype is np.uint8 else 1.0)]).astype(dtype)
    assert not anomaly_mask(rx_scores(frame), min_score=default_min_score(4)).any()
    frame[100:104, 50:53, 3] += 100 if dtype is np.uint8 else 10
    mask = anomaly_mask(rx_scores(frame), min_score=default_min_score(4))
    assert mask[100:104, 50:53].all()
    assert mask.sum() == 12


def test_what_varies_more_than_rounding_is_scored_as_it_is() -> None:
    image = np.rint(background(np.random.default_rng(8), (64, 48), 4))
    np.testing.assert_allclose(rx_scores(image), reference_scores(image), rtol=1e-4, atol=1e-3)


def test_scores_average_to_the_number_of_channels() -> None:
    image = background(np.random.default_rng(2), (100, 200), 3)
    assert rx_scores(image).mean(dtype=np.float64) == pytest.approx(3 * (1 - 1 / 20_000), rel=1e-4)


def test_dependent_and_constant_channels_add_nothing() -> None:
    image = background(np.random.default_rng(3), (50, 60), 5)
    image[:, :, 1] = image[:, :, 0]
    image[:, :, 3] = 2 * image[:, :, 2] + 7
    image[:, :, 4] = 42.0
    np.testing.assert_allclose(rx_scores(image), reference_scores(image[:, :, [0, 2]]), rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize("shape", [(8, 9, 4), (1, 1, 3)])
def test_an_image_without_variation_scores_zero(shape: tuple[int, int, int]) -> None:
    assert not rx_scores(np.full(shape, 17, dtype=np.uint8)).any()


def test_small_differences_of_large_values_count() -> None:
    celsius = background(np.random.default_rng(4), (80, 80), 1) * 0.01
    kelvin_x100 = (celsius * 100 + 29_315).round().astype(np.uint16)
    np.testing.assert_allclose(rx_scores(kelvin_x100), reference_scores(kelvin_x100), rtol=5e-3, atol=1e-3)


def test_pixels_that_are_not_finite_take_no_part() -> None:
    image = background(np.random.default_rng(5), (40, 40), 3)
    complete = image.copy()
    image[3, 4, 1], image[30, 2, 0] = np.nan, np.inf
    scores = rx_scores(image)
    assert sorted(zip(*np.nonzero(np.isnan(scores)), strict=True)) == [(3, 4), (30, 2)]
    finite = ~np.isnan(scores)
    pixels = complete[finite][np.newaxis]
    np.testing.assert_allclose(scores[finite], reference_scores(pixels)[0], rtol=1e-3, atol=1e-3)
    assert anomaly_mask(scores, 0.5).sum() == round(0.5 * finite.sum())


def test_an_image_of_nan_has_no_scores() -> None:
    scores = rx_scores(np.full((4, 5, 2), np.nan, dtype=np.float32))
    assert np.isnan(scores).all()
    assert not anomaly_mask(scores, 0.0).any()


def test_quantile_marks_the_largest_scores() -> None:
    scores = np.random.default_rng(6).permutation(np.arange(1, 10_001, dtype=np.float32)).reshape(100, 100)
    np.testing.assert_array_equal(anomaly_mask(scores, 0.9998), scores > 9998)
    np.testing.assert_array_equal(anomaly_mask(scores, 0.5, min_score=9_990), scores > 9990)


def test_an_empty_scene_stays_unmarked_and_a_warm_person_is_marked() -> None:
    image = background(np.random.default_rng(7), (256, 256), 4)
    limit = default_min_score(4)
    assert not anomaly_mask(rx_scores(image), 0.9998, limit).any()
    image[100:103, 50:53, 3] += 200.0
    marked = anomaly_mask(rx_scores(image), 0.9998, limit)
    assert marked[100:103, 50:53].all()
    assert marked.sum() == 9


@pytest.mark.parametrize("channels", range(1, 9))
def test_default_limit_stands_above_the_tail_of_the_chi_square_distribution(channels: int) -> None:
    assert default_min_score(channels) == pytest.approx(2.5 * chdtri(channels, 1e-9), rel=1e-9)
