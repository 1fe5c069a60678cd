"""Memory that is used again."""

from __future__ import annotations

import numpy as np
import pytest

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging import scratch
from aos_gcs.imaging.detection.rx import rx_scores
from aos_gcs.imaging.focal_plane import choose_grid
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.step.integration import integrate


@pytest.fixture(autouse=True)
def _nothing_kept() -> None:
    scratch._spare.clear()


def test_memory_comes_back_for_arrays_of_its_size_alone() -> None:
    first = scratch.borrow(3, 4)
    scratch.give_back(first)
    assert np.shares_memory(scratch.borrow(2, 6), first)
    scratch.give_back(first)
    assert scratch.borrow(5, 4).shape == (5, 4)
    other = scratch.borrow(7)
    scratch.give_back(other)
    assert np.shares_memory(scratch.borrow(4, 3), first)
    assert np.shares_memory(scratch.borrow(7), other)
    assert not scratch._spare


def test_sizes_that_nobody_asks_for_make_room() -> None:
    for size in (5, 6):
        scratch.give_back(np.empty(size, dtype=np.float32))
    scratch.give_back(scratch.borrow(6))
    for _ in range(scratch.MAX_KEPT_ARRAYS - 1):
        scratch.give_back(np.empty(7, dtype=np.float32))
    assert sorted({memory.size for memory in scratch._spare}) == [6, 7]


def test_large_arrays_are_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scratch, "MAX_KEPT_BYTES", 40)
    scratch.give_back(scratch.borrow(11))
    assert not scratch._spare
    for _ in range(20):
        scratch.give_back(np.empty(10, dtype=np.float32))
    assert len(scratch._spare) == scratch.MAX_KEPT_ARRAYS


def test_results_do_not_lie_in_memory_that_others_get() -> None:
    rng = np.random.default_rng(0)
    camera = CameraModel.from_fov(40, 30, 0.9)
    images = [rng.integers(0, 255, (30, 40, 3), dtype=np.uint8) for _ in range(6)]
    frames = [
        Frame(index, image, ("red", "green", "blue"), nadir_pose([index, 0.0, 20.0], 0.2 * index), camera)
        for index, image in enumerate(images)
    ]
    grid = choose_grid(frames, 0.0)
    shape = grid.rows // 3, grid.columns // 3
    results = [rx_scores(images[0]), integrate(frames, grid).mean, integrate(frames, grid, shape).mean]
    before = [result.copy() for result in results]
    assert scratch._spare
    for memory in scratch._spare:
        memory.fill(-1.0)
    for result, expected in zip(results, before, strict=True):
        np.testing.assert_array_equal(result, expected)
    np.testing.assert_array_equal(rx_scores(images[0]), before[0])
    np.testing.assert_array_equal(integrate(frames, grid).mean, before[1])
    np.testing.assert_array_equal(integrate(frames, grid, shape).mean, before[2])
    for image, frame in zip(images, frames, strict=True):
        assert frame.image is image


def test_frames_of_floats_stay_as_they_are() -> None:
    image = np.random.default_rng(1).random((30, 40, 3)).astype(np.float32)
    frame = Frame(1, image, ("red", "green", "blue"), nadir_pose([0.0, 0.0, 20.0]), CameraModel.from_fov(40, 30, 0.9))
    copy, grid = image.copy(), choose_grid([frame], 0.0)
    integrate([frame], grid, (grid.rows // 3, grid.columns // 3))
    assert all(not np.shares_memory(memory, image) for memory in scratch._spare)
    np.testing.assert_array_equal(image, copy)
