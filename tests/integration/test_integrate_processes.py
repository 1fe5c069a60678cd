"""Maps on several processes: the same to the last bit as in one, and errors as they are."""

import json
import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geometry.projection import Plane
from aos_gcs.imaging import workers
from aos_gcs.imaging.surfaces.ground import choose_raster
from aos_gcs.surveys.integration import Work, integrate_tiles
from aos_gcs.surveys.model import SurveyImage
from aos_gcs.surveys.processes import open_processes
from aos_gcs.surveys.tiles import MapTile, grouped, map_tiles
from tests.fakes.command_line import exit_status

CAMERA = CameraModel.from_fov(60, 60, math.radians(60.0))
COUNT = 8


@pytest.fixture
def work(tmp_path: Path) -> Work:
    rng = np.random.default_rng(0)
    images = []
    for index in range(COUNT):
        path = tmp_path / f"{index}.png"
        cv2.imwrite(str(path), rng.integers(0, 255, (60, 60), dtype=np.uint8))
        images.append(SurveyImage(path, nadir_pose([4.0 * index, 0.0, 15.0], 0.3 * index), CAMERA))
    return Work(tuple(images), ("grey",), Plane(0.0))


def tiles_of(work: Work) -> list[MapTile]:
    raster = choose_raster([(image.camera, image.pose) for image in work.images], work.surface, 0.25)
    return map_tiles(raster, work.images, work.surface, edge_cells=32)


def test_two_processes_give_what_one_gives(work: Work) -> None:
    tiles = tiles_of(work)
    done: list[int] = []
    with open_processes(2) as processes:
        groups = processes.groups(work, tiles)
        results = [one for group in processes.integrate(work, groups, done.append) for one in group]
    alone = integrate_tiles(work, tiles)
    assert len(results) == len(alone)
    own = {(one.window[0].start, one.window[1].start): one for one in results}
    for other in alone:
        one = own[other.window[0].start, other.window[1].start]
        np.testing.assert_array_equal(one.integral, other.integral)
        np.testing.assert_array_equal(one.coverage, other.coverage)
        assert one.used == other.used
    assert sum(done) == sum(len({index for tile in group for index in tile.images}) for group in groups)


def test_an_error_of_a_process_comes_back_as_it_is(work: Work) -> None:
    work.images[3].path.write_bytes(b"text")
    with open_processes(2) as processes, pytest.raises(InputDataError, match=r"3\.png"):
        list(processes.integrate(work, processes.groups(work, tiles_of(work)), lambda _: None))


def test_groups_are_of_about_equal_work(work: Work) -> None:
    tiles = tiles_of(work)
    groups = grouped(tiles, work.cell_bytes, work.max_bytes, least_groups=4)
    shares = [sum(tile.raster.rows * tile.raster.columns * len(tile.images) for tile in group) for group in groups]
    assert len(groups) == 4
    assert max(shares) < 2.0 * min(shares)


def test_a_worker_uses_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.cpu_count", lambda: 8)
    monkeypatch.setattr(workers, "_limits", [workers.MAX_WORKERS])
    assert workers._count() == workers.MAX_WORKERS
    workers.use_one_thread()
    assert workers._count() == 1


def test_the_command_divides_a_map(work: Work, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    entries = [
        {
            "imagefile": image.path.name,
            "M3x4": np.column_stack(
                (image.pose.R_cam2enu.T, -image.pose.R_cam2enu.T @ image.pose.position_enu_m)
            ).tolist(),
        }
        for image in work.images
    ]
    poses = tmp_path / "poses.json"
    poses.write_text(json.dumps({"images": entries}))
    maps = []
    for name, options in (("one.npy", []), ("two.npy", ["--jobs", "2"])):
        arguments = ["integrate", str(tmp_path), "--poses", str(poses), "--fov", "60", "--plane-z", "0", *options]
        assert exit_status([*arguments, "--ortho", "0.25", "--out", str(tmp_path / name)]) == 0, capsys.readouterr().err
        maps.append(np.load(tmp_path / name))
    np.testing.assert_array_equal(*maps)
