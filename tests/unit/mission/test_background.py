"""Warning of a forest that is nearly as warm as persons."""

from __future__ import annotations

import math

import numpy as np

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.model import Frame
from aos_gcs.mission.search.frames.background import BackgroundWatch
from aos_gcs.ports import Severity
from tests.fakes.notices import Notices

CAMERA = CameraModel.from_fov(64, 48, 0.9)


def frame(celsius: float, dtype: type[np.generic] = np.float32, band: str = "thermal") -> Frame:
    image = np.full((48, 64, 1), celsius, dtype=dtype)
    return Frame(1, image, (band,), nadir_pose([0.0, 0.0, 30.0]), CAMERA)


def test_a_warm_forest_is_reported_once_after_three_steps() -> None:
    told = Notices()
    watch = BackgroundWatch(told)
    for celsius in (26.0, 26.0, 14.0, 25.0, 24.0):
        watch.note([frame(celsius), frame(celsius + 1.0), frame(35.0)])
    assert not told.texts
    for _ in range(5):
        watch.note([frame(23.0), frame(24.0), frame(35.0)])
    (text,) = told.texts
    assert text.startswith("Forest and ground at 24 °C: persons are hardly warmer")
    assert told.severities == [Severity.WARNING]


def test_a_sunny_day_is_reported_once_after_three_steps() -> None:
    told = Notices()
    watch = BackgroundWatch(told)
    for is_sunny in (True, True, False, True, True):
        watch.note_sun(is_sunny=is_sunny)
    assert not told.texts
    for _ in range(5):
        watch.note_sun(is_sunny=True)
    (text,) = told.texts
    assert text.startswith("The sun warms clothes, fur and stones alike")


def test_what_tells_no_temperatures_tells_nothing_of_the_forest() -> None:
    told = Notices()
    watch = BackgroundWatch(told)
    for _ in range(5):
        watch.note([])
        watch.note([frame(120.0, np.uint8), frame(120.0, band="grey"), frame(math.nan)])
        watch.note([frame(12.0)])
    assert not told.texts
