"""What the cameras would see of the person without a forest."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_sim.truth import unoccluded_areas_m2
from aos_sim.world.scene import SceneParameters, build_scene

SEED, TREES_PER_HA = 3, 20.0
CAMERA = CameraModel.from_fov(128, 128, math.radians(50.0))


@pytest.fixture(scope="module")
def person_enu_m() -> np.ndarray:
    (person,) = build_scene(SceneParameters(seed=SEED, trees_per_ha=TREES_PER_HA)).persons
    return np.array(person.position_enu_m)


def areas_m2(*steps: list[Pose], plane_height_m: float = 0.0) -> list[float]:
    views = [[(pose, CAMERA) for pose in poses] for poses in steps]
    return unoccluded_areas_m2({"seed": SEED, "trees_per_ha": TREES_PER_HA}, views, plane_height_m)


def above(person_enu_m: np.ndarray, east_m: float = 0.0, north_m: float = 0.0, height_m: float = 40.0) -> Pose:
    return nadir_pose(person_enu_m + np.array([east_m, north_m, height_m]))


def test_a_standing_person_covers_little_from_straight_above(person_enu_m: np.ndarray) -> None:
    (area_m2,) = areas_m2([above(person_enu_m)])
    assert 0.08 < area_m2 < 0.5


def test_an_oblique_view_covers_the_shadow_of_the_whole_body(person_enu_m: np.ndarray) -> None:
    nadir_m2, oblique_m2 = areas_m2([above(person_enu_m)], [above(person_enu_m, east_m=15.0)])
    assert oblique_m2 > 1.5 * nadir_m2


def test_views_together_cover_their_union(person_enu_m: np.ndarray) -> None:
    west, east = above(person_enu_m, east_m=-15.0), above(person_enu_m, east_m=15.0)
    both_m2, west_m2, east_m2, twice_m2 = areas_m2([west, east], [west], [east], [west, west])
    assert max(west_m2, east_m2) < both_m2 < west_m2 + east_m2
    assert twice_m2 == west_m2


def test_views_that_do_not_show_the_person_do_not_count(person_enu_m: np.ndarray) -> None:
    outside = above(person_enu_m, east_m=40.0 * math.tan(math.radians(25.0)) + 1.0)
    inside = above(person_enu_m, east_m=40.0 * math.tan(math.radians(25.0)) - 1.0)
    upwards = Pose(person_enu_m + np.array([0.0, 0.0, 40.0]), np.eye(3))
    assert areas_m2([outside], [upwards], []) == [0.0, 0.0, 0.0]
    assert areas_m2([inside])[0] > 0.0


def test_a_plane_nearer_to_the_camera_is_covered_less(person_enu_m: np.ndarray) -> None:
    pose = above(person_enu_m, east_m=15.0)
    (on_ground_m2,), (above_ground_m2,) = areas_m2([pose]), areas_m2([pose], plane_height_m=1.0)
    assert 0.0 < above_ground_m2 < on_ground_m2
