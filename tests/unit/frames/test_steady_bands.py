from __future__ import annotations

import numpy as np

from aos_drivers.frames.steady_bands import GREY_FRAMES, SteadyBands

COLOURS, GREY = ("red", "green", "blue"), ("grey",)
COLOUR_IMAGE = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
BLACK = np.zeros((2, 4, 1), np.uint8)


def test_a_black_frame_of_a_colour_camera_has_three_bands() -> None:
    bands = SteadyBands()
    assert bands.settle(COLOUR_IMAGE, COLOURS) == (COLOUR_IMAGE, COLOURS)
    image, names = bands.settle(BLACK + 7, GREY)
    assert names == COLOURS
    np.testing.assert_array_equal(image, np.full((2, 4, 3), 7, np.uint8))


def test_a_grey_camera_stays_grey() -> None:
    bands = SteadyBands()
    assert all(bands.settle(BLACK, GREY) == (BLACK, GREY) for _ in range(3))


def test_a_camera_that_is_grey_for_long_is_a_grey_one() -> None:
    bands = SteadyBands()
    bands.settle(COLOUR_IMAGE, COLOURS)
    names = [bands.settle(BLACK, GREY)[1] for _ in range(GREY_FRAMES + 1)]
    assert names == [COLOURS] * (GREY_FRAMES - 1) + [GREY] * 2
    assert bands.settle(COLOUR_IMAGE, COLOURS)[1] == COLOURS


def test_single_grey_frames_between_those_of_colours_change_nothing() -> None:
    bands = SteadyBands()
    for _ in range(GREY_FRAMES):
        bands.settle(COLOUR_IMAGE, COLOURS)
        assert bands.settle(BLACK, GREY)[1] == COLOURS


def test_frames_with_a_thermal_band_are_left_as_they_are() -> None:
    bands = SteadyBands()
    bands.settle(COLOUR_IMAGE, COLOURS)
    image, names = np.zeros((2, 4, 4), np.float32), (*COLOURS, "thermal")
    assert bands.settle(image, names) == (image, names)
    assert bands.settle(BLACK, GREY) == (BLACK, GREY)
