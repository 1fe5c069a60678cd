"""Tiles of a survey: what they leave out, what they have in common, and that nothing depends on how many are held."""

import errno
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError, ImagingError, InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geometry.projection import Plane
from aos_gcs.imaging.integral import integrate
from aos_gcs.imaging.model import Detector, MapRaster
from aos_gcs.imaging.surfaces.ground import choose_raster
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.views import FocalSurface, ortho_view
from aos_gcs.surveys.anomalies import significant_blobs
from aos_gcs.surveys.images import LazyFrames, read_image
from aos_gcs.surveys.integration import Work, integrate_tiles
from aos_gcs.surveys.model import SurveyImage
from aos_gcs.surveys.rasters import SurveyRasters, assemble
from aos_gcs.surveys.significance import AnomalySums, significance
from aos_gcs.surveys.tiles import MapTile, grouped, map_tiles

CAMERA = CameraModel.from_fov(120, 90, math.radians(60.0))
PLANE = Plane(0.0, 0.02, -0.03)
TERRAIN = Terrain(-50.0, -50.0, 5.0, np.random.default_rng(3).uniform(-0.1, 0.6, (30, 40)))


@pytest.fixture
def images(tmp_path: Path) -> list[SurveyImage]:
    """Twelve noisy frames in two strips, the last looking up; a hot spot in the middle of a cell, at 20.125, 5.125."""
    rng = np.random.default_rng(0)
    images = []
    for index in range(12):
        position = np.array([6.0 * (index % 6), 10.0 * (index // 6), 15.0])
        pose = nadir_pose(position, heading_rad=0.4 * index)
        pixels = rng.normal(100.0, 3.0, (90, 120))
        for u, v in hot_pixels(position, pose.R_cam2enu):
            pixels[v, u] = 250.0
        if index == 11:
            pose = type(pose)(position, pose.R_cam2enu @ np.diag([1.0, -1.0, -1.0]))
        path = tmp_path / f"{index:02}.png"
        cv2.imwrite(str(path), np.clip(pixels, 0, 255).astype(np.uint8))
        images.append(SurveyImage(path, pose, CAMERA))
    return images


def hot_pixels(position: NDArray[np.float64], R_cam2enu: NDArray[np.float64]) -> list[tuple[int, int]]:
    x, y, z = R_cam2enu.T @ (np.array([20.125, 5.125, 0.25]) - position)
    u, v = (round(float(value)) for value in CAMERA.to_pixels([x / z, y / z]))
    return [(u, v)] if 0 <= u < 120 and 0 <= v < 90 else []


def raster_of(images: Sequence[SurveyImage], surface: FocalSurface) -> MapRaster:
    return choose_raster([(image.camera, image.pose) for image in images], surface, 0.25)


def whole(work: Work, tiles: list[MapTile], raster: MapRaster, max_bytes: int, folder: Path) -> SurveyRasters:
    groups = grouped(tiles, work.cell_bytes, max_bytes)
    return assemble(work, (raster.rows, raster.columns), (integrate_tiles(work, group) for group in groups), folder)


def work_on(images: Sequence[SurveyImage], surface: FocalSurface, **options: Any) -> Work:
    return Work(tuple(images), ("grey",), surface, **options)


@pytest.mark.parametrize("surface", [PLANE, TERRAIN], ids=["plane", "terrain"])
@pytest.mark.parametrize("trim", [None, 0.5])
def test_the_whole_does_not_depend_on_the_tiles_held(
    images: list[SurveyImage], surface: FocalSurface, trim: float | None, tmp_path: Path
) -> None:
    raster = raster_of(images, surface)
    tiles = map_tiles(raster, images, surface, edge_cells=48)
    assert len(tiles) > 4
    work = work_on(images, surface, trim=trim, detector=Detector.RX)
    once, singly = (whole(work, tiles, raster, max_bytes, tmp_path) for max_bytes in (10**9, 1))
    np.testing.assert_array_equal(once.integral, singly.integral)
    np.testing.assert_array_equal(once.coverage, singly.coverage)
    assert once.anomalies is not None
    assert singly.anomalies is not None
    np.testing.assert_array_equal(once.anomalies.count, singly.anomalies.count)
    np.testing.assert_array_equal(once.anomalies.excess, singly.anomalies.excess)
    assert once.used == singly.used == frozenset(range(11))


@pytest.mark.parametrize("surface", [PLANE, TERRAIN], ids=["plane", "terrain"])
def test_tiles_together_are_the_integral(images: list[SurveyImage], surface: FocalSurface, tmp_path: Path) -> None:
    raster = raster_of(images, surface)
    tiles = map_tiles(raster, images, surface, edge_cells=48)
    tiled = whole(work_on(images, surface), tiles, raster, 10**9, tmp_path)
    integral, coverage = integrate(LazyFrames(images, ("grey",)), ortho_view(raster, surface))
    # Tiles have homographies of their own: cells at the very edge of a frame may fall to the other side.
    same = tiled.coverage == coverage
    assert np.count_nonzero(~same) <= 3
    np.testing.assert_allclose(tiled.integral[same], integral[same], atol=1e-4)


def test_tiles_know_the_images_that_see_them(images: list[SurveyImage]) -> None:
    raster = raster_of(images, PLANE)
    for tile in map_tiles(raster, images, PLANE, edge_cells=32):
        results = integrate_tiles(work_on(images, PLANE), [MapTile(tile.window, tuple(range(12)), tile.raster)])
        assert results[0].used <= set(tile.images)
        assert len(tile.images) < 11


def test_large_rasters_live_in_files_that_vanish(images: list[SurveyImage], tmp_path: Path) -> None:
    raster = raster_of(images, PLANE)
    tiles = map_tiles(raster, images, PLANE)
    work = work_on(images, PLANE, max_bytes=1)
    folder = tmp_path / "results"
    folder.mkdir()
    rasters = whole(work, tiles, raster, 10**9, folder)
    assert isinstance(rasters.integral, np.memmap)
    assert not list(folder.iterdir())
    assert np.isfinite(rasters.integral[rasters.coverage > 0]).all()
    assert np.isnan(rasters.integral[rasters.coverage == 0]).all()


def test_a_full_disk_is_told_before_it_is_written_to(
    images: list[SurveyImage], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "posix_fallocate", fail)
    raster = raster_of(images, PLANE)
    work = work_on(images, PLANE, max_bytes=1)
    with pytest.raises(ConfigurationError, match="while the map is made: No space left on device"):
        whole(work, map_tiles(raster, images, PLANE), raster, 10**9, tmp_path)


def test_groups_fit_into_memory(images: list[SurveyImage]) -> None:
    tiles = map_tiles(raster_of(images, PLANE), images, PLANE, edge_cells=16)
    groups = grouped(tiles, cell_bytes=10, max_bytes=16 * 16 * 10 * 3)
    assert [tile for group in groups for tile in group] == tiles
    assert max(len(group) for group in groups) >= 3
    for group in groups:
        cells = sum(tile.raster.rows * tile.raster.columns for tile in group)
        assert cells <= 16 * 16 * 3
    assert len(grouped(tiles, 10, 1)) == len(tiles)
    assert len(grouped(tiles, 10, 10**9, least_groups=7)) >= 7


@pytest.mark.parametrize("trim", [None, 0.5])
def test_broken_images_stop_or_are_left_out(images: list[SurveyImage], trim: float | None, tmp_path: Path) -> None:
    images[4].path.write_bytes(images[4].path.read_bytes()[:-100])
    tiles = map_tiles(raster_of(images, PLANE), images, PLANE)
    with pytest.raises(InputDataError, match=r"04\.png is incomplete"):
        integrate_tiles(work_on(images, PLANE, trim=trim), tiles)
    rasters = whole(
        work_on(images, PLANE, trim=trim, skip_broken=True), tiles, raster_of(images, PLANE), 10**9, tmp_path
    )
    assert list(rasters.broken) == [4]
    assert rasters.used == frozenset(range(11)) - {4}


@pytest.mark.parametrize("surface", [PLANE, TERRAIN], ids=["plane", "terrain"])
def test_the_hot_spot_is_found_where_it_is(images: list[SurveyImage], surface: FocalSurface, tmp_path: Path) -> None:
    raster = raster_of(images, surface)
    rasters = whole(
        work_on(images, surface, detector=Detector.RX), map_tiles(raster, images, surface), raster, 10**9, tmp_path
    )
    assert rasters.anomalies is not None
    seeing = sum(bool(hot_pixels(image.pose.position_enu_m, image.pose.R_cam2enu)) for image in images[:11])
    found = significance(rasters.anomalies, rasters.coverage, raster.resolution_m)
    blobs = significant_blobs(rasters.anomalies, found, rasters.coverage, raster, surface)
    assert blobs[0].position_m[:2] == pytest.approx((20.125, 5.125), abs=0.2)
    assert blobs[0].position_m[2] == pytest.approx(float(surface.z_m(20.0, 5.0)), abs=0.3)
    assert blobs[0].max_count >= seeing - 2
    assert 0.05 < blobs[0].area_m2 < 1.0


def test_rows_are_told_apart_by_more_than_a_person_s_length() -> None:
    sums = AnomalySums.none((20, 30))
    sums.count[2:5, 3:6] = 4
    sums.count[2:5, 7:8] = 2
    sums.count[10, 20] = 9
    significances = np.where(sums.count == 9, 8.0, np.where(sums.count > 0, 6.0, 0.0)).astype(np.float32)
    significances[15, 2] = 4.0
    coverage = np.full((20, 30), 10, dtype=np.uint16)
    raster = MapRaster(100.0, 50.0, 0.5, 20, 30, rows_along_y=False)
    sure, large = significant_blobs(sums, significances, coverage, raster, Plane(7.0))
    assert large.area_m2 == pytest.approx(12 * 0.25)
    assert (large.max_count, large.significance) == (4, 6.0)
    assert large.agreement == pytest.approx((9 * 4 + 3 * 2) / 120)
    assert sure.position_m == pytest.approx((100.0 + 20.5 * 0.5, 50.0 - 10.5 * 0.5, 7.0))
    assert len(significant_blobs(sums, significances, coverage, raster, Plane(7.0), false_alarms_per_ha=5.0)) == 3
    assert significant_blobs(sums, significances, coverage, raster, Plane(7.0), false_alarms_per_ha=1e-5) == []


def test_a_map_full_of_anomalies_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("aos_gcs.surveys.anomalies.MAX_MARKED_CELLS", 10)
    counts = np.ones((5, 5), dtype=np.uint16)
    raster = MapRaster(0.0, 0.0, 1.0, 5, 5, rows_along_y=False)
    with pytest.raises(ImagingError, match="25 cells stand out as anomalies, more than 10"):
        significant_blobs(AnomalySums.none((5, 5)), np.full((5, 5), 9.0, np.float32), counts, raster, Plane(0.0))


def test_images_are_read_one_at_a_time(images: list[SurveyImage], monkeypatch: pytest.MonkeyPatch) -> None:
    alive = 0

    class Pixels(np.ndarray[Any, Any]):
        def __del__(self) -> None:
            nonlocal alive
            alive -= 1

    most = 0

    def counting(path: Path) -> NDArray[Any]:
        nonlocal alive, most
        pixels = read_image(path).view(Pixels)
        alive += 1
        most = max(most, alive)
        return pixels

    monkeypatch.setattr("aos_gcs.surveys.images.read_image", counting)
    for _ in LazyFrames(images, ("grey",)):
        pass
    assert most <= 2
