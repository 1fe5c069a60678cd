"""Spots in frames without temperatures: what stands out of its own surroundings."""

import math

import numpy as np
import pytest

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.persons.spots import can_stand_out, relative_view, spot_at

CAMERA = CameraModel.from_fov(256, 256, math.radians(50.0))
NOWHERE_ENU_M = np.array([500.0, 0.0])


def frame(image: np.ndarray, *bands: str) -> Frame:
    return Frame(1, image, bands, nadir_pose([0.0, 0.0, 35.0]), CAMERA)


def noise(bands: int = 1) -> np.ndarray:
    return np.random.default_rng(1).normal(100.0, 5.0, (256, 256, bands)).astype(np.float32)


def test_a_faint_spot_stands_out_of_quiet_ground_and_not_of_a_rough_clearing() -> None:
    image = noise()
    image[:, 128:] += 5.0 * (noise()[:, 128:] - 100.0)
    for column in (64, 192):
        image[126:131, column - 2 : column + 3] = 145.0
    easts_m = relative_view(frame(image.clip(0, 255).astype(np.uint8), "thermal")).points_enu_m[:, 0]
    assert np.count_nonzero(np.abs(easts_m + 8.2) < 1.0) >= 20
    assert np.count_nonzero(np.abs(easts_m - 8.2) < 1.0) <= 3


def test_pixels_without_a_value_and_frames_without_contrast_show_nothing() -> None:
    image = noise()
    image[128:] = np.nan
    norths_m = relative_view(frame(image, "thermal")).points_enu_m[:, 1]
    assert (norths_m > 0.0).all()
    assert not len(relative_view(frame(np.full((256, 256, 1), 7, np.uint8), "grey")).points_enu_m)


def test_colours_do_not_stand_out() -> None:
    colours = frame(noise(3), "red", "green", "blue")
    assert not can_stand_out(colours)
    with pytest.raises(ValueError, match="red, green, blue"):
        relative_view(colours)


def test_a_place_that_no_frame_holds_has_no_evidence() -> None:
    evidence, spot = spot_at(NOWHERE_ENU_M, [relative_view(frame(noise(), "thermal"))], 0.0)
    assert (evidence.frames, evidence.views, spot) == (0, 0, ())
    assert not evidence.radiometric
