"""Bodies that are no persons: sizes, temperatures, places."""

import numpy as np
import pytest

from aos_sim.world.distractors import Distractor, DistractorKind, distractor_mesh, make_distractor
from aos_sim.world.person import person_mesh
from aos_sim.world.scene import SceneParameters, build_scene

MIDDLE_ENU_M = np.array([3.0, -2.0, 0.0])


def draw(kind: DistractorKind, seed: int = 0) -> Distractor:
    return make_distractor(np.random.default_rng(seed), kind, MIDDLE_ENU_M)


@pytest.mark.parametrize("kind", DistractorKind)
def test_body_has_its_size_and_stands_on_the_ground(kind: DistractorKind) -> None:
    body = draw(kind)
    triangles = distractor_mesh(body).triangles_enu_m - MIDDLE_ENU_M
    sin, cos = np.sin(body.heading_rad), np.cos(body.heading_rad)
    along = triangles[..., :2] @ [sin, cos]
    assert np.ptp(along) == pytest.approx(body.length_m, rel=0.1)
    assert triangles[..., 2].max() == pytest.approx(body.height_m, rel=0.1)
    if kind in {"deer", "boar"}:
        assert triangles[..., 2].min() == pytest.approx(0.0, abs=1e-3)
    else:
        assert triangles[..., 2].min() == pytest.approx(-body.height_m, rel=0.1)


@pytest.mark.parametrize("kind", DistractorKind)
def test_equal_generators_give_equal_bodies(kind: DistractorKind) -> None:
    one, same, other = (distractor_mesh(draw(kind, seed)).triangles_enu_m for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert not np.array_equal(one, other)


def test_nothing_is_as_warm_as_skin_and_cloth_is_as_cold_as_the_ground() -> None:
    (person,) = build_scene(SceneParameters(side_m=20.0)).persons
    skin_celsius = person_mesh(person).temperature_celsius.max()
    for seed in range(50):
        for kind in DistractorKind:
            celsius = distractor_mesh(draw(kind, seed)).temperature_celsius
            assert celsius.max() < skin_celsius - 2.0
            if kind is DistractorKind.CLOTH:
                assert 9.0 < celsius.min() <= celsius.max() < 13.0


def test_stones_are_warmest_on_top() -> None:
    stone = draw(DistractorKind.STONE)
    mesh = distractor_mesh(stone)
    height_m = mesh.triangles_enu_m[..., 2].mean(axis=1)
    assert mesh.temperature_celsius[height_m.argmax()] == pytest.approx(stone.temperature_celsius, abs=0.3)
    assert mesh.temperature_celsius[height_m < 0.0].max() == pytest.approx(stone.temperature_celsius - 3.0, abs=0.3)


def test_animals_are_warmest_at_head_and_legs() -> None:
    deer = draw(DistractorKind.DEER)
    celsius = distractor_mesh(deer).temperature_celsius
    assert set(np.unique(celsius)) == {np.float32(deer.temperature_celsius), np.float32(deer.bare_temperature_celsius)}
    assert deer.bare_temperature_celsius > deer.temperature_celsius + 2.0
