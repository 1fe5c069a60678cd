"""Images that processes read for each other: threads stand for the processes here."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geometry.projection import Plane
from aos_gcs.imaging.model import Detector, Frame
from aos_gcs.surveys import shared_reading
from aos_gcs.surveys.integration import Read, Work, read_with_levels
from aos_gcs.surveys.model import SurveyImage
from aos_gcs.surveys.shared_reading import ReadingPlan, SharedReading, StoppedError
from aos_gcs.surveys.tiles import ViewTile

CAMERA = CameraModel.from_fov(24, 20, math.radians(60.0))
COUNT = 25
SEEN = [tuple(range(COUNT)), (*range(4), 21, 23, 24), (20, 21, 24)]
"""Images that the tiles of each process need: the last one needs none of the first chunks."""


@pytest.fixture
def work(tmp_path: Path) -> Work:
    rng = np.random.default_rng(0)
    images = []
    for index in range(COUNT):
        path = tmp_path / f"{index}.png"
        picture = rng.integers(100, 110, (CAMERA.height_px, CAMERA.width_px), dtype=np.uint8)
        picture[8:10, 8 : 8 + index % 3] = 255
        cv2.imwrite(str(path), picture)
        images.append(SurveyImage(path, nadir_pose([1.0 * index, 0.0, 15.0]), CAMERA))
    return Work(tuple(images), ("grey",), Plane(0.0), detector=Detector.LOCAL_RX)


def groups(seen: Sequence[tuple[int, ...]]) -> list[list[ViewTile]]:
    return [[ViewTile(indices, CAMERA, nadir_pose([0.0, 0.0, 15.0]))] for indices in seen]


def read(work: Work, seen: Sequence[tuple[int, ...]], stop: threading.Event | None = None) -> list[dict[int, Read]]:
    """Return what each of the processes gets."""
    plan = ReadingPlan.of(work, groups(seen))
    assert plan is not None
    memory, condition = np.zeros(plan.memory_bytes, np.uint8), threading.Condition()
    is_stopped = (stop or threading.Event()).is_set

    def run(group: int) -> dict[int, Read]:
        reading = SharedReading(plan, group, work, None, memory=memory, condition=condition, is_stopped=is_stopped)
        found: dict[int, Read] = {}
        for batch in reading.batches(seen[group]):
            for index, one in batch:
                # What is lent may be kept until the next batch only.
                found[index] = one if isinstance(one, str) else _copied(one)
        return found

    with ThreadPoolExecutor(len(seen)) as pool:
        return list(pool.map(run, range(len(seen))))


def _copied(one: tuple[Frame, Frame | None]) -> Read:
    frame, levels = one
    marks = None if levels is None else replace(levels, image=levels.image.copy())
    return replace(frame, image=frame.image.copy()), marks


def assert_same(one: Read, other: Read) -> None:
    if isinstance(one, str) or isinstance(other, str):
        assert one == other
        return
    for own, alone in zip(one, other, strict=True):
        assert (own is None) is (alone is None)
        if own is not None and alone is not None:
            assert (own.vehicle_id, own.bands, own.pose, own.camera) == (
                alone.vehicle_id,
                alone.bands,
                alone.pose,
                alone.camera,
            )
            np.testing.assert_array_equal(own.image, alone.image)


def test_each_image_is_read_once_and_everybody_gets_what_it_is_to_one_alone(
    work: Work, monkeypatch: pytest.MonkeyPatch
) -> None:
    times_read: list[int] = []

    def counted(own: Work, cell_m: float | None, index: int) -> Read:
        times_read.append(index)
        return read_with_levels(own, cell_m, index)

    monkeypatch.setattr(shared_reading, "BATCH_FRAMES", 4)
    monkeypatch.setattr(shared_reading, "read_with_levels", counted)
    got = read(work, SEEN)
    assert sorted(times_read) == list(range(COUNT))
    for indices, found in zip(SEEN, got, strict=True):
        assert tuple(found) == indices
        for index, one in found.items():
            assert_same(one, read_with_levels(work, None, index))
    marked = [one[1] is not None for one in got[0].values() if not isinstance(one, str)]
    assert any(marked)
    assert not all(marked)


def test_the_reason_of_a_broken_image_is_told_to_everybody(work: Work) -> None:
    work.images[2].path.write_bytes(b"text")
    first, second, _ = read(replace(work, skip_broken=True), SEEN)
    assert isinstance(first[2], str)
    assert "2.png" in first[2]
    assert first[2] == second[2]


def test_a_process_that_waits_ends_with_those_that_fail(work: Work, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shared_reading, "_LOOK_S", 0.001)
    work.images[2].path.write_bytes(b"text")
    stop = threading.Event()

    def stopping(own: Work, cell_m: float | None, index: int) -> Read:
        try:
            return read_with_levels(own, cell_m, index)
        except InputDataError:
            stop.set()
            raise

    monkeypatch.setattr(shared_reading, "read_with_levels", stopping)
    with pytest.raises((InputDataError, StoppedError)):
        read(work, SEEN, stop)


def test_processes_read_for_themselves_what_is_too_large_or_needed_once(work: Work) -> None:
    assert ReadingPlan.of(work, groups([(0, 1), (2, 3)])) is None
    assert ReadingPlan.of(work, groups(SEEN[:1])) is None
    assert ReadingPlan.of(replace(work, trim=0.5), groups(SEEN)) is None
    assert ReadingPlan.of(replace(work, max_bytes=20_000), groups(SEEN)) is None
