"""Conditions of a study: what each of them changes in a scene, and what it leaves."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.errors import ConfigurationError
from aos_gcs.lab.flights import FlightParameters
from aos_sim.errors.model import error_model
from aos_sim.flights.conditions import STUDY_CONDITIONS, study_conditions
from aos_sim.flights.world import build_simulated_flight
from aos_sim.world.conditions import Conditions
from aos_sim.world.mesh import Material
from aos_sim.world.person import person_mesh
from aos_sim.world.scene import Scene, SceneParameters, build_scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    return build_scene(
        SceneParameters(seed=3, trees_per_ha=0.0, side_m=30.0, animals=1, stones=1, stumps=1, cloths=1, waters=1)
    )


def test_weather_alone_leaves_bodies_and_optics_as_they_are(scene: Scene) -> None:
    for weather in Conditions:
        conditions = study_conditions(weather)
        assert conditions.weather is weather
        same = conditions.scene(scene)
        assert person_mesh(same.persons[0]).temperature_celsius == pytest.approx(
            person_mesh(scene.persons[0]).temperature_celsius
        )
        assert conditions.errors(error_model("rtk")) == error_model("rtk")


def test_nobody_shows_skin(scene: Scene) -> None:
    (person,) = study_conditions("no-skin").scene(scene).persons
    materials = person_mesh(person).material
    assert (person_mesh(scene.persons[0]).material == Material.SKIN).any()
    assert set(np.unique(materials)) == {int(Material.CLOTHING)}


@pytest.mark.parametrize("cooler_k", [2.0, 4.0])
def test_persons_alone_are_cooler(scene: Scene, cooler_k: float) -> None:
    altered = study_conditions(f"persons-{cooler_k:g}k-cooler").scene(scene)
    before, after = (person_mesh(one.persons[0]).temperature_celsius for one in (scene, altered))
    assert before - after == pytest.approx(cooler_k, abs=1e-4)
    assert [one.temperature_celsius for one in altered.distractors] == [
        one.temperature_celsius for one in scene.distractors
    ]


def test_animals_stones_and_stumps_are_warmer_and_cloth_and_water_are_not(scene: Scene) -> None:
    altered = study_conditions("distractors-3k-warmer").scene(scene)
    warmer_k = {
        str(before.kind): after.temperature_celsius - before.temperature_celsius
        for before, after in zip(scene.distractors, altered.distractors, strict=True)
    }
    animal = next(kind for kind in warmer_k if kind in ("deer", "boar"))
    assert warmer_k == pytest.approx({animal: 3.0, "stone": 3.0, "stump": 3.0, "cloth": 0.0, "water": 0.0})
    assert altered.persons[0].skin_temperature_celsius == scene.persons[0].skin_temperature_celsius


def test_optics_blur_twice_as_far() -> None:
    exact, blurred = (study_conditions(name).errors(error_model("rtk")).optics for name in ("cool", "blurred"))
    assert blurred.thermal_blur_px == 2.0 * exact.thermal_blur_px > 0.0
    assert blurred.colour_blur_px == 2.0 * exact.colour_blur_px > 0.0


def test_two_persons_keep_company_or_do_not_and_a_forest_without_persons_stays_empty() -> None:
    for name, least_m, most_m in (("pair", 0.8, 2.0), ("two-persons", 2.0, 30.0)):
        drawn = study_conditions(name).drawn(SceneParameters(seed=5, trees_per_ha=0.0, side_m=30.0))
        first, second = (person.position_enu_m for person in build_scene(drawn).persons)
        assert least_m <= math.dist(first, second) <= most_m
        assert study_conditions(name).drawn(SceneParameters(persons=0)).persons == 0


async def test_a_person_who_walks_is_known_where_it_is_at_any_time() -> None:
    flight = build_simulated_flight(FlightParameters(2, 1, 0.0, has_person=True, conditions="walking", side_m=30.0))
    clock = LoopClock()
    begin_utc_s = clock.utc_s()
    assert flight.persons_at(begin_utc_s + 99.0) == flight.persons_enu_m, "the fleet has not been switched on"
    flight.fleet(clock)
    ((first,), (second,)) = (flight.persons_at(clock.utc_s() + after_s) for after_s in (0.0, 3.0))
    assert first == pytest.approx(flight.persons_enu_m[0], abs=0.1)
    assert math.dist(first, second) == pytest.approx(3.0, abs=0.2)
    assert flight.postures == ["walking"]


def test_unknown_conditions_are_refused_with_the_known_ones() -> None:
    with pytest.raises(ConfigurationError, match=r"conditions must be one of cool.*no-skin.*but are 'hail'"):
        study_conditions("hail")
    assert set(map(str, Conditions)) < set(STUDY_CONDITIONS)
