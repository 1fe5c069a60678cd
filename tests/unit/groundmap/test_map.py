"""The map of searched ground: tiles, sums, views, and its folder."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from aos_gcs.errors import ImagingError, InputDataError, RecordingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import Plane
from aos_gcs.groundmap import ground_map
from aos_gcs.groundmap.figures import view_raster
from aos_gcs.groundmap.ground_map import GroundMap, open_map
from aos_gcs.imaging.surfaces.terrain import Terrain
from tests.fakes.ground_frames import COLOUR, ORIGIN, R_NADIR, ground_frame

GROUND = Plane(0.0)


def begun(folder: Path, step: float = 0.12) -> GroundMap:
    return open_map(folder, ORIGIN, step)


def views_at(ground: GroundMap, east_m: float, north_m: float) -> int:
    raster = view_raster(ground.views)
    row, column = int(raster.north_m - north_m), int(east_m - raster.west_m)
    inside = 0 <= row < raster.views.shape[0] and 0 <= column < raster.views.shape[1]
    return int(raster.views[row, column]) if inside else 0


@pytest.mark.parametrize(("east_m", "north_m"), [(0.0, 0.0), (100.5, -63.0), (-17.2, 250.9)])
def test_a_frame_is_seen_where_it_looks_and_nowhere_else(tmp_path: Path, east_m: float, north_m: float) -> None:
    ground = begun(tmp_path)
    ground.add(ground_frame(east_m, north_m), GROUND)
    half_m = 40.0 * np.tan(np.radians(25.0))
    for across_m in (-half_m + 1.5, 0.0, half_m - 1.5):
        assert views_at(ground, east_m + across_m, north_m) == 1
        assert views_at(ground, east_m, north_m + across_m) == 1
    for across_m in (-half_m - 1.5, half_m + 1.5):
        assert views_at(ground, east_m + across_m, north_m) == 0
        assert views_at(ground, east_m, north_m + across_m) == 0
    raster = view_raster(ground.views)
    assert np.count_nonzero(raster.views) == pytest.approx((2.0 * half_m) ** 2, rel=0.05)


def test_equal_directions_count_once_and_others_each(tmp_path: Path) -> None:
    ground = begun(tmp_path)
    for east_m in (0.0, 0.0, 0.1, 12.0, -12.0, 12.1):
        ground.add(ground_frame(east_m, 0.7), GROUND)
    assert ground.header.frames == 6
    # At 3.3 m east, no direction is near the edge of a square.
    assert views_at(ground, 3.3, 0.2) == 3


def test_colours_and_temperatures_are_means_of_the_frames(tmp_path: Path) -> None:
    ground = begun(tmp_path)
    ground.add(ground_frame(16.0, -16.0), GROUND)
    ground.add(ground_frame(16.0, -16.0, bands=("red", "green", "blue")), GROUND)
    ground.add(ground_frame(16.0, -16.0, bands=("grey",)), GROUND)
    tile = ground.tile((0, 0))
    assert tile is not None
    assert tile.colour_count[64, 64] == 3
    assert tile.colour_sum[64, 64].tolist() == [30, 50, 70]
    assert tile.thermal_count[64, 64] == 1
    assert tile.thermal_sum[64, 64] == pytest.approx(COLOUR[3])


def test_terrain_shifts_what_is_seen_and_unknown_ground_is_not_seen(tmp_path: Path) -> None:
    heights_m = np.full((40, 40), 20.0)
    heights_m[:, 20:] = np.nan
    ground = begun(tmp_path)
    ground.add(ground_frame(0.0, 0.0), Terrain(-40.0, -40.0, 2.0, heights_m))
    # From 20 m above the ground, half as much is seen as from 40 m.
    assert views_at(ground, -8.5, 0.5) == 1
    assert views_at(ground, -10.5, 0.5) == 0
    assert views_at(ground, 3.5, 0.5) == 0


def test_a_tilted_plane_is_seen_further_uphill_and_less_downhill(tmp_path: Path) -> None:
    ground = begun(tmp_path)
    ground.add(ground_frame(0.0, 0.0), Plane(0.0, slope_x=0.3))
    east = [east_m for east_m in np.arange(-40.5, 40.5) if views_at(ground, float(east_m), 0.5)]
    # Cuts of the edges of the view, +-25 degrees off the nadir, with the slope.
    tangent = np.tan(np.radians(25.0))
    assert min(east) == pytest.approx(-40.0 * tangent / (1.0 - 0.3 * tangent), abs=1.0)
    assert max(east) == pytest.approx(40.0 * tangent / (1.0 + 0.3 * tangent), abs=1.0)


def test_gaps_in_an_image_are_not_seen(tmp_path: Path) -> None:
    image = ground_frame(0.0, 0.0).image.copy()
    image[:, :32] = np.nan
    ground = begun(tmp_path)
    ground.add(ground_frame(0.0, 0.0, image=image), GROUND)
    assert views_at(ground, -5.5, 0.5) == 0
    assert views_at(ground, 5.5, 0.5) == 1


@pytest.mark.parametrize(
    "changes",
    [
        {"pose": Pose(np.array([0.0, 0.0, -30.0]), R_NADIR)},
        {"pose": Pose(np.array([0.0, 0.0, 30.0]), np.diag([1.0, 1.0, 1.0]))},
        {"image": np.zeros((32, 64, 4), dtype=np.float32)},
    ],
)
def test_a_frame_that_shows_no_ground_is_refused_and_leaves_nothing(tmp_path: Path, changes: dict[str, object]) -> None:
    ground = begun(tmp_path)
    with pytest.raises(ImagingError):
        ground.add(ground_frame(0.0, 0.0, **changes), GROUND)
    assert ground.header.frames == 0
    assert not ground.views


def test_a_camera_that_looks_at_the_horizon_costs_no_more_than_one_that_looks_down(tmp_path: Path) -> None:
    sin, cos = np.sin(np.radians(60.0)), np.cos(np.radians(60.0))
    oblique = np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]]) @ R_NADIR
    ground = begun(tmp_path)
    ground.add(ground_frame(0.0, 0.0, pose=Pose(np.array([0.0, 0.0, 40.0]), oblique)), GROUND)
    # Nothing counts that is farther than the camera is high.
    raster = view_raster(ground.views)
    rows, columns = np.nonzero(raster.views)
    assert (raster.north_m - rows).max() <= 41.0
    assert len(rows) > 0
    assert abs(columns + raster.west_m).max() <= 41.0


def test_views_flatter_than_45_degrees_do_not_count(tmp_path: Path) -> None:
    camera = CameraModel.from_fov(64, 64, np.radians(110.0))
    ground = begun(tmp_path)
    ground.add(ground_frame(0.0, 0.0, height_m=40.2, camera=camera), GROUND)
    assert views_at(ground, 39.5, 0.5) == 1
    assert views_at(ground, 40.5, 0.5) == 0


def test_the_map_is_read_back_as_it_was_written(tmp_path: Path) -> None:
    ground = begun(tmp_path)
    for east_m in (0.0, 20.0, 40.0):
        ground.add(ground_frame(east_m, 5.0), GROUND)
    ground.flush()
    again = open_map(tmp_path, ORIGIN, 0.5)
    assert again.header == ground.header
    assert again.views.keys() == ground.views.keys()
    for index, views in ground.views.items():
        assert np.array_equal(again.views[index], views)
    # It goes on with its own squares: views that it has seen do not count again.
    again.add(ground_frame(20.0, 5.0), GROUND)
    assert views_at(again, 20.5, 5.5) == views_at(ground, 20.5, 5.5)
    mine, other = ground.tile((-1, 0)), again.tile((-1, 0))
    assert mine is not None
    assert other is not None
    assert other.colour_count.sum() > mine.colour_count.sum()


def test_tiles_leave_the_memory_and_come_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ground_map, "TILES_IN_MEMORY", 4)
    monkeypatch.setattr(ground_map, "FRAMES_IN_USE", 0)
    ground, whole = begun(tmp_path / "a"), begun(tmp_path / "b")
    places = [0.0, 100.0, 200.0, 5.0, 105.0, 205.0]
    for east_m in places:
        ground.add(ground_frame(east_m, 0.0), GROUND)
    monkeypatch.setattr(ground_map, "TILES_IN_MEMORY", 1000)
    for east_m in places:
        whole.add(ground_frame(east_m, 0.0), GROUND)
    assert ground.views.keys() == whole.views.keys()
    for index in whole.views:
        one, other = ground.tile(index), whole.tile(index)
        assert one is not None
        assert other is not None
        assert np.array_equal(one.seen, other.seen)
        assert np.array_equal(one.colour_sum, other.colour_sum)


def test_tiles_that_frames_are_using_stay_until_they_have_gone_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ground_map, "TILES_IN_MEMORY", 4)
    monkeypatch.setattr(ground_map, "FRAMES_IN_USE", 3)
    ground = begun(tmp_path)
    line = [0.0, 100.0, 200.0]
    for east_m in line * 2:
        ground.add(ground_frame(east_m, 0.0), GROUND)
    assert list(tmp_path.glob("*.npz")) == [], "no vehicle of a line fetches tiles that another one has sent away"
    for _ in range(3):
        ground.add(ground_frame(1000.0, 0.0), GROUND)
    ground.add(ground_frame(1100.0, 0.0), GROUND)
    gone = {path.name for path in tmp_path.glob("*.npz")}
    assert len(gone) >= len(line) * 4, "those of before go when room is needed"


def test_the_next_sortie_goes_on_with_a_copy(tmp_path: Path) -> None:
    former = begun(tmp_path / "one")
    former.add(ground_frame(0.0, 0.0), GROUND)
    former.flush()
    following = open_map(tmp_path / "two", ORIGIN, 0.12, carried=tmp_path / "one")
    following.add(ground_frame(12.0, 0.0), GROUND)
    following.flush()
    assert views_at(following, 3.3, 0.2) == 2
    assert open_map(tmp_path / "two", ORIGIN, 0.12).header.frames == 2
    assert open_map(tmp_path / "one", ORIGIN, 0.12).header.frames == 1


def test_a_map_of_another_origin_is_not_carried_on(tmp_path: Path) -> None:
    former = begun(tmp_path / "one")
    former.add(ground_frame(0.0, 0.0), GROUND)
    former.flush()
    elsewhere = GeodeticPosition(47.001, 15.0, 400.0)
    assert not open_map(tmp_path / "two", elsewhere, 0.12, carried=tmp_path / "one").views
    with pytest.raises(InputDataError, match="another origin"):
        open_map(tmp_path / "one", elsewhere, 0.12)


def test_a_damaged_tile_counts_as_not_searched(tmp_path: Path) -> None:
    ground = begun(tmp_path)
    ground.add(ground_frame(0.0, 0.0), GROUND)
    ground.flush()
    path = tmp_path / "tile_0_0.npz"
    path.write_bytes(path.read_bytes()[:200])
    again = open_map(tmp_path, ORIGIN, 0.12)
    assert views_at(again, 5.5, -5.5) == 0
    assert views_at(again, 5.5, 5.5) == 1
    again.add(ground_frame(0.0, 0.0), GROUND)
    assert views_at(again, 5.5, -5.5) == 1


@pytest.mark.parametrize("text", ["", "{}", '{"format": 1, "frames": 1, "direction_step": -1.0, "origin": null}'])
def test_a_damaged_head_is_refused_by_name(tmp_path: Path, text: str) -> None:
    (tmp_path / ground_map.HEADER_NAME).write_text(text, "utf-8")
    with pytest.raises(InputDataError, match=r"ground\.json"):
        begun(tmp_path)


def test_a_disk_that_takes_nothing_is_reported_and_tried_again(tmp_path: Path) -> None:
    blocked = tmp_path / "ground"
    blocked.write_text("in the way", "utf-8")
    ground = begun(blocked)
    ground.add(ground_frame(0.0, 0.0), GROUND)
    with pytest.raises(RecordingError, match="cannot be written"):
        ground.flush()
    blocked.unlink()
    ground.flush()
    assert open_map(blocked, ORIGIN, 0.12).header.frames == 1
