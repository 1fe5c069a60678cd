"""The picture of the forest floor: means of tiles in few cells, stretched, transparent where nothing is known."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from aos_gcs.geometry.projection import Plane
from aos_gcs.groundmap import floor, ground_map
from aos_gcs.groundmap.floor import FINEST_CELLS, ForestFloor, reduced_means
from aos_gcs.groundmap.ground_map import GroundMap, open_map
from aos_gcs.groundmap.tile import Tile
from aos_gcs.groundmap.work import GroundSource, SearchedArea, add_frames, opened_map
from aos_gcs.imaging.pictures import RasterPicture
from tests.fakes.ground_frames import COLOUR, ORIGIN, ground_frame

GROUND = Plane(0.0)
WHOLE = slice(None)
COLOURS = ("red", "green", "blue")


def tile_of(colour: tuple[int, int, int] | None, thermal: float | None, rows: slice = WHOLE) -> Tile:
    """Return a tile of two frames with these means."""
    tile = Tile.empty(1)
    if colour is not None:
        tile.colour_sum[rows] = np.array(colour) * 2
        tile.colour_count[rows] = 2
    if thermal is not None:
        tile.thermal_sum[rows] = thermal * 2
        tile.thermal_count[rows] = 2
    return tile


def floor_of(tiles: dict[tuple[int, int], Tile]) -> ForestFloor:
    made = ForestFloor()
    for index, tile in tiles.items():
        made.mark(index)
        made.keep(index, tile)
    return made


def rgba(picture: RasterPicture | None) -> np.ndarray:
    assert picture is not None
    return cv2.cvtColor(cv2.imdecode(np.frombuffer(picture.png, np.uint8), cv2.IMREAD_UNCHANGED), cv2.COLOR_BGRA2RGBA)


def test_the_picture_lies_where_the_tiles_are_and_is_transparent_between_them() -> None:
    made = floor_of({(-1, 2): tile_of((0, 50, 100), None), (0, 3): tile_of((100, 50, 0), None, slice(64, 128))})
    picture = made.picture()
    assert picture is not None
    assert (picture.kind, picture.west_m, picture.north_m, picture.east_m, picture.south_m) == (
        "floor",
        64.0,
        32.0,
        128.0,
        -32.0,
    )
    image = rgba(picture)
    assert image.shape == (128, 128, 4)
    # The smallest value of all bands becomes 0 and the largest 255: hues stay.
    assert (image[:64, :64] == (0, 127, 255, 255)).all()
    assert (image[96:, 64:] == (255, 127, 0, 255)).all()
    assert not image[:64, 64:, 3].any()
    assert not image[64:96, :, 3].any()
    assert not image[96:, :64, 3].any()


def test_temperatures_in_greys_stand_for_colours_that_no_frame_has() -> None:
    coldest, warmest = tile_of(None, 10.0, slice(0, 64)), tile_of(None, 30.0, slice(64, 128))
    both = Tile.empty(1)
    both.thermal_sum[:] = coldest.thermal_sum + warmest.thermal_sum
    both.thermal_count[:] = 2
    image = rgba(floor_of({(0, 0): both, (0, 1): tile_of((0, 100, 100), 20.0, slice(0, 64))}).picture())
    assert (image[:32, :64] == (0, 0, 0, 255)).all()
    assert (image[32:, :64] == (255, 255, 255, 255)).all()
    assert (image[:32, 64:] == (0, 255, 255, 255)).all()
    assert not image[32:, 64:, 3].any()


def test_a_cell_is_the_mean_of_all_frames_in_it() -> None:
    tile = Tile.empty(1)
    tile.colour_sum[0, 0], tile.colour_count[0, 0] = (300, 30, 3), 3
    tile.colour_sum[1, 1], tile.colour_count[1, 1] = (20, 50, 7), 1
    tile.thermal_sum[0, 1], tile.thermal_count[0, 1] = 21.0, 2
    means = reduced_means(tile, FINEST_CELLS)
    assert means[0, 0].tolist() == [80.0, 20.0, 2.5, 10.5]
    assert np.isnan(means[1:]).all()
    assert np.isnan(means[0, 1:]).all()


def test_values_beyond_what_half_precision_holds_stay_finite() -> None:
    assert np.isfinite(reduced_means(tile_of(None, 1e6), 1)[..., 3]).all()


def test_a_large_map_takes_larger_cells_and_keeps_what_it_has(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(floor, "MAX_CELLS", 2 * FINEST_CELLS**2)
    tile = tile_of((10, 20, 30), None)
    # Of the cell in the north-west, one quarter alone is known.
    tile.colour_count[0:4, 2:4] = tile.colour_count[2:4, 0:4] = 0
    tile.colour_sum[0:2, 0:2] = (80, 80, 80)
    made = floor_of({(0, 0): tile, (0, 1): tile_of((10, 20, 30), None)})
    assert rgba(made.picture()).shape[:2] == (64, 128)
    made.mark((1, 2))
    made.keep((1, 2), tile_of((10, 20, 30), None))
    picture = made.picture()
    image = rgba(picture)
    assert image.shape[:2] == (64, 96)
    assert picture is not None
    assert (picture.east_m, picture.south_m) == (96.0, -64.0)
    assert image[0, 0].tolist() == [255, 255, 255, 255]
    assert image[0, 1].tolist() == [0, 127, 255, 255]
    assert (image[32:, 64:] == image[0, 1]).all()


def begun(folder: Path) -> GroundMap:
    return open_map(folder, ORIGIN, 0.12)


def means_at(made: ForestFloor, index: tuple[int, int]) -> list[float]:
    """Return the largest means of a tile."""
    return [float(value) for value in np.fmax.reduce(made._means[index], axis=(0, 1))]


def test_tiles_that_went_to_the_disk_stay_in_the_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ground_map, "TILES_IN_MEMORY", 4)
    monkeypatch.setattr(ground_map, "FRAMES_IN_USE", 1)
    ground, usual = begun(tmp_path / "one"), begun(tmp_path / "two")
    for east_m in (16.0, 16.0, 400.0, 800.0):
        ground.add(ground_frame(east_m, -16.0), GROUND)
    assert (0, 0) not in ground._tiles
    made = ground.floor()
    assert not made.stale
    assert means_at(made, (0, 0)) == list(COLOUR)
    monkeypatch.undo()
    for east_m in (16.0, 16.0, 400.0, 800.0):
        usual.add(ground_frame(east_m, -16.0), GROUND)
    assert made.picture() == usual.floor().picture()


def test_a_frame_that_comes_later_changes_the_picture(tmp_path: Path) -> None:
    ground = begun(tmp_path)
    ground.add(ground_frame(16.0, -16.0, bands=COLOURS), GROUND)
    assert means_at(ground.floor(), (0, 0))[:3] == list(COLOUR[:3])
    brighter = np.full((64, 64, 3), 40.0, dtype=np.float32)
    ground.add(ground_frame(16.0, -16.0, bands=COLOURS, image=brighter), GROUND)
    assert means_at(ground.floor(), (0, 0))[:3] == [25.0, 30.0, 35.0]


def test_a_map_that_goes_on_is_shown_little_by_little(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    former = begun(tmp_path)
    for east_m in (16.0, 400.0):
        former.add(ground_frame(east_m, -16.0), GROUND)
    former.flush()
    monkeypatch.setattr(floor, "READ_AT_ONCE", len(former.views) - 1)
    source = GroundSource(tmp_path, ORIGIN, 0.12, None)
    opened_map.cache_clear()
    reports = [add_frames(source, (), SearchedArea((), None), pictures=True, flush=False) for _ in range(2)]
    opened_map.cache_clear()
    assert [report.is_floor_whole for report in reports] == [False, True]
    first, second = (rgba(report.floor) for report in reports)
    assert first.shape == second.shape
    assert (first[..., 3] > 0).sum() < (second[..., 3] > 0).sum()
    assert reports[1].floor == former.floor().picture()


def test_a_map_without_tiles_has_no_picture(tmp_path: Path) -> None:
    assert begun(tmp_path).floor().picture() is None
