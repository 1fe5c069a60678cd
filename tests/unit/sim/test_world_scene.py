from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.errors import ConfigurationError
from aos_sim.world.ground import CELL_M, TILE_CELLS, make_ground
from aos_sim.world.mesh import Material
from aos_sim.world.person import Posture
from aos_sim.world.scene import Scene, SceneParameters, build_scene
from aos_sim.world.species import BROADLEAF, CONIFER


@pytest.fixture(scope="module")
def scene() -> Scene:
    return build_scene(SceneParameters(seed=4, side_m=40.0, persons=20))


def test_equal_parameters_give_equal_worlds(scene: Scene) -> None:
    again = build_scene(SceneParameters(seed=4, side_m=40.0, persons=20))
    np.testing.assert_array_equal(again.forest.mesh.triangles_enu_m, scene.forest.mesh.triangles_enu_m)
    np.testing.assert_array_equal(again.forest.mesh.albedo_rgb, scene.forest.mesh.albedo_rgb)
    np.testing.assert_array_equal(again.ground.forest_tile, scene.ground.forest_tile)
    for one, other in zip(again.persons, scene.persons, strict=True):
        np.testing.assert_array_equal(one.position_enu_m, other.position_enu_m)
        assert one.clothing_rgb == other.clothing_rgb


def test_another_seed_gives_another_world(scene: Scene) -> None:
    other = build_scene(SceneParameters(seed=5, side_m=40.0, persons=20))
    assert not np.array_equal(other.forest.trunk_enu_m, scene.forest.trunk_enu_m)
    assert not np.array_equal(other.persons[0].position_enu_m, scene.persons[0].position_enu_m)


def test_posture_changes_nothing_else(scene: Scene) -> None:
    lying = build_scene(SceneParameters(seed=4, side_m=40.0, persons=20, posture="lying"))
    np.testing.assert_array_equal(lying.persons[-1].position_enu_m, scene.persons[-1].position_enu_m)
    assert {person.posture for person in lying.persons} == {"lying"}


@pytest.mark.parametrize(("trees_per_ha", "side_m", "count"), [(300, 40, 48), (60, 30, 5), (500, 20, 20), (0, 40, 0)])
def test_forest_has_the_density_asked_for(trees_per_ha: float, side_m: float, count: int) -> None:
    forest = build_scene(SceneParameters(trees_per_ha=trees_per_ha, side_m=side_m)).forest
    assert len(forest.trunk_enu_m) == len(forest.height_m) == count
    assert np.count_nonzero(forest.mesh.material == Material.LEAF) == count * BROADLEAF.leaves


def test_trees_stand_in_the_square_and_apart(scene: Scene) -> None:
    low, high = scene.area_enu_m.min(axis=0), scene.area_enu_m.max(axis=0)
    trunks = scene.forest.trunk_enu_m
    assert low.tolist() == [-20, 8]
    assert high.tolist() == [20, 48]
    assert np.all((trunks > low) & (trunks < high))
    distance = np.linalg.norm(trunks[:, None] - trunks[None], axis=2) + 1e3 * np.eye(len(trunks))
    assert distance.min() > 0.6 * 40 / 7 - 1e-9


def test_tree_sizes_are_within_their_ranges(scene: Scene) -> None:
    forest = scene.forest
    assert np.all((forest.height_m >= 12) & (forest.height_m <= 18))
    assert np.all((forest.crown_radius_m >= 3.2) & (forest.crown_radius_m <= 4.6))
    assert forest.mesh.triangles_enu_m[..., 2].max() < 18 + 3
    assert forest.mesh.triangles_enu_m[..., 2].min() > -0.1


def test_leaves_have_the_area_of_their_squares(scene: Scene) -> None:
    a, b, c = np.moveaxis(scene.forest.mesh.triangles_enu_m[scene.forest.mesh.material == Material.LEAF], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    low, high = ((2 * half_size) ** 2 for half_size in BROADLEAF.leaf_half_size_range_m)
    assert low - 1e-5 < area.min() < area.max() < high + 1e-5


def test_conifers_are_slender_at_the_top() -> None:
    conifers = build_scene(SceneParameters(trees_per_ha=25.0, side_m=40.0, species=CONIFER)).forest
    leaves = conifers.mesh.triangles_enu_m[conifers.mesh.material == Material.LEAF].mean(axis=1)
    tree = np.repeat(np.arange(4), CONIFER.leaves)
    height = leaves[:, 2] / conifers.height_m[tree]
    beside_m = np.linalg.norm(leaves[:, :2] - conifers.trunk_enu_m[tree], axis=1)
    assert beside_m[height < 0.4].mean() > 1.5
    assert beside_m[height > 0.8].mean() < 0.9


def test_vegetation_is_near_the_temperature_of_the_air(scene: Scene) -> None:
    temperatures = scene.forest.mesh.temperature_celsius
    assert 10 < temperatures.min() < temperatures.max() < 14


def test_persons_are_in_the_middle_of_the_forest_and_clear_of_trunks(scene: Scene) -> None:
    places = np.array([person.position_enu_m for person in scene.persons])
    assert np.all(np.abs(places[:, 0]) <= 8)
    assert np.all((places[:, 1] >= 8 + 10.8) & (places[:, 1] <= 8 + 22.8))
    assert np.all(places[:, 2] == 0)
    distance = np.linalg.norm(places[:, None, :2] - scene.forest.trunk_enu_m[None], axis=2)
    assert distance.min() >= 2.0
    assert len({person.name for person in scene.persons}) == 20
    for person in scene.persons:
        assert 24 <= person.clothing_temperature_celsius <= 28
        assert 31 <= person.skin_temperature_celsius <= 33


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("seed", -1),
        ("trees_per_ha", -1.0),
        ("trees_per_ha", float("nan")),
        ("side_m", 5.0),
        ("persons", -1),
        ("stones", 101),
    ],
)
def test_parameters_out_of_range_are_named(field: str, value: float) -> None:
    with pytest.raises(ConfigurationError, match=field):
        SceneParameters(**{field: value})


