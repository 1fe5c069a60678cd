"""Significance of marks that images of a survey agree on: its rate of false alarms, and what it is for."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.projection import Plane
from aos_gcs.imaging.model import MapRaster
from aos_gcs.surveys.anomalies import MapBlob, significant_blobs
from aos_gcs.surveys.levels import REACH_M
from aos_gcs.surveys.significance import AnomalySums, significance, significance_limit

CELL_M, EDGE, VIEWS = 0.2, 700, 30
HECTARES = (EDGE * CELL_M) ** 2 / 1e4
RASTER = MapRaster(0.0, 0.0, CELL_M, EDGE, EDGE, rows_along_y=True)
COVERAGE = np.full((EDGE, EDGE), VIEWS, dtype=np.uint16)


def marks_by_chance(seed: int, per_m2: NDArray[np.float64] | float, ratio: float = 0.4) -> AnomalySums:
    """Marks of 0.6 m that lie elsewhere in each image; some ground is more restless."""
    rng = np.random.default_rng(seed)
    sums = AnomalySums.none((EDGE, EDGE))
    density = np.broadcast_to(per_m2, (EDGE, EDGE))
    for _ in range(VIEWS):
        number = rng.poisson(density.max() * (EDGE * CELL_M) ** 2)
        rows, columns = rng.integers(0, EDGE, (2, number))
        kept = rng.random(number) * density.max() < density[rows, columns]
        level = np.zeros((EDGE, EDGE), dtype=np.uint8)
        level[rows[kept], columns[kept]] = np.minimum(rng.geometric(1.0 - ratio, np.count_nonzero(kept)), 13)
        grown = cv2.dilate(level, np.ones((3, 3), dtype=np.uint8))
        sums.count[...] += grown > 0
        sums.excess[...] += np.maximum(grown, 1) - np.uint8(1)
    return sums


def mark(sums: AnomalySums, row: int, column: int, *, images: int, level: int, edge: int = 5) -> None:
    window = slice(row, row + edge), slice(column, column + edge)
    sums.count[window] += np.uint16(images)
    sums.excess[window] += np.uint32(images * (level - 1))


def rows_of(sums: AnomalySums, per_ha: float, coverage: NDArray[np.uint16] = COVERAGE) -> list[MapBlob]:
    found = significance(sums, coverage, CELL_M)
    return significant_blobs(sums, found, coverage, RASTER, Plane(0.0), false_alarms_per_ha=per_ha)


@pytest.mark.parametrize("per_m2", [0.005, 0.03])
def test_chance_makes_as_many_rows_as_it_may(per_m2: float) -> None:
    allowed = 20.0
    rows = rows_of(marks_by_chance(1, per_m2), allowed)
    assert 0.1 * allowed * HECTARES < len(rows) < 1.5 * allowed * HECTARES


def test_restless_ground_is_judged_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    per_m2 = np.full((EDGE, EDGE), 0.01)
    per_m2[:, EDGE // 2 :] = 0.1
    sums = marks_by_chance(2, per_m2)

    def restless() -> int:
        # Within half a neighbourhood of the border the calm ground counts as well.
        return sum(row.position_m[0] > EDGE // 2 * CELL_M + 10.0 for row in rows_of(sums, 5.0))

    by_itself = restless()
    # Where marks are dense, a place has more ways to be marked by several.
    assert by_itself < 3.0 * 5.0 * HECTARES / 2
    monkeypatch.setattr("aos_gcs.surveys.significance.NEIGHBOURHOOD_M", 280.0)
    assert restless() > 1.4 * by_itself


def test_what_few_images_mark_strongly_stands_out_and_what_one_marks_does_not() -> None:
    sums = marks_by_chance(3, 0.01)
    mark(sums, 200, 300, images=4, level=8)
    sums.count[590:620, 290:320] = sums.excess[590:620, 290:320] = 0
    mark(sums, 600, 300, images=1, level=13)
    first, *others = rows_of(sums, 0.1)
    assert not any(abs(row.position_m[1] - 120.5) < 2.0 for row in others)
    assert first.position_m[:2] == pytest.approx((60.5, 40.5), abs=0.5)
    assert first.max_count >= 4
    assert first.agreement == pytest.approx(4 / VIEWS, abs=0.05)
    assert first.significance is not None
    assert first.significance > significance_limit(0.1)


def test_more_images_that_see_a_place_and_do_not_mark_it_make_it_less_significant() -> None:
    sums = marks_by_chance(4, 0.02)
    mark(sums, 400, 400, images=3, level=6)
    strengths = []
    for views in (5, 120):
        coverage = COVERAGE.copy()
        coverage[398:408, 398:408] = views
        strengths.append(significance(sums, coverage, CELL_M)[402, 402])
    assert strengths[0] > strengths[1] + 0.5


def test_fragments_of_a_person_are_one_row_and_persons_apart_are_two() -> None:
    sums = marks_by_chance(5, 0.005)
    for column in (300, 307, 330):
        mark(sums, 400, column, images=8, level=6, edge=3)
    mark(sums, 400, 330, images=6, level=6, edge=3)
    rows = rows_of(sums, 0.1)
    assert [round(row.position_m[0]) for row in rows] == [66, 61]
    assert rows[1].area_m2 == pytest.approx(18 * CELL_M**2, rel=0.2)


def test_what_is_longer_than_a_person_says_so() -> None:
    sums = marks_by_chance(5, 0.005)
    mark(sums, 400, 300, images=12, level=6, edge=10)
    for step in range(8):
        mark(sums, 100 + 4 * step, 500 + 4 * step, images=8, level=6, edge=4)
    person, line = sorted(rows_of(sums, 0.1), key=lambda row: row.length_m or 0.0)
    assert person.length_m == pytest.approx(2.8 - 2 * REACH_M, abs=0.3)
    assert not person.is_longer_than_a_person
    assert line.length_m == pytest.approx(32 * CELL_M * 2**0.5 - 2 * REACH_M, abs=0.7)
    assert line.is_longer_than_a_person


def test_the_same_ground_in_other_cells_is_as_significant() -> None:
    fine = marks_by_chance(6, 0.01)
    mark(fine, 400, 400, images=5, level=6, edge=6)
    coarse = AnomalySums(fine.count[::2, ::2].copy(), fine.excess[::2, ::2].copy())
    strong = significance(fine, COVERAGE, CELL_M)[402, 402]
    assert significance(coarse, COVERAGE[::2, ::2], 2 * CELL_M)[201, 201] == pytest.approx(strong, rel=0.1)


def test_a_map_without_marks_has_no_rows_and_rates_that_cannot_be_are_refused() -> None:
    assert rows_of(AnomalySums.none((EDGE, EDGE)), 1.0) == []
    for rate in (0.0, -1.0, 3e4, float("nan")):
        with pytest.raises(ConfigurationError, match="--false-alarms-per-ha must lie between 0 and 20000"):
            significance_limit(rate)
