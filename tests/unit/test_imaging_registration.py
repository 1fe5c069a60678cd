"""Registration finds the errors of vehicles below two layers of texture: a canopy with gaps above the ground."""

from __future__ import annotations

import json
import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import Plane, plane_to_image
from aos_gcs.imaging.autofocus import focus_curve
from aos_gcs.imaging.focus_region import ViewRegion
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.registration import MIN_INLIER_SHARE, PoseCorrection, Registration, apply_sure, corrected, register

CAMERA = CameraModel.from_fov(256, 256, math.radians(50.0))
CAMERA_F0 = CameraModel.from_fov(512, 512, math.radians(50.815436217896945))
RECORDED = Path(__file__).resolve().parents[3] / "shared" / "data" / "F0"
CANOPY_M = 12.0
TEXTURE_M_PER_PX = 0.1
TEXTURE_SIZE = 700
N = 6


def texture(rng: np.random.Generator) -> NDArray[np.float32]:
    """Structure of half a metre and up, of unit variance."""
    noise = rng.standard_normal((TEXTURE_SIZE, TEXTURE_SIZE)).astype(np.float32)
    smooth = cv2.GaussianBlur(noise, (0, 0), 3.0)
    return np.asarray(smooth / smooth.std(), dtype=np.float32)


class World:
    """Ground at z = 0 below a canopy that hides about 70 % of it."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.ground, self.canopy = texture(rng), texture(rng)
        self.leaves = (cv2.GaussianBlur(texture(rng), (0, 0), 8.0) > -0.2).astype(np.float32)

    def look(self, pose: Pose, rng: np.random.Generator) -> NDArray[np.float32]:
        ground = self._on_image(self.ground, pose, 0.0)
        canopy = self._on_image(self.canopy, pose, CANOPY_M)
        hidden = self._on_image(self.leaves, pose, CANOPY_M) > 0.5
        image = np.where(hidden, canopy, ground) + rng.normal(0.0, 0.1, ground.shape)
        return np.asarray(100.0 + 10.0 * image[:, :, np.newaxis], dtype=np.float32)

    @staticmethod
    def _on_image(layer: NDArray[np.float32], pose: Pose, height_m: float) -> NDArray[np.float32]:
        r, half_m = TEXTURE_M_PER_PX, TEXTURE_M_PER_PX * TEXTURE_SIZE / 2
        to_plane = np.array([[r, 0.0, -half_m], [0.0, -r, half_m], [0.0, 0.0, 1.0]])
        H = plane_to_image(CAMERA, pose, height_m) @ to_plane
        return np.asarray(cv2.warpPerspective(layer, H, (CAMERA.width_px, CAMERA.height_px)))


def step(world: World, errors: NDArray[np.float64], rng: np.random.Generator, tilt_rad: float = 0.0) -> list[Frame]:
    """Frames of vehicles scattered over 12 m, with the poses that they report."""
    places_m = rng.uniform(-6.0, 6.0, (len(errors), 2))
    frames = []
    for index, (place_m, error) in enumerate(zip(places_m, errors, strict=True)):
        reported = nadir_pose([*place_m, 35.0 + index])
        true = corrected(reported, PoseCorrection(*error))
        tilt, _ = cv2.Rodrigues(np.array([*rng.normal(0.0, 1.0, 2) * tilt_rad, 0.0]))
        true = Pose(true.position_enu_m, tilt @ true.R_cam2enu)
        frames.append(Frame(index + 1, world.look(true, rng), ("grey",), reported, CAMERA))
    return frames


def recorded_frames() -> list[Frame]:
    """Every third image of the flight, as if each came from a vehicle of its own."""
    frames = []
    for entry in json.loads((RECORDED / "poses.json").read_text())["images"][::3]:
        M = np.array(entry["M3x4"], dtype=np.float64)
        image = cv2.imread(str(RECORDED / "images" / entry["imagefile"]), cv2.IMREAD_GRAYSCALE)
        pose = Pose(-M[:, :3].T @ M[:, 3], M[:, :3].T)
        frames.append(Frame(len(frames), np.asarray(image)[:, :, np.newaxis], ("thermal",), pose, CAMERA_F0))
    return frames


def draw_errors(rng: np.random.Generator, n: int = N) -> NDArray[np.float64]:
    """East, north, up (m) and yaw (rad) of each vehicle: satellite positions and compasses."""
    return rng.normal(0.0, [0.5, 0.5, 0.75, math.radians(3.0)], (n, 4))


def left_over(registration: Registration, errors: NDArray[np.float64]) -> NDArray[np.float64]:
    """What the corrections leave of the errors, both relative to the mean of the fleet."""
    found = np.array([[c.east_m, c.north_m, c.up_m, c.yaw_rad] for c in registration.corrections().values()])
    return found - (errors - errors.mean(axis=0))


def test_errors_of_offset_and_yaw_are_found_below_a_canopy() -> None:
    rng = np.random.default_rng(1)
    world, errors = World(1), draw_errors(rng)
    registration = Registration()
    for _ in range(6):
        registration = register(step(world, errors, rng), registration, 0.0)
    rest = left_over(registration, errors)
    assert np.sqrt(np.mean(rest[:, 2] ** 2)) < 0.3
    assert np.sqrt(np.mean(rest[:, :2] ** 2)) < 0.1
    assert np.degrees(np.abs(rest[:, 3])).max() < 0.2
    assert registration.confidence > 0.7


def test_tilts_of_single_frames_average_out() -> None:
    rng = np.random.default_rng(2)
    world, errors = World(2), draw_errors(rng)
    registration = Registration()
    for _ in range(6):
        registration = register(step(world, errors, rng, tilt_rad=math.radians(1.0)), registration, 0.0)
    rest, sigmas = left_over(registration, errors), registration.sigmas()
    assert np.sqrt(np.mean(rest[:, :2] ** 2)) < 0.25
    assert np.degrees(np.abs(rest[:, 3])).max() < 0.2
    assert np.sqrt(np.mean((rest / sigmas) ** 2)) < 2.5


@pytest.mark.skipif(not RECORDED.is_dir(), reason="the recorded flight F0 is absent at ../shared/data/F0")
def test_a_flight_with_good_poses_is_not_made_worse() -> None:
    frames = recorded_frames()
    registration = register(frames, Registration(), 18.0)
    used = apply_sure(registration, frames, min_confidence=0.6)
    view = ViewRegion.whole(CAMERA_F0, frames[5].pose)
    before, after = (focus_curve(each, view, [Plane(18.0)], reduction=2).values[0] for each in (frames, used))
    assert after >= before


def test_correction_and_error_are_the_same_thing() -> None:
    reported = nadir_pose([3.0, 4.0, 35.0], heading_rad=0.2)
    pose = corrected(reported, PoseCorrection(0.5, -0.25, 0.75, 0.1))
    assert pose.R_cam2enu == pytest.approx(nadir_pose([0.0, 0.0, 0.0], heading_rad=0.3).R_cam2enu)
    assert pose.position_enu_m == pytest.approx([3.5, 3.75, 35.75])


def test_frames_that_have_nothing_in_common_teach_nothing() -> None:
    rng = np.random.default_rng(0)
    noise = [
        Frame(i, rng.normal(100.0, 10.0, (256, 256, 1)).astype(np.float32), ("grey",), nadir_pose([i, 0, 35]), CAMERA)
        for i in range(4)
    ]
    registration = register(noise, Registration(), 0.0)
    assert (registration.steps, registration.confidence) == (0, 0.0)
    assert registration.errors.mean == pytest.approx(np.zeros(16))


def test_frames_without_structure_or_alone_teach_nothing() -> None:
    flat = np.full((256, 256, 1), 7.0, dtype=np.float32)
    frames = [Frame(i, flat, ("grey",), nadir_pose([i, 0, 35]), CAMERA) for i in range(3)]
    assert register(frames, Registration(), 0.0).steps == 0
    assert register(frames[:1], Registration(), 0.0).steps == 0


def test_knowledge_of_an_absent_vehicle_is_kept_and_a_new_one_starts_from_nothing() -> None:
    rng = np.random.default_rng(3)
    world, errors = World(3), draw_errors(rng)
    known = register(step(world, errors, rng), Registration(), 0.0)
    frames = step(world, errors, rng)
    fewer = register(frames[:-1], known, 0.0)
    assert fewer.vehicle_ids == known.vehicle_ids
    assert fewer.sigmas()[:, 3].max() <= known.sigmas()[:, 3].max()
    begun = register(frames[:-1], Registration(), 0.0)
    joined = register(frames, begun, 0.0)
    assert joined.vehicle_ids == (*begun.vehicle_ids, N)
    assert joined.inlier_share >= MIN_INLIER_SHARE


def test_corrections_are_relative_to_the_mean_of_the_fleet() -> None:
    rng = np.random.default_rng(4)
    registration = register(step(World(4), draw_errors(rng), rng), Registration(), 0.0)
    values = np.array([[c.east_m, c.north_m, c.up_m, c.yaw_rad] for c in registration.corrections().values()])
    assert values.mean(axis=0) == pytest.approx(np.zeros(4), abs=1e-9)


def test_two_frames_of_one_vehicle_are_refused() -> None:
    rng = np.random.default_rng(5)
    frames = step(World(5), draw_errors(rng), rng)
    with pytest.raises(ImagingError, match="one frame per vehicle"):
        register([frames[0], frames[0]], Registration(), 0.0)
