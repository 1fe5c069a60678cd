"""Levels of anomaly of an image: whatever its gain, offset and bands."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geometry.projection import Plane
from aos_gcs.imaging.model import Detector, FocalGrid, Frame
from aos_gcs.imaging.views import grid_view
from aos_gcs.surveys.levels import MOST_LEVELS, add_levels, base_score, levels
from aos_gcs.surveys.significance import AnomalySums

SIZE = 240
CAMERA = CameraModel.from_fov(SIZE, SIZE, math.radians(50.0))
POSE = nadir_pose(np.array([0.0, 0.0, 15.0]))


def frame_of(image: NDArray[np.generic], bands: tuple[str, ...] = ("grey",)) -> Frame:
    pixels = image if image.ndim == 3 else image[:, :, np.newaxis]
    return Frame(1, np.asarray(pixels), bands, POSE, CAMERA)


def scene(seed: int = 0) -> NDArray[np.float64]:
    """Rough ground with one warm spot in the middle."""
    rng = np.random.default_rng(seed)
    image = rng.normal(80.0, 2.0, (SIZE, SIZE))
    image[118:122, 118:122] += 40.0
    return image


def levels_of(image: NDArray[np.generic], bands: tuple[str, ...] = ("grey",), **options: float) -> NDArray[np.float32]:
    found = levels(frame_of(image, bands), Detector.LOCAL_RX, Plane(0.0), **options)
    assert found is not None
    return np.asarray(found.image[:, :, 0])


def test_gain_and_offset_change_nothing() -> None:
    bytes_of_one = scene().astype(np.uint8)
    expected = levels_of(bytes_of_one)
    assert expected.max() >= 5
    brighter = (bytes_of_one * 1.5 + 20.0).round()
    assert brighter.max() < 255.0
    np.testing.assert_array_equal(levels_of(bytes_of_one.astype(np.float32) * 0.05 - 10.0), expected)
    np.testing.assert_array_equal(levels_of(bytes_of_one.astype(np.uint16) * 100), expected)
    assert np.mean(levels_of(brighter.astype(np.uint8)) != expected) < 0.01


def test_colder_counts_as_warmer_and_one_of_several_bands_is_enough() -> None:
    image = scene()
    np.testing.assert_array_equal(levels_of(160.0 - image), levels_of(image))
    rng = np.random.default_rng(1)
    colour = np.dstack((rng.normal(100.0, 5.0, (SIZE, SIZE, 3)), image))
    found = levels_of(colour, ("red", "green", "blue", "thermal"))
    assert found[119, 119] >= 5
    assert not found[60:80, 60:80].any()


def test_noise_alone_marks_almost_nothing() -> None:
    rng = np.random.default_rng(2)
    frames = [frame_of(rng.normal(20.0, 0.1, (SIZE, SIZE)).astype(np.float32)) for _ in range(10)]
    found = [levels(frame, Detector.LOCAL_RX, Plane(0.0)) for frame in frames]
    # Five deviations: one pixel of two million, and more in the corners, where surroundings are few.
    assert sum(one is not None for one in found) <= 2
    assert base_score(1) == pytest.approx(25.0)
    assert base_score(4) > base_score(3) > base_score(1)


def test_a_picture_of_few_levels_marks_persons_and_no_rounding() -> None:
    image = np.random.default_rng(2).normal(88.0, 3.4, (SIZE, SIZE))
    image[118:122, 118:122] += 64.0
    found = levels_of((image // 16.0 * 16.0).astype(np.uint8))
    assert found[119, 119] >= 3
    assert np.count_nonzero(found) < 200


def test_levels_are_doublings_of_the_score_and_reach_a_body_s_half_width() -> None:
    image = scene()
    low = levels_of(image)
    assert levels_of(image, min_score=2.0 * base_score(1))[119, 119] == low[119, 119] - 2
    assert levels_of(image, min_score=1e-3).max() == MOST_LEVELS
    pixel_m = 15.0 / CAMERA.fx_px
    marked_m = np.ptp(np.nonzero(low[100:140, 119])[0]) * pixel_m
    assert 0.5 < marked_m - 4 * pixel_m < 0.75


def test_levels_are_summed_where_the_ground_is() -> None:
    grid = FocalGrid(west_m=-5.0, north_m=5.0, resolution_m=0.1, rows=100, columns=100, height_m=0.0)
    sums = AnomalySums.none((100, 100))
    found = levels(frame_of(scene()), Detector.LOCAL_RX, Plane(0.0))
    assert found is not None
    for _ in range(3):
        add_levels(sums, found, grid_view(grid))
    assert sums.count[50, 50] == 3
    assert sums.excess[50, 50] == 3 * (found.image.max() - 1)
    assert not sums.count[:40].any()


def test_the_thermal_detector_marks_what_is_warmer_than_its_own_surroundings() -> None:
    # A restless forest fills most of the frame; on the calm meadow beside it, a fifth of its spread is plain to see.
    rng = np.random.default_rng(4)
    image = rng.normal(80.0, 10.0, (SIZE, SIZE))
    image[:, : SIZE // 3] = rng.normal(80.0, 0.5, (SIZE, SIZE // 3))
    image[98:102, 28:32] += 8.0
    image[158:162, 28:32] -= 8.0
    found = levels(frame_of(image), Detector.THERMAL, Plane(0.0))
    assert found is not None
    marked = found.image[:, :65, 0] > 0
    assert marked[100, 30]
    assert not marked[150:170].any()


def test_gaps_of_a_thermal_band_mark_nothing() -> None:
    image = scene().astype(np.float32)
    image[:60] = np.nan
    found = levels(frame_of(image, ("thermal",)), Detector.THERMAL, Plane(0.0))
    assert found is not None
    assert found.image[119, 119, 0] >= 5
    assert not found.image[:50].any()
    assert levels(frame_of(np.full((SIZE, SIZE), np.nan), ("thermal",)), Detector.THERMAL, Plane(0.0)) is None
