"""Conditions and clothes: what is warm beside persons, and what is hidden of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.errors import ConfigurationError
from aos_sim.render.lighting import light_ground, shade_mesh
from aos_sim.render.raycaster import RayCaster
from aos_sim.world.conditions import CLIMATES, Conditions
from aos_sim.world.distractors import DistractorKind, distractor_mesh, make_distractor
from aos_sim.world.ground import GROUND_TEMPERATURE_CELSIUS
from aos_sim.world.mesh import Material, Mesh
from aos_sim.world.person import Person, Posture, person_mesh
from aos_sim.world.scene import SceneParameters, build_scene

OPEN = RayCaster(np.empty((0, 3, 3), np.float32))
ROOF = RayCaster(np.array([[[-99, -99, 9], [99, -99, 9], [0, 199, 9]]], np.float32))
PERSON = Person("anna", np.array([2.0, 30.0, 0.0]), 0.4, 1.75, Posture.STANDING, (200, 40, 40), 32.0, 26.0)
MIDDLE = np.array([3.0, -2.0, 0.0])


def shown(mesh: Mesh, conditions: Conditions) -> np.ndarray:
    """Red, green, blue and °C per triangle in the open."""
    return shade_mesh(mesh, OPEN, CLIMATES[conditions])


def warmest(kind: DistractorKind, conditions: Conditions) -> float:
    meshes = [distractor_mesh(make_distractor(np.random.default_rng(i), kind, MIDDLE)) for i in range(40)]
    return max(float(shown(mesh, conditions)[:, 3].max()) for mesh in meshes)


def ground_celsius(conditions: Conditions) -> float:
    scene = build_scene(SceneParameters(trees_per_ha=0.0, side_m=10.0, conditions=conditions))
    return float(light_ground(scene, OPEN).sample(np.zeros(50), np.linspace(9.0, 17.0, 50))[:, 3].mean())


def test_the_cool_morning_changes_no_body() -> None:
    mesh = person_mesh(PERSON)
    np.testing.assert_array_equal(shown(mesh, Conditions.COOL)[:, 3], mesh.temperature_celsius)


@pytest.mark.parametrize("conditions", [Conditions.CLEAR, Conditions.WARM])
@pytest.mark.parametrize("kind", [DistractorKind.STONE, DistractorKind.STUMP])
def test_skin_is_not_the_warmest_where_the_sun_shines(conditions: Conditions, kind: DistractorKind) -> None:
    mesh = person_mesh(PERSON)
    skin_celsius = float(shown(mesh, conditions)[mesh.material == Material.SKIN, 3].max())
    assert warmest(kind, conditions) > skin_celsius
    assert warmest(DistractorKind.WATER, conditions) < ground_celsius(conditions)


def test_a_warm_day_leaves_little_contrast_of_clothes() -> None:
    mesh = person_mesh(PERSON)
    clothes = mesh.material == Material.CLOTHING
    cool, warm = (
        float(shade_mesh(mesh, ROOF, CLIMATES[conditions])[clothes, 3].mean()) - ground_celsius(conditions)
        for conditions in (Conditions.COOL, Conditions.WARM)
    )
    assert cool == pytest.approx(26.0 - GROUND_TEMPERATURE_CELSIUS, abs=1.5)
    assert warm < cool - 6.0


@pytest.mark.parametrize("conditions", [Conditions.CLEAR, Conditions.WARM])
def test_the_sun_makes_clothes_and_fur_hotter_than_skin_the_darker_the_more(conditions: Conditions) -> None:
    def sun_k(mesh: Mesh, material: Material) -> float:
        chosen = mesh.material == material
        shade = shade_mesh(mesh, ROOF, CLIMATES[conditions])[chosen, 3]
        return float((shown(mesh, conditions)[chosen, 3] - shade).mean())

    dark, bright = (person_mesh(replace(PERSON, clothing_rgb=rgb)) for rgb in ((40, 40, 50), (230, 230, 220)))
    assert sun_k(dark, Material.CLOTHING) > 12.0
    assert 2.0 < sun_k(bright, Material.CLOTHING) < 8.0
    assert sun_k(dark, Material.SKIN) == 0.0
    boar = distractor_mesh(make_distractor(np.random.default_rng(1), DistractorKind.BOAR, MIDDLE))
    assert sun_k(boar, Material.FUR) > 8.0


def test_nights_are_dark_and_cold_and_overcast_days_without_shadows() -> None:
    mesh = person_mesh(PERSON)
    assert shown(mesh, Conditions.NIGHT)[:, :3].max() < 8.0
    assert ground_celsius(Conditions.NIGHT) == pytest.approx(GROUND_TEMPERATURE_CELSIUS - 5.0, abs=0.7)
    dark = shade_mesh(mesh, ROOF, CLIMATES[Conditions.OVERCAST])
    np.testing.assert_array_equal(dark, shown(mesh, Conditions.OVERCAST))


def test_hoods_and_gloves_hide_skin_and_blankets_most_of_a_body() -> None:
    def seen_from_above(person: Person) -> np.ndarray:
        """Temperatures on a raster of vertical rays."""
        mesh = person_mesh(person)
        grid = np.stack(np.meshgrid(np.linspace(-1, 1, 120), np.linspace(-1, 1, 120)), axis=-1).reshape(-1, 2)
        origins = np.column_stack([grid + person.position_enu_m[:2], np.full(len(grid), 5.0)]).astype(np.float32)
        down = np.tile(np.array([[0.0, 0.0, -1.0]], np.float32), (len(grid), 1))
        triangle = RayCaster(mesh.triangles_enu_m).first_hit(origins, down)
        return mesh.temperature_celsius[triangle[triangle >= 0]]

    bare = seen_from_above(PERSON)
    hidden = seen_from_above(replace(PERSON, hooded=True, gloved=True))
    assert np.count_nonzero(hidden > 28.0) < 0.3 * np.count_nonzero(bare > 28.0)
    lying = replace(PERSON, posture=Posture.LYING)
    covered = seen_from_above(replace(lying, blanket=True))
    assert np.median(seen_from_above(lying)) == pytest.approx(26.0)
    assert np.median(covered) < 18.0


def test_a_walking_person_is_in_mid_stride() -> None:
    stride_m = {
        posture: np.ptp(person_mesh(replace(PERSON, posture=posture, heading_rad=0.0)).triangles_enu_m[..., 1])
        for posture in (Posture.STANDING, Posture.WALKING)
    }
    assert stride_m[Posture.WALKING] > stride_m[Posture.STANDING] + 0.3


def test_pairs_stand_together_and_clothes_are_drawn() -> None:
    parameters = SceneParameters(seed=4, trees_per_ha=20.0, persons=6, posture=Posture.SITTING)
    plain, paired = (build_scene(replace(parameters, in_pairs=both, dressed=both)) for both in (False, True))
    places_m = np.array([person.position_enu_m for person in paired.persons])
    gaps_m = np.linalg.norm(places_m[1::2] - places_m[::2], axis=1)
    assert np.all((gaps_m >= 0.8) & (gaps_m <= 2.0))
    np.testing.assert_array_equal(places_m[::2], [person.position_enu_m for person in plain.persons[::2]])
    assert not any(person.hooded or person.gloved or person.blanket for person in plain.persons)
    assert any(person.hooded or person.gloved or person.blanket for person in paired.persons)


def test_unknown_conditions_are_refused_by_name() -> None:
    with pytest.raises(ConfigurationError, match="conditions must be one of cool, clear, overcast, night, warm, got"):
        SceneParameters(conditions="hot")  # type: ignore[arg-type]
    with pytest.raises(ConfigurationError, match="waters must lie within 0 and 100, got -1"):
        SceneParameters(waters=-1)
