"""The relief for people: shading, contour lines, and what they cover."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

pytest.importorskip("rasterio")

from aos_gcs.errors import InputDataError
from aos_gcs.planning.terrain import relief as relief_module
from aos_gcs.planning.terrain.ground import EnuBounds
from aos_gcs.planning.terrain.relief import HeightUnit, Relief, contours, read_relief, relief_bounds, shading_png
from tests.fakes.relief import ORIGIN, hill, terrain, write_relief

BOUNDS = EnuBounds(-300.0, -200.0, 300.0, 200.0)


def alpha_and_white(relief: Relief) -> tuple[np.ndarray, np.ndarray]:
    picture = cv2.imdecode(np.frombuffer(shading_png(relief), np.uint8), cv2.IMREAD_UNCHANGED)
    return picture[..., 3], picture[..., 0] == 255


def slope(towards_east: float, towards_north: float) -> Relief:
    north_m, east_m = np.mgrid[200.0:-200.0:41j, -300.0:300.0:61j]
    return Relief(BOUNDS, (500.0 + towards_east * east_m + towards_north * north_m).astype(np.float32))


def test_heights_are_those_of_the_model_above_the_sea(tmp_path: Path) -> None:
    def ground(east: np.ndarray, north: np.ndarray) -> np.ndarray:
        return 20.0 * np.sin(east / 90.0) + 0.1 * north

    file = write_relief(tmp_path / "ground.tif", ground, cell=2.0)
    relief = read_relief(terrain(file), ORIGIN, BOUNDS)
    rows, columns = relief.heights_amsl_m.shape
    north_m, east_m = np.mgrid[200.0 : -200.0 : rows * 1j, -300.0 : 300.0 : columns * 1j]
    assert relief.cell_m == pytest.approx((2.0, 2.0), rel=0.01)
    assert relief.heights_amsl_m == pytest.approx(ORIGIN.altitude_amsl_m + ground(east_m, north_m), abs=0.1)


def test_slopes_towards_the_north_west_are_bright_and_those_away_from_it_dark() -> None:
    alpha, is_white = alpha_and_white(slope(0.2, -0.2))  # falls towards north-west
    assert is_white.all()
    assert alpha.min() > 20
    alpha, is_white = alpha_and_white(slope(-0.2, 0.2))
    assert not is_white.any()
    assert alpha.min() > 20
    assert (alpha_and_white(slope(0.0, 0.0))[0] == 0).all()


def test_contours_lie_where_the_ground_has_their_height() -> None:
    lines = contours(slope(0.1, 0.0))
    assert lines.interval_m == 1.0
    assert lines.spacing_m == pytest.approx(10.0, rel=0.03)
    assert {line.altitude_amsl_m for line in lines.lines} == set(range(470, 530))
    for line in lines.lines:
        assert line.points_enu_m[:, 0] == pytest.approx((line.altitude_amsl_m - 500.0) / 0.1, abs=0.1)
        assert np.ptp(line.points_enu_m[:, 1]) == pytest.approx(400.0)


def test_heights_of_contours_are_round_in_feet_where_they_are_shown_so() -> None:
    lines = contours(slope(0.1, 0.0), HeightUnit.FOOT)
    assert lines.interval_m == pytest.approx(5.0 * 0.3048)
    feet = [line.altitude_amsl_m / 0.3048 for line in lines.lines]
    assert feet == pytest.approx(range(1545, 1740, 5))
    for line in lines.lines:
        assert line.points_enu_m[:, 0] == pytest.approx((line.altitude_amsl_m - 500.0) / 0.1, abs=0.1)


@pytest.mark.parametrize(
    ("rise_m", "unit", "interval"),
    [
        (99.0, HeightUnit.METRE, 1.0),
        (101.0, HeightUnit.METRE, 2.0),
        (900.0, HeightUnit.METRE, 10.0),
        (140.0, HeightUnit.FOOT, 5.0),
        (900.0, HeightUnit.FOOT, 50.0),
        (90_000.0, HeightUnit.FOOT, 2000.0),
    ],
)
def test_the_interval_follows_the_range_of_heights(rise_m: float, unit: HeightUnit, interval: float) -> None:
    lines = contours(slope(rise_m / 600.0, 0.0), unit)
    assert lines.interval_m == pytest.approx(interval * (0.3048 if unit is HeightUnit.FOOT else 1.0))


def test_level_ground_has_no_contours_and_a_spacing() -> None:
    lines = contours(Relief(BOUNDS, np.full((41, 61), 500.4, dtype=np.float32)))
    assert lines.lines == ()
    assert lines.spacing_m == 600.0


def test_a_line_around_a_hill_is_closed_and_as_far_out_as_the_hill_has_its_height() -> None:
    north_m, east_m = np.mgrid[200.0:-200.0:81j, -300.0:300.0:121j]
    heights = 500.0 + hill(20.0, 30.0, 10.0, 60.0)(east_m, north_m)
    for line in contours(Relief(BOUNDS, heights.astype(np.float32))).lines:
        if line.altitude_amsl_m > 501.0:
            assert (line.points_enu_m[0] == line.points_enu_m[-1]).all()
            radius_m = np.hypot(*(line.points_enu_m - (20.0, 30.0)).T)
            assert np.ptp(radius_m) < 5.0
            assert hill(0.0, 0.0, 10.0, 60.0)(radius_m.mean(), 0.0) == pytest.approx(
                line.altitude_amsl_m - 500.0, abs=0.3
            )


def test_rough_ground_has_no_more_lines_than_can_be_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    rough = 500.0 + 5.0 * np.random.default_rng(1).normal(size=(80, 120)).astype(np.float32)
    monkeypatch.setattr(relief_module, "MAX_POINTS", 3000)
    lines = contours(Relief(BOUNDS, rough))
    assert sum(len(line.points_enu_m) for line in lines.lines) <= 3000
    assert lines.interval_m > 1.0


def test_the_distance_between_lines_is_that_where_the_ground_is_known() -> None:
    relief = slope(0.1, 0.0)
    relief.heights_amsl_m[:, 20:] = np.nan
    assert contours(relief).spacing_m == pytest.approx(10.0, rel=0.1)


def test_a_hole_is_transparent_and_without_lines() -> None:
    relief = slope(0.1, 0.1)
    relief.heights_amsl_m[10:20, 10:20] = np.nan
    alpha, _ = alpha_and_white(relief)
    assert (alpha[11:19, 11:19] == 0).all()
    for line in contours(relief).lines:
        column = (line.points_enu_m[:, 0] + 300.0) / 10.0
        row = (200.0 - line.points_enu_m[:, 1]) / 10.0
        assert not ((column > 9.5) & (column < 19.5) & (row > 9.5) & (row < 19.5)).any()


def test_the_relief_covers_the_mission_and_the_origin_but_not_the_whole_country() -> None:
    assert relief_bounds([]) == EnuBounds(-800.0, -800.0, 800.0, 800.0)
    assert relief_bounds([(1000.0, 0.0), (1200.0, 900.0)]) == EnuBounds(-800.0, -800.0, 1600.0, 1300.0)
    assert relief_bounds([(90_000.0, 0.0)]).east_m == 6000.0


def test_a_model_of_another_place_is_named(tmp_path: Path) -> None:
    file = write_relief(tmp_path / "elsewhere.tif", hill(0.0, 0.0, 5.0), reach_m=100.0)
    with pytest.raises(InputDataError, match=r"elsewhere\.tif: the elevation model has no heights"):
        read_relief(terrain(file), ORIGIN, EnuBounds(2000.0, 2000.0, 2300.0, 2300.0))
