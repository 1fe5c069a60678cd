"""Views of the searched ground that are too old to count: figures, later views, files, and maps without times."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.projection import Plane
from aos_gcs.groundmap import ground_map
from aos_gcs.groundmap.figures import view_raster
from aos_gcs.groundmap.ground_map import GroundMap, open_map, tile_path
from aos_gcs.groundmap.tile import Tile, read_tile
from aos_gcs.groundmap.work import GroundSource, SearchedArea, add_frames, opened_map
from aos_gcs.planning.gaps import legs_for_gaps
from aos_gcs.planning.leg_order import chances_of, order_legs, ordered_on_map
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.settings import ForestSettings
from aos_gcs.prior.model import AreaPrior
from aos_gcs.prior.segments import Segment
from tests.fakes.ground_frames import ORIGIN, ground_frame

GROUND = Plane(0.0)
BEGIN_S = 1_800_000_000.0
FORGET_S = 600.0
ONE_CELL = slice(0, 1), slice(0, 1)
AREA = ((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0))


def begun(folder: Path) -> GroundMap:
    return open_map(folder, ORIGIN, 0.12)


def views_at(ground: GroundMap, east_m: float, north_m: float, since_s: float | None = None) -> int:
    places_m = np.array([[east_m, north_m]])
    return int(view_raster(ground.views_since(since_s)).at(places_m)[0])


def add(ground: GroundMap, east_m: float, after_s: float, forget_s: float | None = FORGET_S) -> None:
    """Add a frame that was taken some time after the beginning."""
    utc_s = BEGIN_S + after_s
    ground.add(ground_frame(east_m, 0.7), GROUND, utc_s, None if forget_s is None else utc_s - forget_s)


def without_times(folder: Path) -> None:
    """Make the tiles of a folder those of a version that wrote no times."""
    for path in folder.glob("tile_*.npz"):
        with zipfile.ZipFile(path) as archive:
            kept = {name: archive.read(name) for name in archive.namelist() if name != "latest_s.npy"}
        with zipfile.ZipFile(path, "w") as archive:
            for name, content in kept.items():
                archive.writestr(name, content)


def test_views_count_until_they_are_too_old(tmp_path: Path) -> None:
    ground = begun(tmp_path)
    add(ground, 0.0, 0.0)
    assert ground.latest_s == BEGIN_S
    assert views_at(ground, 3.3, 0.2, BEGIN_S - 1.0) == 1
    assert views_at(ground, 3.3, 0.2, BEGIN_S) == 1
    assert views_at(ground, 3.3, 0.2, BEGIN_S + 0.5) == 0
    assert views_at(ground, 3.3, 0.2) == 1, "where nothing is forgotten they count for ever"


@pytest.mark.parametrize(("after_s", "views"), [(FORGET_S, 2), (FORGET_S + 1.0, 1)])
def test_old_views_do_not_help_those_that_come_too_late(tmp_path: Path, after_s: float, views: int) -> None:
    ground = begun(tmp_path)
    add(ground, 0.0, 0.0)
    add(ground, 12.0, after_s)
    assert views_at(ground, 3.3, 0.2, BEGIN_S + after_s - FORGET_S) == views
    # From the former direction: what was forgotten is new again.
    add(ground, 0.0, after_s + 1.0)
    assert views_at(ground, 3.3, 0.2) == 2


def test_a_place_that_is_seen_again_in_time_keeps_its_views(tmp_path: Path) -> None:
    ground = begun(tmp_path)
    for number, east_m in enumerate((0.0, 12.0, -12.0)):
        add(ground, east_m, number * FORGET_S)
    assert views_at(ground, 3.3, 0.2, BEGIN_S + 2.0 * FORGET_S) == 3


def test_where_nothing_is_forgotten_views_add_up_and_their_times_are_known(tmp_path: Path) -> None:
    ground = begun(tmp_path)
    add(ground, 0.0, 0.0, None)
    add(ground, 12.0, 1e6, None)
    assert views_at(ground, 3.3, 0.2) == 2
    assert ground.latest_s == BEGIN_S + 1e6


def test_cells_of_one_tile_are_of_different_age(tmp_path: Path) -> None:
    ground = begun(tmp_path)
    add(ground, 0.0, 0.0)
    add(ground, 30.0, 300.0)
    add(ground, 200.0, 900.0)
    # The first frame shows up to 18 m east, the second from 12 m on.
    since_s = BEGIN_S + 300.0
    assert [views_at(ground, east_m, 0.2, since_s) for east_m in (5.5, 15.5, 25.5, 200.5)] == [0, 2, 1, 1]
    assert views_at(ground, 5.5, 0.2) == 1


def test_colours_are_kept_for_ever(tmp_path: Path) -> None:
    ground = begun(tmp_path)
    add(ground, 16.0, 0.0)
    add(ground, 16.0, 10.0 * FORGET_S)
    tile = ground.tile((-1, 0))
    assert tile is not None
    assert tile.colour_count.max() == 2


def test_times_go_to_the_disk_and_come_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ground_map, "TILES_IN_MEMORY", 4)
    monkeypatch.setattr(ground_map, "FRAMES_IN_USE", 0)
    ground = begun(tmp_path / "one")
    for number, east_m in enumerate((0.0, 100.0, 200.0, 12.0, 112.0)):
        add(ground, east_m, 400.0 * number)
    ground.flush()
    again, copied = begun(tmp_path / "one"), open_map(tmp_path / "two", ORIGIN, 0.12, carried=tmp_path / "one")
    since_s = BEGIN_S + 801.0
    raster = view_raster(ground.views_since(since_s))
    assert 0 < np.count_nonzero(raster.views) < np.count_nonzero(view_raster(ground.views).views)
    for other in (again, copied):
        assert other.latest_s == ground.latest_s == BEGIN_S + 1600.0
        assert np.array_equal(view_raster(other.views_since(since_s)).views, raster.views)


def test_maps_without_times_count_unless_views_are_forgotten(tmp_path: Path) -> None:
    former = begun(tmp_path)
    add(former, 0.0, 0.0)
    former.flush()
    without_times(tmp_path)
    ground = begun(tmp_path)
    assert ground.latest_s == 0
    assert views_at(ground, 3.3, 0.2) == 1
    assert views_at(ground, 3.3, 0.2, BEGIN_S - 1e6) == 0, "nobody knows how old they are"
    add(ground, 12.0, 1.0, None)
    assert views_at(ground, 3.3, 0.2) == 2
    again = begun(tmp_path)
    add(again, 12.0, 1.0)
    assert views_at(again, 3.3, 0.2, BEGIN_S) == 1


def test_a_tile_without_its_views_stays_damaged(tmp_path: Path) -> None:
    ground = begun(tmp_path)
    add(ground, 0.0, 0.0)
    ground.flush()
    path = tile_path(tmp_path, (-1, 0))
    with zipfile.ZipFile(path) as archive:
        times = archive.read("latest_s.npy")
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("latest_s.npy", times)
    with pytest.raises(InputDataError, match="not a tile"):
        read_tile(path, 1)


@given(
    st.lists(st.tuples(st.integers(0, 15), st.integers(0, 7)), min_size=1, max_size=30),
    st.one_of(st.none(), st.integers(1, 20)),
)
def test_a_cell_counts_the_directions_since_its_last_gap(looks: list[tuple[int, int]], forget_s: int | None) -> None:
    tile, now_s, latest_s, known = Tile.empty(1), 1000, None, set[int]()
    for pause_s, square in looks:
        now_s += pause_s
        if forget_s is not None and latest_s is not None and now_s - latest_s > forget_s:
            known.clear()
        known.add(square)
        latest_s = now_s
        tile.mark_seen(
            ONE_CELL,
            np.array([[square]], dtype=np.int32),
            np.ones((1, 1), dtype=np.bool_),
            utc_s=now_s + 0.7,
            since_s=None if forget_s is None else now_s - forget_s,
        )
        assert tile.views[0, 0] == len(known) == int(tile.seen[0, 0, 0]).bit_count()
        assert tile.latest_s[0, 0] == now_s
    assert np.count_nonzero(tile.views) == np.count_nonzero(tile.latest_s) == 1


def test_reports_segments_and_pictures_forget_alike(tmp_path: Path) -> None:
    source = GroundSource(tmp_path, ORIGIN, 0.12, None)
    prior = AreaPrior(-10.0, 10.0, 10.0, np.full((2, 2), 0.25))
    area = SearchedArea(AREA, 0.85, prior, (Segment("A", AREA),))
    opened_map.cache_clear()
    frames = [(ground_frame(0.0, 0.7), GROUND, BEGIN_S)]
    add_frames(source, frames, area, pictures=False, flush=False, since_s=BEGIN_S - FORGET_S)
    young, old = (
        add_frames(source, (), area, pictures=True, flush=False, since_s=since_s)
        for since_s in (BEGIN_S, BEGIN_S + 1.0)
    )
    opened_map.cache_clear()
    assert young.figures.seen_fraction == young.figures.segments[0].seen_fraction == 1.0
    assert old.figures.seen_fraction == old.figures.mean_views == old.figures.segments[0].seen_fraction == 0.0
    assert young.figures.success is not None
    assert young.figures.success > 0.0 == old.figures.success == old.figures.segments[0].detection
    assert old.figures.detection is not None
    assert old.figures.detection.lying == 0.0
    assert [one.kind for one in old.pictures] == ["views", "detection"]
    assert all(one.png != other.png for one, other in zip(young.pictures, old.pictures, strict=True))
    assert old.floor == young.floor, "the ground looks as it did"


def test_gaps_and_the_order_of_legs_follow_what_still_counts(tmp_path: Path) -> None:
    square = ((-60.0, -60.0), (60.0, -60.0), (60.0, 60.0), (-60.0, 60.0))
    plan = MissionPlan(vehicles=3, area_enu_m=square, forest=ForestSettings(canopy_height_m=18.0, crown_base_m=5.0))
    source, area = GroundSource(tmp_path, ORIGIN, 0.12, None), SearchedArea(square, 0.85)
    opened_map.cache_clear()
    frames = [
        (ground_frame(east_m, north_m), GROUND, BEGIN_S)
        for east_m in np.arange(-60.0, 0.0, 5.0)
        for north_m in np.arange(-60.0, 61.0, 10.0)
    ]
    add_frames(source, frames, area, pictures=False, flush=False)
    for since_s, is_known in ((BEGIN_S, True), (BEGIN_S + 1.0, False)):
        gaps = legs_for_gaps(source, area, plan, 0.0, from_m=(0.0, 0.0), within_s=60.0, pod=0.99, since_s=since_s)
        assert gaps is not None
        assert (gaps.detection_before > 0.1) == is_known
    legs = [ScanLeg((east_m, -60.0), (0.0, 1.0), 120.0) for east_m in (-40.0, 0.0, 40.0)]
    fresh = order_legs(legs, plan, chances_of(plan, 0.0, None), (-60.0, -60.0))
    known, forgotten = (
        ordered_on_map(source, area, plan, 0.0, legs=legs, from_m=(-60.0, -60.0), since_s=since_s)
        for since_s in (BEGIN_S, BEGIN_S + 1.0)
    )
    opened_map.cache_clear()
    assert forgotten == fresh
    assert known != fresh
