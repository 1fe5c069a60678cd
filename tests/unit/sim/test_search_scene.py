"""Scenes of the study of effectiveness: bodies, what cameras see, and what they report."""

import math

import numpy as np
import pytest

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.lab.scenes import PositionGrade, SceneSettings, build_scene
from aos_sim.search_scene import SimulatedSearchScene, build_search_scene

CAMERA = CameraModel.from_fov(96, 96, math.radians(50))
VEHICLES = 3


@pytest.fixture(scope="module")
def scene() -> SimulatedSearchScene:
    return build_search_scene(SceneSettings(seed=3, trees_per_ha=100.0, has_person=True, vehicles=VEHICLES))


@pytest.fixture(scope="module")
def positions_enu_m(scene: SimulatedSearchScene) -> np.ndarray:
    east_m, north_m = scene.bodies[0].position_enu_m
    return np.array([[east_m + 4.0 * i, north_m, 35.0 + i] for i in range(VEHICLES)])


def test_the_installed_simulator_provides_scenes(scene: SimulatedSearchScene) -> None:
    again = build_scene(SceneSettings(seed=3, trees_per_ha=100.0, has_person=True, vehicles=VEHICLES))
    assert again.bodies == scene.bodies
    assert again.bodies[0].kind.startswith("person ")


def test_a_scene_without_a_person_has_none() -> None:
    scene = build_search_scene(SceneSettings(seed=3, trees_per_ha=20.0, has_person=False, vehicles=VEHICLES))
    assert not any(body.kind.startswith("person") for body in scene.bodies)


def test_areas_are_those_of_bodies_in_view(scene: SimulatedSearchScene, positions_enu_m: np.ndarray) -> None:
    far_away = positions_enu_m + np.array([500.0, 0.0, 0.0])
    areas_m2 = scene.visible_areas_m2(positions_enu_m, CAMERA)
    assert areas_m2.shape == (VEHICLES, len(scene.bodies))
    assert areas_m2[:, 0].max() < 2.0
    np.testing.assert_array_equal(scene.visible_areas_m2(far_away, CAMERA), 0.0)


def test_vehicles_hover_and_report_beside_where_they_were_sent(
    scene: SimulatedSearchScene, positions_enu_m: np.ndarray
) -> None:
    exposures = scene.expose(positions_enu_m, CAMERA, np.random.default_rng(1))
    assert [exposure.image.shape for exposure in exposures] == [(96, 96, 4)] * VEHICLES
    gnss, rtk = (
        np.array([exposure.reported[grade].position_enu_m for exposure in exposures]) for grade in PositionGrade
    )
    # A vehicle believes to be where it was sent; RTK tells the truth, but for centimetres.
    np.testing.assert_allclose(gnss, positions_enu_m, atol=1e-9)
    assert np.abs(rtk - positions_enu_m)[:, :2].max() > 0.05
    for exposure in exposures:
        one, other = exposure.reported.values()
        np.testing.assert_array_equal(one.R_cam2enu, other.R_cam2enu)


def test_equal_generators_give_equal_exposures(scene: SimulatedSearchScene, positions_enu_m: np.ndarray) -> None:
    first, second = (scene.expose(positions_enu_m, CAMERA, np.random.default_rng(7)) for _ in range(2))
    for one, other in zip(first, second, strict=True):
        np.testing.assert_array_equal(one.image, other.image)
        np.testing.assert_array_equal(
            one.reported[PositionGrade.GNSS].position_enu_m, other.reported[PositionGrade.GNSS].position_enu_m
        )


def test_each_camera_has_a_thermal_offset_of_its_own(scene: SimulatedSearchScene, positions_enu_m: np.ndarray) -> None:
    exposures = scene.expose(positions_enu_m, CAMERA, np.random.default_rng(2))
    medians = [float(np.median(exposure.image[..., 3])) for exposure in exposures]
    assert np.ptp(medians) > 0.2
