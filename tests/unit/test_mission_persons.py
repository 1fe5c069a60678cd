"""Whether a target looks like a person, by what was warm in the latest steps."""

import math
from dataclasses import replace

import numpy as np

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.persons.classifier import DECISION
from aos_gcs.mission.search.persons import KEPT_STEPS, PersonWatch, watch_persons

CAMERA = CameraModel.from_fov(256, 256, math.radians(50.0))
PLACE_ENU_M = np.array([2.0, -1.0])
HEIGHT_M = 35.0


def warm_frame(vehicle_id: int, *, clothes_k: float, skin_k: float, size_m: float = 0.5) -> Frame:
    """Forest of 11 °C with a warm square at the place, warmest at its northern edge."""
    gsd_m = HEIGHT_M / CAMERA.fx_px
    image = np.random.default_rng(vehicle_id).normal(11.0, 0.1, (256, 256, 1))
    column = round(PLACE_ENU_M[0] / gsd_m + CAMERA.cx_px)
    row = round(-PLACE_ENU_M[1] / gsd_m + CAMERA.cy_px)
    half = round(size_m / gsd_m / 2)
    image[row - half : row + half + 1, column - half : column + half + 1] = 11.0 + clothes_k
    image[row - half, column - half : column + half + 1] = 11.0 + skin_k
    return Frame(vehicle_id, image.astype(np.float32), ("thermal",), nadir_pose([0.0, 0.0, HEIGHT_M]), CAMERA)


def person(vehicle_id: int) -> Frame:
    return warm_frame(vehicle_id, clothes_k=11.0, skin_k=20.0)


def confidence_at(watch: PersonWatch, place_enu_m: np.ndarray = PLACE_ENU_M) -> float | None:
    return watch.judge({7: place_enu_m})[7]


def test_a_body_as_warm_as_skin_and_clothes_is_taken_for_a_person_and_a_lukewarm_stone_is_not() -> None:
    confidence = confidence_at(PersonWatch().look([person(1), person(2), person(3)], 0.0))
    assert confidence is not None
    assert confidence > DECISION
    stones = [warm_frame(vehicle_id, clothes_k=5.0, skin_k=5.0, size_m=0.3) for vehicle_id in (1, 2, 3)]
    confidence = confidence_at(PersonWatch().look(stones, 0.0))
    assert confidence is not None
    assert confidence < DECISION


def test_a_place_without_anything_warm_gets_no_verdict() -> None:
    assert confidence_at(PersonWatch()) is None
    watch = PersonWatch().look([person(1), person(2)], 0.0)
    assert confidence_at(watch, PLACE_ENU_M + 5.0) is None
    assert watch.judge({}) == {}


def test_frames_without_temperatures_tell_nothing() -> None:
    pixels = person(1).image
    frames = [replace(person(1), bands=("grey",)), replace(person(2), image=(10.0 * pixels).astype(np.uint16))]
    assert confidence_at(PersonWatch().look(frames, 0.0)) is None


def test_what_was_seen_is_forgotten_after_some_steps() -> None:
    watch = PersonWatch().look([person(1), person(2)], 0.0)
    for _ in range(KEPT_STEPS - 1):
        watch, confidences = watch_persons(watch, [], 0.0, {7: PLACE_ENU_M})
        assert confidences[7] is not None
    assert confidence_at(watch.look([], 0.0)) is None
