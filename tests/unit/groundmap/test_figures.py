"""Figures and pictures of the searched ground, and the law of detection behind them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.groundmap import shading
from aos_gcs.groundmap.detection import DETECTABILITY, Detectability, Posture, detection_by_views
from aos_gcs.groundmap.figures import ViewRaster, ground_figures, view_raster
from aos_gcs.groundmap.shading import ground_pictures, prior_picture
from aos_gcs.prior.model import AreaPrior

AREA = ((0.0, 0.0), (40.0, 0.0), (40.0, 20.0), (0.0, 20.0))
FULL = np.full((32, 32), 7, dtype=np.uint8)


@given(st.lists(st.tuples(st.floats(-8.0, 70.0), st.floats(-70.0, 8.0)), min_size=3, max_size=7, unique=True))
def test_a_cell_is_inside_where_its_centre_is(corners: list[tuple[float, float]]) -> None:
    area = tuple((round(east_m, 2) + 0.003, round(north_m, 2) + 0.003) for east_m, north_m in corners)
    raster = view_raster({(0, 0): FULL, (1, 1): FULL})
    inside = raster.inside(area)
    edges = list(zip(area, (*area[1:], area[0]), strict=True))
    for row, column in ((0, 0), (5, 60), (31, 32), (32, 31), (63, 63), (40, 12)):
        east_m, north_m = column + 0.5, -row - 0.5
        west = sum(
            (b[1] > north_m) != (d[1] > north_m) and b[0] + (north_m - b[1]) * (d[0] - b[0]) / (d[1] - b[1]) < east_m
            for b, d in edges
        )
        assert inside[row, column] == (west % 2 == 1)


@given(st.floats(0.0, 1.0), st.sampled_from(Posture))
def test_more_views_never_make_detection_less_likely(occlusion: float, posture: Posture) -> None:
    shares = detection_by_views(occlusion, DETECTABILITY[posture])
    assert shares.shape == (256,)
    assert shares[0] == 0.0
    assert (np.diff(shares) >= 0.0).all()
    assert 0.0 <= shares[-1] <= 1.0


@given(st.floats(0.01, 0.98), st.sampled_from(Posture))
def test_a_denser_canopy_never_makes_detection_more_likely(occlusion: float, posture: Posture) -> None:
    thin, dense = (detection_by_views(one, DETECTABILITY[posture]) for one in (occlusion, occlusion + 0.01))
    assert (dense <= thin + 1e-12).all()


def test_the_law_is_that_of_search_theory() -> None:
    shares = detection_by_views(0.5, Detectability(worth=0.5))
    assert shares[4] == pytest.approx(1.0 - np.exp(-1.0))
    shares = detection_by_views(0.75, Detectability(worth=0.25, slope=0.5, shape=2.0))
    assert shares[8] == pytest.approx(1.0 - np.exp(-1.0))


def test_a_view_is_worth_the_share_of_the_ground_that_it_shows() -> None:
    for posture in Posture:
        thin, dense = (detection_by_views(one, DETECTABILITY[posture]) for one in (0.5, 0.875))
        np.testing.assert_allclose(dense[::4], thin[: len(dense[::4])])


def test_lying_persons_are_noticed_more_easily_from_above_than_standing_ones() -> None:
    standing, sitting, lying = (detection_by_views(0.85, DETECTABILITY[one])[8] for one in Posture)
    assert standing < sitting < lying


def test_a_raster_holds_all_tiles_and_the_area() -> None:
    raster = view_raster({(0, 0): FULL, (-3, 1): FULL}, AREA)
    assert (raster.west_m, raster.north_m) == (0.0, 96.0)
    assert raster.views.shape == (128, 64)
    # Tile (0, 0) lies south of the origin, tile (-3, 1) 64 m to 96 m north of it.
    assert (raster.views[96:, :32] == 7).all()
    assert (raster.views[:32, 32:] == 7).all()
    assert raster.views.sum() == 2 * 7 * 32 * 32


def test_figures_are_those_of_the_area_alone() -> None:
    # Half of the area was seen: tile (-1, 0) covers its first 32 of 40 m.
    tile = FULL.copy()
    tile[:, 20:] = 0
    figures = ground_figures(view_raster({(-1, 0): tile, (5, 5): FULL}, AREA), AREA, None, 12, 3)
    assert (figures.frames, figures.left_out, figures.detection) == (12, 3, None)
    assert figures.seen_fraction == 0.5
    assert figures.mean_views == 3.5


def test_the_mean_detection_is_that_of_the_cells_not_of_the_mean_views() -> None:
    tile = FULL.copy()
    tile[:, 20:] = 0
    figures = ground_figures(view_raster({(-1, 0): tile}, AREA), AREA, 0.85, 1, 0)
    assert figures.detection is not None
    everywhere = detection_by_views(0.85, DETECTABILITY[Posture.LYING])[7]
    assert figures.detection.lying == pytest.approx(figures.seen_fraction * everywhere, abs=1e-9)


def test_nothing_of_an_area_that_is_still_to_be_drawn_was_seen() -> None:
    figures = ground_figures(view_raster({(0, 0): FULL}), (), 0.85, 1, 0)
    assert (figures.seen_fraction, figures.mean_views) == (0.0, 0.0)
    assert figures.detection is not None
    assert figures.detection.lying == 0.0


def pixels(png: bytes) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_UNCHANGED)


def test_pictures_are_transparent_where_nothing_was_seen_and_lie_where_the_tiles_are() -> None:
    tile = FULL.copy()
    tile[0, 0] = 0
    (views,) = ground_pictures(view_raster({(-1, 2): tile}), None)
    assert (views.kind, views.west_m, views.north_m, views.east_m, views.south_m) == ("views", 64.0, 32.0, 96.0, 0.0)
    image = pixels(views.png)
    assert image[0, 0, 3] == 0
    assert (image[1:, :, 3] > 0).all()
    assert [one.kind for one in ground_pictures(view_raster({(-1, 2): tile}), 0.85)] == ["views", "detection"]


def test_the_picture_of_a_prior_is_transparent_where_nobody_can_be_and_brightest_where_it_is_likeliest() -> None:
    prior = AreaPrior(west_m=-20.0, north_m=50.0, cell_m=10.0, mass=np.array([[0.0, 0.1, 0.2], [0.4, 0.0, 0.1]]))
    picture = prior_picture(prior)
    assert (picture.kind, picture.west_m, picture.east_m) == ("prior", -20.0, 10.0)
    assert (picture.south_m, picture.north_m) == (30.0, 50.0)
    image = pixels(picture.png)
    assert (image[..., 3] > 0).tolist() == [[False, True, True], [True, False, True]]
    bright = cv2.cvtColor(image[..., :3], cv2.COLOR_BGR2GRAY).astype(int)
    assert bright[1, 0] > bright[0, 2] > bright[0, 1] == bright[1, 2]


def test_a_prior_that_has_nobody_in_the_area_has_a_picture_without_colours() -> None:
    image = pixels(prior_picture(AreaPrior(0.0, 0.0, 1.0, np.zeros((2, 2)))).png)
    assert not image[..., 3].any()


def test_a_large_map_is_reduced_to_what_its_least_seen_part_has(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shading, "MAX_PICTURE_CELLS", 64 * 64 // 4)
    views = np.full((64, 63), 9, dtype=np.uint8)
    views[10, 11] = 0
    (picture,) = ground_pictures(ViewRaster(0, 0, views), None)
    image = pixels(picture.png)
    assert image.shape[:2] == (32, 32)
    assert (picture.east_m, picture.south_m) == (64.0, -64.0)
    assert image[5, 5, 3] == 0
    assert image[5, 6, 3] > 0
