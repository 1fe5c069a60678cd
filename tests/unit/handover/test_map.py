"""The map of a hand-over: shades of the searched ground, and its scale."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from aos_gcs.errors import InputDataError
from aos_gcs.groundmap.figures import DetectionFigures, GroundFigures
from aos_gcs.handover.map import nice_length_m
from aos_gcs.handover.model import Raster
from aos_gcs.handover.searched import searched_grey
from aos_gcs.handover.texts import searched_lines
from aos_gcs.mission.model.steps import PictureKind
from tests.fakes import records


@example(999999.9999999999)
@given(st.floats(0.01, 1e6))
def test_scales_are_round_and_fit(most_m: float) -> None:
    length_m = nice_length_m(most_m)
    assert length_m <= most_m < 2.5 * length_m * (1.0 + 1e-9)


def raster(kind: PictureKind, shares: list[float]) -> Raster:
    """Return a row of cells as the dashboard shows it; the first one was not searched."""
    bgr = cv2.applyColorMap((255.0 * np.array([shares])).astype(np.uint8), cv2.COLORMAP_VIRIDIS)
    alpha = np.full((1, len(shares)), 150, dtype=np.uint8)
    alpha[0, 0] = 0
    return Raster(kind, cv2.imencode(".png", np.dstack((bgr, alpha)))[1].tobytes(), 0.0, 0.0, 1.0, 1.0)


def test_likelier_ground_is_darker_and_what_was_not_searched_stays_white() -> None:
    (grey,) = searched_grey(raster(PictureKind.DETECTION, [0.5, 0.0, 0.5, 1.0]))
    assert grey.tolist() == [255, 245, 215, 185]
    assert set(searched_grey(raster(PictureKind.COVERAGE, [0.0, 0.1, 0.9]))[0]) == {255, 215}


@given(st.lists(st.floats(0.0, 1.0), min_size=2, max_size=20))
def test_shares_are_read_back_from_their_colours(shares: list[float]) -> None:
    (grey,) = searched_grey(raster(PictureKind.VIEWS, [0.0, *shares]))
    expected = [245.0 - 60.0 * share for share in shares]
    np.testing.assert_allclose(grey[1:], expected, atol=1.0)


def test_a_damaged_raster_is_named() -> None:
    with pytest.raises(InputDataError, match="picture detection of the searched ground is damaged"):
        searched_grey(Raster(PictureKind.DETECTION, b"no picture", 0.0, 0.0, 1.0, 1.0))


def test_the_probability_of_detection_is_told_where_it_is_known() -> None:
    final = replace(records.snapshot(), covered_fraction=0.9)
    assert searched_lines(final) == ("90%",)
    figures = GroundFigures(10, 0, 0.8, 3.0, DetectionFigures(0.5, 0.6, 0.7))
    known = replace(final, ground=figures)
    assert searched_lines(known) == ("80%", "Mean probability of detection: standing 50%, sitting 60%, lying 70%")
    assert searched_lines(replace(final, ground=replace(figures, detection=None))) == ("80%",)
