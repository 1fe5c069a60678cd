"""Thermal images without the blur of their optics."""

import cv2
import numpy as np
import pytest

from aos_gcs.imaging.persons.restoration import BLUR_PX, WIDE_BLUR_PX, restored


@pytest.fixture
def scene() -> np.ndarray:
    """A body behind leaves, and a stone in the open: 25 and 20 °C on ground of 11 °C."""
    rng = np.random.default_rng(1)
    image = np.full((64, 64), 11.0, np.float32)
    image[10:30, 10:30][rng.random((20, 20)) < 0.15] = 25.0
    image[40:52, 40:52] = 20.0
    return image


def blurred(image: np.ndarray, blur_px: float = BLUR_PX) -> np.ndarray:
    return cv2.GaussianBlur(image, (9, 9), blur_px, borderType=cv2.BORDER_REFLECT)


def test_spots_behind_leaves_get_their_own_temperature_back(scene: np.ndarray) -> None:
    noise = np.random.default_rng(2).normal(0.0, 0.08, scene.shape).astype(np.float32)
    image = blurred(scene) + noise
    assert np.median(image[scene == 25.0]) < 19.0
    assert np.median(restored(image).image[scene == 25.0]) == pytest.approx(25.0, abs=1.0)
    assert np.median(restored(image).image[scene == 20.0]) == pytest.approx(20.0, abs=0.3)


def forest(*bodies: tuple[slice, float]) -> np.ndarray:
    """Leaves and ground of 10 to 12 °C in patches of a pixel and more, and squares of given temperatures."""
    rng = np.random.default_rng(4)
    scene = (
        sum(
            cv2.resize(rng.normal(0.0, 0.4, (size, size)), (256, 256), interpolation=cv2.INTER_NEAREST)
            for size in (256, 128, 64, 32)
        )
        + 11.0
    )
    for where, celsius in bodies:
        scene[where, where] = celsius
    return scene.astype(np.float32)


def test_optics_out_of_focus_are_told_by_the_image_and_their_blur_is_taken_back() -> None:
    """Skin of 31 °C in clothes of 25 °C, 0.3 and 0.6 m wide as from 35 m."""
    where = slice(123, 128)
    scene = forest((slice(120, 131), 25.0), (where, 31.0))
    noise = np.random.default_rng(2).normal(0.0, 0.08, scene.shape).astype(np.float32)
    wide = blurred(scene, WIDE_BLUR_PX) + noise
    assert restored(wide).out_of_focus
    assert not restored(blurred(scene) + noise).out_of_focus
    lost_k, left_k = (31.0 - np.median(image[where, where]) for image in (wide, restored(wide).image))
    assert left_k < 0.6 * lost_k
    usual = restored(blurred(scene) + noise).image
    assert np.median(usual[where, where]) == pytest.approx(31.0, abs=0.5)
    assert usual.max() < 33.0, "a sharper image is not sharpened as much: nothing gets warmer than it is"


def test_an_image_without_blur_stays_as_it_is(scene: np.ndarray) -> None:
    np.testing.assert_array_equal(restored(scene).image, scene)


def test_pixels_without_a_value_have_none_and_change_no_other(scene: np.ndarray) -> None:
    image = blurred(scene)
    image[60:, 60:] = np.nan
    sharp = restored(image).image
    np.testing.assert_array_equal(np.isnan(sharp), np.isnan(image))
    np.testing.assert_allclose(sharp[:52, :52], restored(blurred(scene)).image[:52, :52], atol=1e-3)
    assert np.isnan(restored(np.full((8, 8), np.nan)).image).all()
