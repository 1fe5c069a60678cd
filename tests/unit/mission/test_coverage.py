"""Footprints of frames, counts of cameras, and the map of what has been looked at."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from aos_gcs.airspace.polygon import signed_area_m2
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.model import Frame
from aos_gcs.mission.search.frames.cameras import CameraLog, footprint_enu_m
from aos_gcs.mission.search.ground.coverage import CoverageMap

R_NADIR = np.diag([1.0, -1.0, -1.0])
"""Image up is north."""
CAMERA = CameraModel.from_fov(64, 48, math.radians(50.0))
AREA = ((0.0, 0.0), (100.0, 0.0), (100.0, 50.0), (0.0, 50.0))


def frame(vehicle_id: int = 1, tilt_deg: float = 0.0) -> Frame:
    cos, sin = math.cos(math.radians(tilt_deg)), math.sin(math.radians(tilt_deg))
    about_east = np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]])
    pose = Pose(np.array([10.0, 20.0, 30.0]), about_east @ R_NADIR)
    return Frame(vehicle_id, np.zeros((48, 64, 1), np.uint8), ("grey",), pose, CAMERA)


def test_a_camera_that_looks_down_sees_a_rectangle_below_it() -> None:
    footprint = np.array(footprint_enu_m(frame(), 2.0))
    width_m = 2.0 * 28.0 * math.tan(math.radians(25.0))
    half = np.array([width_m, width_m * 48 / 64]) / 2.0
    assert footprint.mean(axis=0) == pytest.approx([10.0, 20.0])
    assert footprint[0] == pytest.approx([10.0 - half[0], 20.0 + half[1]])
    assert abs(signed_area_m2(footprint)) == pytest.approx(4.0 * half[0] * half[1])


def test_a_tilted_camera_sees_more_on_its_far_side() -> None:
    far_left, far_right, near_right, near_left = np.array(footprint_enu_m(frame(tilt_deg=30.0), 0.0))
    assert np.linalg.norm(far_right - far_left) > np.linalg.norm(near_right - near_left)


@pytest.mark.parametrize("tilt_deg", [75.0, 90.0, 180.0])
def test_a_camera_that_sees_the_horizon_has_no_footprint(tilt_deg: float) -> None:
    assert footprint_enu_m(frame(tilt_deg=tilt_deg), 0.0) == ()


def test_frames_and_failures_are_counted() -> None:
    log = CameraLog()
    log.note(1, [frame(1)], [AREA], {2: "no frame before the deadline"})
    log.note(2, [frame(1), frame(2)], [AREA, ()], {})
    assert (log.of(1).frames, log.of(1).failures, log.of(1).last_step) == (2, 0, 2)
    assert log.of(1).footprint_enu_m == AREA
    assert (log.of(2).frames, log.of(2).failures, log.of(2).failure) == (1, 1, None)
    log.note(3, [], [], {2: "torn"})
    assert (log.of(2).failures, log.of(2).failure, log.of(2).last_step) == (2, "torn", 2)
    assert log.of(9).frames == 0


def test_the_map_counts_frames_over_the_area() -> None:
    coverage = CoverageMap(AREA, occlusion=0.8)
    west = ((-10.0, -10.0), (50.0, -10.0), (50.0, 60.0), (-10.0, 60.0))
    coverage.add([west, ()])
    assert coverage.covered_fraction == pytest.approx(0.5, abs=0.01)
    coverage.add([west])
    visibility = coverage.visibility()
    assert visibility is not None
    assert visibility[5, 5] == pytest.approx(1.0 - 0.8**2)
    assert visibility[5, -5] == 0.0


def test_the_pictures_lie_over_the_area_and_hide_what_nobody_saw() -> None:
    coverage = CoverageMap(AREA, occlusion=None)
    coverage.add([((0.0, 0.0), (50.0, 0.0), (50.0, 50.0), (0.0, 50.0))])
    (picture,) = coverage.render()
    assert (picture.kind, picture.west_m, picture.north_m) == ("coverage", 0.0, 50.0)
    assert (picture.east_m, picture.south_m) == pytest.approx((100.0, 0.0), abs=0.5)
    alpha = cv2.imdecode(np.frombuffer(picture.png, np.uint8), cv2.IMREAD_UNCHANGED)[..., 3]
    assert alpha[alpha.shape[0] // 2, 10] > 0
    assert alpha[alpha.shape[0] // 2, -10] == 0
    assert [one.kind for one in CoverageMap(AREA, 0.8).render()] == ["coverage", "visibility"]
