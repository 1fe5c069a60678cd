"""What the detector marks of a person in frames, as whole searches take it into account."""

from __future__ import annotations

import numpy as np
import pytest

from aos_gcs.groundmap.detection import Posture
from aos_gcs.lab.search.marks import marks, persons_share

RESOLUTION_M = 0.05
PIXEL_M2 = 0.0053
"""Area of the ground that a pixel covers from 40 m."""


def shown(cells: int, frames: int = 200) -> np.ndarray:
    """Return frames that show so many cells of a person in the middle of the raster."""
    seen = np.zeros((frames, 40, 40), dtype=np.bool_)
    flat = np.zeros(100, dtype=np.bool_)
    flat[:cells] = True
    seen[:, 15:25, 15:25] = flat.reshape(10, 10)
    return seen


def marked(cells: int, share: float, posture: Posture = Posture.STANDING) -> np.ndarray:
    seen, rng = shown(cells), np.random.default_rng(1)
    return marks(seen, np.full(len(seen), PIXEL_M2), RESOLUTION_M, posture=posture, share=share, rng=rng)


@pytest.mark.parametrize(("cells", "share"), [(0, 1.0), (100, 0.0)])
def test_nothing_is_marked_where_nothing_is_seen_or_the_person_is_never_marked(cells: int, share: float) -> None:
    assert not marked(cells, share).any()


def test_the_share_of_frames_grows_with_what_they_show() -> None:
    shares = [marked(cells, 0.5).any(axis=(1, 2)).mean() for cells in (1, 10, 100)]
    assert shares[0] < shares[1] < shares[2] == pytest.approx(0.5, abs=0.08)


@pytest.mark.parametrize(("posture", "share"), [("standing", 0.65), ("sitting", 0.55), ("lying", 0.55)])
def test_a_frame_marks_more_than_half_of_what_it_shows_and_a_pixel_at_least(posture: str, share: float) -> None:
    per_frame = marked(100, 1.0, Posture(posture)).sum(axis=(1, 2))
    assert per_frame[per_frame > 0].mean() == pytest.approx(100.0 * share, abs=2.0)
    few = marked(2, 1.0, Posture(posture)).sum(axis=(1, 2))
    assert (few[few > 0] == 2).all(), "a pixel covers two cells"


def test_marks_of_one_frame_lie_together_and_away_from_those_of_another() -> None:
    together = marked(100, 1.0).any(axis=0)
    assert together.sum() > 100, "poses err"
    rows, columns = np.nonzero(marked(100, 1.0)[0])
    assert np.ptp(rows) <= 9
    assert np.ptp(columns) <= 9


@pytest.mark.parametrize(
    ("posture", "mean", "least", "most"),
    [("standing", 0.48, 0.15, 0.25), ("sitting", 0.50, 0.08, 0.17), ("lying", 0.66, 0.08, 0.16)],
)
def test_persons_differ_and_each_is_the_same_again(posture: str, mean: float, least: float, most: float) -> None:
    shares = np.array([persons_share(seed, Posture(posture)) for seed in range(400)])
    assert shares.mean() == pytest.approx(mean, abs=0.03)
    assert least < shares.std() < most
    assert persons_share(7, Posture(posture)) == persons_share(7, Posture(posture))
