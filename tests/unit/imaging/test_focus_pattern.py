"""What a camera adds to all of its pictures at the same pixels is no scene, and comes into focus nowhere."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.focus import region as focus_region
from aos_gcs.imaging.focus.autofocus import find_focus
from aos_gcs.imaging.focus.fixed_pattern import WithoutPattern, without_pattern
from aos_gcs.imaging.focus.region import GroundRegion
from aos_gcs.imaging.model import Frame

CAMERA = CameraModel.from_fov(96, 96, np.radians(50.0))
LOOKED_AT_M = 6.0
"""Height of the point that all cameras look at: a pattern of theirs agrees there."""


def pose(x_m: float) -> Pose:
    forward = np.array([-x_m, 0.0, LOOKED_AT_M - 30.0])
    forward /= np.linalg.norm(forward)
    down = np.array([0.0, -1.0, 0.0])
    return Pose(np.array([x_m, 0.0, 30.0]), np.stack((np.cross(down, forward), down, forward), axis=1))


def flight(pattern: NDArray[np.float64] | float, frames: int = 20) -> list[Frame]:
    """Even ground in the noise of a camera, and its pattern."""
    rng = np.random.default_rng(3)
    images = (100.0 + rng.normal(0.0, 2.0, (96, 96)) + pattern for _ in range(frames))
    return [
        Frame(i, image[:, :, np.newaxis].astype(np.float32), ("grey",), pose(x_m), CAMERA)
        for i, (image, x_m) in enumerate(zip(images, np.linspace(-12.0, 12.0, frames), strict=True))
    ]


def dust() -> NDArray[np.float64]:
    return np.kron(np.random.default_rng(1).normal(0.0, 20.0, (12, 12)), np.ones((8, 8)))


def test_a_pattern_of_the_camera_is_no_ground(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(focus_region, "MAX_POINTS", 2_500)
    region = GroundRegion(-6.0, -6.0, 6.0, 6.0)
    assert not find_focus(flight(dust()), region, -5.0, 15.0).found
    monkeypatch.setattr("aos_gcs.imaging.focus.autofocus.without_pattern", lambda frames, _: frames)
    assert find_focus(flight(dust()), region, -5.0, 15.0).found


def test_only_a_pattern_is_taken_out() -> None:
    patterned, plain, hovering = flight(dust()), flight(0.0), [flight(dust())[0]] * 20
    for frames, separation_m in ((plain, 3.0), (patterned, 0.0), (hovering, 3.0), (patterned[:6], 3.0)):
        assert without_pattern(frames, separation_m) is frames
    without = without_pattern(patterned, 3.0)
    assert isinstance(without, WithoutPattern)
    for frame, former in zip(without, plain, strict=True):
        assert np.std(frame.image - former.image) < 1.0
