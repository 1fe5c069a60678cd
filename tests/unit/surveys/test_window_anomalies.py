"""Anomalies on which frames in memory agree: the rows of ``integrate``, with frames that cannot be used left out."""

import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from aos_gcs.errors import ConfigurationError, ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geometry.projection import Plane, project_points
from aos_gcs.imaging.model import Detector, Frame
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.surveys import window_anomalies
from aos_gcs.surveys.anomalies import significant_blobs
from aos_gcs.surveys.integration import Work, integrate_tiles
from aos_gcs.surveys.model import SurveyImage
from aos_gcs.surveys.significance import AnomalySums, significance
from aos_gcs.surveys.tiles import map_tiles
from aos_gcs.surveys.window_anomalies import Detection, find_anomalies, window_raster

SIZE, CELL_M = 240, 0.1
CAMERA = CameraModel.from_fov(SIZE, SIZE, math.radians(50.0))
GROUND = Plane(0.0)
TERRAIN = Terrain(-50.0, -50.0, 5.0, np.random.default_rng(3).uniform(-0.1, 0.1, (21, 21)))
BODIES_M = [(-2.0, 1.0), (3.0, -1.5)]


def flight(frames: int = 8, bodies_m: list[tuple[float, float]] = BODIES_M) -> list[Frame]:
    """A drone that flies east 15 m above rough ground; leaves shine at another place in each frame."""
    taken = []
    for index in range(frames):
        pose = nadir_pose([0.4 * index - 1.6, 0.0, 15.0], 0.3 * index)
        rng = np.random.default_rng(index)
        image = rng.normal(80.0, 3.0, (SIZE, SIZE, 1))
        for place_m in bodies_m:
            u, v = np.rint(project_points(np.array([[*place_m, 0.0]]), CAMERA, pose)[0]).astype(int)
            image[v - 2 : v + 3, u - 2 : u + 3] += 60.0
        for u, v in rng.integers(6, SIZE - 6, (6, 2)):
            image[v : v + 4, u : u + 4] += 60.0
        taken.append(Frame(index + 1, np.clip(image, 0, 255).astype(np.uint8), ("grey",), pose, CAMERA))
    return taken


@pytest.mark.parametrize("surface", [GROUND, TERRAIN], ids=["plane", "terrain"])
def test_a_window_has_the_rows_of_a_map(tmp_path: Path, surface: FocalSurface) -> None:
    frames = flight()
    found = find_anomalies(frames, surface, Detection(), CELL_M)
    images = []
    for frame in frames:
        path = tmp_path / f"{frame.vehicle_id}.png"
        cv2.imwrite(str(path), frame.image)
        images.append(SurveyImage(path, frame.pose, CAMERA))
    raster = window_raster(images, surface, CELL_M)
    sums = AnomalySums.none((raster.rows, raster.columns))
    coverage = np.zeros_like(sums.count)
    work = Work(tuple(images), ("grey",), surface, exact=False, detector=Detector.LOCAL_RX)
    for tile in integrate_tiles(work, map_tiles(raster, images, surface)):
        assert tile.anomalies is not None
        coverage[tile.window] = tile.coverage
        sums.count[tile.window], sums.excess[tile.window] = tile.anomalies.count, tile.anomalies.excess
    rows = significant_blobs(sums, significance(sums, coverage, CELL_M), coverage, raster, surface)
    assert list(found.blobs) == rows
    assert sorted(row.position_m[0] for row in rows) == pytest.approx([-2.0, 3.0], abs=0.2)
    assert found.searched_m2 == pytest.approx(np.count_nonzero(coverage >= 2) * CELL_M**2)


def test_a_smaller_rate_of_false_alarms_leaves_out_what_is_less_sure() -> None:
    frames = flight()
    clear = find_anomalies(frames, GROUND, Detection(), CELL_M).blobs
    assert len(clear) == 2
    weakest = min(row.significance or 0.0 for row in clear)
    rate = 20_000.0 / 10 ** (weakest + 0.1)
    assert len(find_anomalies(frames, GROUND, Detection(false_alarms_per_ha=rate), CELL_M).blobs) < 2


def test_frames_that_show_nothing_are_left_out_and_gaps_see_no_ground() -> None:
    frames = flight(4)
    whole = find_anomalies(frames, GROUND, Detection(), CELL_M)
    flat = replace(frames[0], vehicle_id=9, image=np.full((SIZE, SIZE, 1), 7, dtype=np.uint8))
    with_flat = find_anomalies([*frames, flat], GROUND, Detection(), CELL_M)
    assert dict(with_flat.left_out) == {9: "its image is the same everywhere (7)"}
    assert with_flat.blobs == whole.blobs
    with pytest.raises(ImagingError, match="No frame can be examined: its image is the same everywhere"):
        find_anomalies([flat], GROUND, Detection(), CELL_M)
    colour = [replace(frame, image=frame.image.repeat(3, 2), bands=("red", "green", "blue")) for frame in frames]
    with pytest.raises(ImagingError, match="No frame can be examined: The thermal detector needs a thermal band"):
        find_anomalies(colour, GROUND, Detection(Detector.THERMAL), CELL_M)

    def half(frame: Frame) -> Frame:
        image = frame.image.astype(np.float32)
        image[: SIZE // 2] = np.nan
        return replace(frame, image=image)

    half_seen = find_anomalies([half(frame) for frame in frames], GROUND, Detection(), CELL_M)
    assert half_seen.searched_m2 < 0.75 * whole.searched_m2


def test_large_windows_have_coarser_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(window_anomalies, "MAX_CELLS", 2_000)
    raster = window_raster(flight(4), GROUND, CELL_M)
    assert 1_000 < raster.rows * raster.columns <= 2_000
    assert raster.resolution_m > 2 * CELL_M


def test_limits_that_cannot_be_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="--false-alarms-per-ha must lie between 0 and 20000"):
        Detection(false_alarms_per_ha=0.0)
    with pytest.raises(ConfigurationError, match="--min-score must not be negative"):
        Detection(min_score=-1.0)


def test_two_persons_of_even_warmth_do_not_hide_each_other() -> None:
    frames = []
    for index in range(4):
        pose = nadir_pose([0.0, 0.8 * index - 1.2, 15.0])
        image = np.random.default_rng(index).normal(80.0, 3.0, (SIZE, SIZE, 1))
        for east_m in (0.0, 1.6):
            corners = np.array([[east_m - 0.2, -0.85, 0.0], [east_m + 0.2, 0.85, 0.0]])
            (left, bottom), (right, top) = np.rint(project_points(corners, CAMERA, pose)).astype(int)
            image[top:bottom, left:right] += 60.0
        frames.append(Frame(index + 1, np.clip(image, 0, 255).astype(np.uint8), ("grey",), pose, CAMERA))
    assert len(find_anomalies(frames, GROUND, Detection(), CELL_M).blobs) == 1
