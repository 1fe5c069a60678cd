"""Pictures of few colours."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aos_gcs.imaging.indexed import IndexedPicture

SHADES = np.arange(256, dtype=np.uint8)


def decoded(png: bytes) -> np.ndarray:
    return cv2.cvtColor(cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_UNCHANGED), cv2.COLOR_BGRA2RGBA)


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (5, 1), (40, 300)])
def test_files_show_what_the_picture_holds(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(0)
    picture = IndexedPicture.of(SHADES, rng.integers(0, 256, shape), rng.random(shape) < 0.8)
    np.testing.assert_array_equal(decoded(picture.png()), picture.rgba())


def test_colours_are_those_of_the_map_but_for_the_darkest_two() -> None:
    values = SHADES.reshape(16, 16)
    shown = np.ones(values.shape, dtype=np.bool_)
    shown[15, 15] = False
    rgba = IndexedPicture.of(SHADES, values, shown).rgba()
    expected = cv2.cvtColor(cv2.applyColorMap(values, cv2.COLORMAP_INFERNO), cv2.COLOR_BGR2RGBA)
    expected[0, 1] = expected[0, 0]
    expected[15, 15] = 0
    np.testing.assert_array_equal(rgba, expected)


def test_values_beyond_a_byte_have_the_shades_of_their_table() -> None:
    values = np.array([[0, 299]], dtype=np.uint16)
    table = np.linspace(0, 255, 300).astype(np.uint8)
    rgba = IndexedPicture.of(table, values, np.ones((1, 2), dtype=np.bool_)).rgba()
    ends = cv2.applyColorMap(np.array([[0, 255]], dtype=np.uint8), cv2.COLORMAP_INFERNO)
    np.testing.assert_array_equal(rgba, cv2.cvtColor(ends, cv2.COLOR_BGR2RGBA))