def test_distractors_change_neither_persons_nor_forest_nor_ground(scene: Scene) -> None:
    busy = build_scene(SceneParameters(seed=4, side_m=40.0, persons=20, animals=2, stones=1, cloths=1))
    np.testing.assert_array_equal(busy.forest.mesh.triangles_enu_m, scene.forest.mesh.triangles_enu_m)
    np.testing.assert_array_equal(busy.ground.forest_tile, scene.ground.forest_tile)
    np.testing.assert_array_equal(busy.persons[-1].position_enu_m, scene.persons[-1].position_enu_m)
    assert [d.kind in {"deer", "boar"} for d in busy.distractors] == [True, True, False, False]
    assert [d.kind for d in busy.distractors[2:]] == ["stone", "cloth"]
    assert scene.distractors == ()


def test_distractors_keep_apart_from_persons_and_trunks_and_one_another() -> None:
    scene = build_scene(SceneParameters(seed=7, side_m=60.0, animals=1, stones=1, cloths=1))
    bodies = np.array([body.position_enu_m[:2] for body in (*scene.persons, *scene.distractors)])
    gaps = np.linalg.norm(bodies[:, None] - bodies[None], axis=2) + 1e3 * np.eye(len(bodies))
    assert gaps.min() >= 8.0
    assert np.linalg.norm(bodies[:, None] - scene.forest.trunk_enu_m[None], axis=2).min() >= 2.0


def test_world_without_persons_can_be_built() -> None:
    scene = build_scene(SceneParameters(side_m=20.0, persons=0, animals=1))
    assert scene.persons == ()
    assert len(scene.distractors) == 1


def test_unknown_posture_is_named_with_the_known_ones() -> None:
    with pytest.raises(ConfigurationError, match=r"standing, sitting, lying.*'flying'"):
        SceneParameters(posture="flying")


def test_ground_repeats_without_a_seam_and_differs_under_trees() -> None:
    ground = make_ground(np.random.default_rng(0), west_m=-50, south_m=8, side_m=100)
    east, north = np.random.default_rng(1).uniform(10, 20, (2, 100))
    tile_m = TILE_CELLS * CELL_M
    np.testing.assert_array_equal(ground.sample(east, north), ground.sample(east + tile_m, north))
    forest, meadow = ground.sample(east, north), ground.sample(east, north - 40)
    assert forest[:, 1].mean() < meadow[:, 1].mean() - 10
    seam = np.abs(ground.forest_tile[0] - ground.forest_tile[-1]).mean(axis=0)
    inside = np.abs(np.diff(ground.forest_tile, axis=0)).mean(axis=(0, 1))
    np.testing.assert_array_less(seam, 1.3 * inside)


def test_walking_persons_keep_clear_of_trunks_and_change_nothing_else(scene: Scene) -> None:
    parameters = replace(scene.parameters, posture=Posture.WALKING, walking_mps=1.2)
    trunks_enu_m = scene.forest.trunk_enu_m[:, :2]
    nearest_m = []
    for walker, stander in zip(build_scene(parameters).persons, scene.persons, strict=True):
        np.testing.assert_array_equal(walker.position_enu_m, stander.position_enu_m)
        assert walker.walk is not None
        assert walker.walk.speed_mps == 1.2
        places_enu_m = np.array([walker.at(at_s).position_enu_m[:2] for at_s in np.arange(0.0, 14.0, 0.5)])
        nearest_m.append(np.linalg.norm(places_enu_m[:, np.newaxis] - trunks_enu_m, axis=2).min())
    assert np.median(nearest_m) > 1.0


def test_only_walking_persons_have_a_speed() -> None:
    with pytest.raises(ConfigurationError, match="walking_mps needs the posture walking, got standing"):
        SceneParameters(walking_mps=1.0)
