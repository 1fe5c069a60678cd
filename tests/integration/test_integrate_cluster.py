"""Surveys on a cluster: the same to the last bit as in one process."""

import math
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np
import pytest

from aos_gcs import extras
from aos_gcs.cluster import load_distributed, local_cluster, remote_cluster
from aos_gcs.errors import ConfigurationError, InputDataError, LinkError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geometry.projection import Plane
from aos_gcs.imaging.model import Detector
from aos_gcs.imaging.surfaces.ground import choose_raster
from aos_gcs.surveys.cluster import integrate_on_cluster
from aos_gcs.surveys.integration import Work, integrate_tiles
from aos_gcs.surveys.model import SurveyImage
from aos_gcs.surveys.rasters import SurveyRasters, assemble
from aos_gcs.surveys.tiles import MapTile, map_tiles

pytestmark = pytest.mark.skipif(find_spec("distributed") is None, reason="dask (the extra 'lab') is not installed")

CAMERA = CameraModel.from_fov(60, 60, math.radians(60.0))


@pytest.fixture
def work(tmp_path: Path) -> Work:
    rng = np.random.default_rng(0)
    images = []
    for index in range(8):
        path = tmp_path / f"{index}.png"
        cv2.imwrite(str(path), rng.integers(0, 255, (60, 60, 3), dtype=np.uint8))
        images.append(SurveyImage(path, nadir_pose([4.0 * index, 0.0, 15.0], 0.3 * index), CAMERA))
    return Work(tuple(images), ("red", "green", "blue"), Plane(0.0), detector=Detector.RX)


@pytest.fixture
def tiles(work: Work) -> list[MapTile]:
    raster = choose_raster([(image.camera, image.pose) for image in work.images], work.surface, 0.25)
    return map_tiles(raster, work.images, work.surface, edge_cells=32)


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """A cluster of threads in this process."""
    with load_distributed().LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0", protocol="inproc"
    ) as cluster:
        yield cluster.scheduler_address


def shape(tiles: list[MapTile]) -> tuple[int, int]:
    return max(tile.window[0].stop for tile in tiles), max(tile.window[1].stop for tile in tiles)


def assert_same(one: SurveyRasters, other: SurveyRasters) -> None:
    np.testing.assert_array_equal(one.integral, other.integral)
    np.testing.assert_array_equal(one.coverage, other.coverage)
    assert one.anomalies is not None
    assert other.anomalies is not None
    np.testing.assert_array_equal(one.anomalies.count, other.anomalies.count)
    np.testing.assert_array_equal(one.anomalies.excess, other.anomalies.excess)
    assert one.used == other.used


def test_a_cluster_gives_what_one_process_gives(work: Work, tiles: list[MapTile], address: str, tmp_path: Path) -> None:
    alone = assemble(work, shape(tiles), [integrate_tiles(work, tiles)], tmp_path)
    done: list[int] = []
    with remote_cluster(address) as client:
        shared = assemble(work, shape(tiles), integrate_on_cluster(client, work, tiles, done.append), tmp_path)
    assert len(done) > 1
    assert sum(done) == len(tiles)
    assert_same(alone, shared)
    assert len(alone.used) == 8


def test_an_error_of_a_worker_comes_back_as_it_is(work: Work, tiles: list[MapTile], address: str) -> None:
    work.images[3].path.write_bytes(b"text")
    with remote_cluster(address) as client, pytest.raises(InputDataError, match=r"3\.png is not an image"):
        list(integrate_on_cluster(client, work, tiles, lambda _: None))


def test_a_scheduler_without_workers_is_named() -> None:
    with (
        load_distributed().LocalCluster(
            n_workers=0, processes=False, dashboard_address="127.0.0.1:0", protocol="inproc"
        ) as idle,
        pytest.raises(LinkError, match="has no workers: start 'dask worker"),
        remote_cluster(idle.scheduler_address),
    ):
        pass


def lose_connection(*_: object) -> None:
    raise load_distributed().comm.CommClosedError("the wire is cut")


def test_a_cluster_that_is_lost_is_named(
    work: Work, tiles: list[MapTile], address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("aos_gcs.surveys.cluster.integrate_tiles", lose_connection)
    with (
        remote_cluster(address) as client,
        pytest.raises(LinkError, match=r"The cluster was lost while it integrated \(the wire is cut\)"),
    ):
        list(integrate_on_cluster(client, work, tiles, lambda _: None))


@pytest.mark.slow
def test_processes_give_what_one_process_gives(work: Work, tiles: list[MapTile], tmp_path: Path) -> None:
    alone = assemble(work, shape(tiles), [integrate_tiles(work, tiles)], tmp_path)
    with local_cluster(2) as client:
        shared = assemble(work, shape(tiles), integrate_on_cluster(client, work, tiles, lambda _: None), tmp_path)
    assert_same(alone, shared)


def test_a_missing_library_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr(extras.importlib, "import_module", absent)
    for cluster in (local_cluster(2), remote_cluster("tcp://host:8786")):
        with pytest.raises(ConfigurationError, match=r"needs distributed.*pip install 'aos-gcs\[lab\]'"), cluster:
            pass
