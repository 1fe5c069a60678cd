"""Images of ground that is not level: rays meet it where geometry says, and level worlds look as ever."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_sim.camera.synthetic import CheckerboardGround
from aos_sim.errors.wind import Wind
from aos_sim.render import Renderer
from aos_sim.render.ground_rays import GroundRays
from aos_sim.render.lighting import TO_SUN
from aos_sim.render.rays import ray_directions
from aos_sim.render.renderer import SKY_TEMPERATURE_CELSIUS
from aos_sim.truth import unoccluded_areas_m2
from aos_sim.world.mesh import Material
from aos_sim.world.person import person_mesh
from aos_sim.world.relief import Relief
from aos_sim.world.scene import Scene, SceneParameters, build_scene
from aos_sim.world.terrain import make_relief

CAMERA = CameraModel.from_fov(128, 96, math.radians(50))
BARE = SceneParameters(seed=2, trees_per_ha=0, side_m=30.0)
LEVEL = Relief(np.zeros((2, 2)), west_m=-50.0, south_m=-50.0, cell_m=100.0)


def steep(percent: float = 20.0) -> Scene:
    return build_scene(replace(BARE, terrain=f"slope:{percent:g}"))


def pixel(point_enu_m: np.ndarray, pose: Pose, camera: CameraModel = CAMERA) -> np.ndarray:
    homogeneous = camera.K @ pose.R_cam2enu.T @ (point_enu_m - pose.position_enu_m)
    return homogeneous[:2] / homogeneous[2]


@pytest.mark.parametrize("offset_m", [(0.0, 0.0), (7.0, -5.0), (-8.0, 4.0)])
def test_a_vertical_camera_sees_a_person_on_a_slope_where_projection_says(offset_m: tuple[float, float]) -> None:
    scene = steep(40.0)
    person = scene.persons[0]
    assert person.position_enu_m[2] > 3.0
    pose = nadir_pose(np.array([*person.position_enu_m[:2] + offset_m, 30.0]), 0.3)
    fine = CameraModel.from_fov(600, 512, math.radians(50))
    visible = Renderer(scene).person_masks(pose, fine).visible
    points = scene.draped(person_mesh(person), person.position_enu_m).triangles_enu_m.reshape(-1, 3)
    places = np.array([pixel(point, pose, fine) for point in points])
    rows, columns = np.nonzero(visible)
    assert [columns.min(), columns.max()] == pytest.approx([places[:, 0].min(), places[:, 0].max()], abs=2.0)
    assert [rows.min(), rows.max()] == pytest.approx([places[:, 1].min(), places[:, 1].max()], abs=2.0)


@pytest.mark.parametrize("seed", range(1, 6))
def test_a_person_seen_once_on_a_slope_is_located_on_the_terrain_and_missed_on_a_level_plane(seed: int) -> None:
    scene = build_scene(SceneParameters(seed=seed, trees_per_ha=0, side_m=60.0, terrain="slope:20"))
    place_enu_m = scene.persons[0].position_enu_m
    pose = nadir_pose(np.array([place_enu_m[0] + 9.0, place_enu_m[1] - 7.0, 47.0]))
    rows, columns = np.nonzero(Renderer(scene).person_masks(pose, CAMERA).visible)
    u, v = columns.mean(), rows.mean()
    sight = pose.R_cam2enu @ [(u - CAMERA.cx_px) / CAMERA.fx_px, (v - CAMERA.cy_px) / CAMERA.fy_px, 1.0]
    assert scene.relief is not None
    on_plane, on_terrain = (
        pose.position_enu_m + reach * sight
        for reach in (-pose.position_enu_m[2] / sight[2], scene.relief.reach(pose.position_enu_m, sight))
    )
    assert np.linalg.norm((on_plane - place_enu_m)[:2]) > 0.9
    assert np.linalg.norm((on_terrain - place_enu_m)[:2]) < 0.5


@pytest.mark.parametrize("terrain", ["slope:20", "slope:-35", "hills"])
def test_rays_meet_the_ground_where_it_is(terrain: str) -> None:
    relief = make_relief(terrain, 5, (-50.0, -20.0, 50.0, 108.0), level_north_m=8.0, origin=None)
    assert relief is not None
    pose = nadir_pose(np.array([5.0, 70.0, 90.0]), 1.0)
    directions = ray_directions(pose, CAMERA)
    for rays in (GroundRays(relief), relief):
        reach = rays.reach(pose.position_enu_m, directions)
        points = pose.position_enu_m + reach[:, np.newaxis] * directions
        np.testing.assert_allclose(points[:, 2], relief.height_m(points[:, 0], points[:, 1]), atol=2e-3)
    assert np.isinf(relief.reach(pose.position_enu_m, -directions)).all()


def test_the_hill_before_hides_what_is_behind() -> None:
    ridge = np.zeros((60, 60))
    ridge[20:24] = 15.0
    scene = replace(steep(), relief=Relief(ridge, -60.0, -60.0, 2.0))
    person = replace(scene.persons[0], position_enu_m=np.array([0.0, 20.0, 0.0]))
    renderer = Renderer(replace(scene, persons=(person,)))
    low = Pose(np.array([0.0, -40.0, 10.0]), np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]))
    high = nadir_pose(np.array([0.0, 20.0, 30.0]))
    assert not renderer.person_masks(low, CAMERA).visible.any()
    assert renderer.person_masks(low, CAMERA).unoccluded.any()
    assert renderer.person_masks(high, CAMERA).visible.any()


def test_texture_lies_on_the_slope() -> None:
    scene = steep()
    relief, renderer = scene.relief, Renderer(replace(scene, persons=()))
    assert relief is not None
    place = np.array([2.0, 30.0])
    height_m = float(relief.height_m(*place))
    pose = nadir_pose(np.array([-4.0, 24.0, 35.0]))
    colours = renderer.view(pose, CAMERA, 0.0)
    directions = ray_directions(pose, CAMERA)
    reach = (0.2 * (24.0 - 8.0) - 35.0) / (directions[:, 2] - 0.2 * directions[:, 1])
    points = pose.position_enu_m + reach[:, np.newaxis] * directions
    beside = points[:, 1] > 8.1
    wanted = scene.ground.sample(points[beside, 0], points[beside, 1])
    shown = colours.reshape(-1, 4)[beside]
    light = 0.9 * 0.45 + 0.75 * (np.array([0.0, -0.2, 1.0]) / math.hypot(0.2, 1.0)) @ TO_SUN
    # Rounding may move a ray to the next cell of the texture.
    assert (np.abs(shown[:, :3] - light * wanted[:, :3]).max(axis=1) < 0.1).mean() > 0.99
    assert height_m == pytest.approx(4.4)
    assert shown[:, 3].min() > SKY_TEMPERATURE_CELSIUS + 10.0


def test_shadows_of_trees_lie_on_the_slope() -> None:
    """A square above a slope darkens the ground where the sun's rays through its corners meet it."""
    from aos_sim.render.lighting import light_ground  # noqa: PLC0415
    from aos_sim.render.raycaster import RayCaster  # noqa: PLC0415

    scene = steep()
    middle = np.array([0.0, 25.0, 12.0])
    square = (np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) + middle).astype(np.float32)
    lit = light_ground(scene, RayCaster(square[[[0, 1, 2], [0, 2, 3]]]))
    along = (12.0 - 0.2 * (25.0 - 8.0)) / (TO_SUN[2] - 0.2 * TO_SUN[1])
    shadow = middle - along * TO_SUN
    east, north = (axis.ravel() for axis in np.meshgrid(np.linspace(-14, 14, 141), np.linspace(10, 40, 151)))
    dark = lit.sample(east, north)[:, 3] == scene.ground.sample(east, north)[:, 3]
    np.testing.assert_allclose([east[dark].mean(), north[dark].mean()], shadow[:2], atol=0.15)


def test_a_level_relief_looks_like_the_flat_world() -> None:
    """The way of relief and that of flat worlds agree, trees that sway in the wind included."""
    flat = build_scene(replace(BARE, trees_per_ha=200.0, side_m=20.0))
    wind, pose = Wind(4.0), nadir_pose(np.array([1.0, 18.0, 35.0]), 0.4)
    as_ever = Renderer(flat, wind=wind).view(pose, CAMERA, 3.0)
    level = Renderer(replace(flat, relief=LEVEL), wind=wind).view(pose, CAMERA, 3.0)
    # Cells of shadows begin elsewhere.
    assert (np.abs(as_ever - level).max(axis=2) < 0.01).mean() > 0.97


def test_trees_on_a_slope_sway_as_far_as_those_in_the_plain() -> None:
    """A plateau 40 m up looks from 40 m higher as the plain does."""
    flat = build_scene(replace(BARE, trees_per_ha=200.0, side_m=20.0))
    plateau = Relief(np.full((2, 2), 40.0), west_m=-50.0, south_m=-50.0, cell_m=100.0)
    up = np.array([0.0, 0.0, 40.0])
    persons = tuple(replace(person, position_enu_m=person.position_enu_m + up) for person in flat.persons)
    raised = replace(flat, relief=plateau, forest=flat.forest.on(plateau), persons=persons)
    pose = nadir_pose(np.array([1.0, 18.0, 35.0]))
    below = Renderer(flat, wind=Wind(6.0)).view(pose, CAMERA, 3.0)
    above = Renderer(raised, wind=Wind(6.0)).view(Pose(pose.position_enu_m + up, pose.R_cam2enu), CAMERA, 3.0)
    assert (np.abs(above - below).max(axis=2) < 1.0).mean() > 0.98
    still = Renderer(flat).view(pose, CAMERA, 3.0)
    assert (np.abs(still - below).max(axis=2) < 1.0).mean() < 0.9


def test_the_chequered_ground_follows_the_relief() -> None:
    scene = steep()
    pose = nadir_pose(np.array([0.0, 30.0, 25.0]))
    plain, sloping = (CheckerboardGround(relief).view(pose, CAMERA, 0.0) for relief in (None, scene.relief))
    level = CheckerboardGround(LEVEL).view(pose, CAMERA, 0.0)
    np.testing.assert_array_equal(plain[:-1, :-1], level[:-1, :-1])
    tile_east, tile_north = 3.0, 33.0
    column, row = np.rint(pixel(np.array([tile_east, tile_north, 5.0]), pose)).astype(int)
    # The tile is warm: the sum of its numbers, 1 and 16, is odd.
    assert sloping[row, column, 3] > 17.0
    assert (plain != sloping).any()


def test_the_truth_counts_a_person_on_a_slope_from_where_it_is() -> None:
    world = {"seed": 2, "trees_per_ha": 0.0}
    place_enu_m = build_scene(SceneParameters(**world)).persons[0].position_enu_m
    pose = nadir_pose(place_enu_m + np.array([2.0, 1.0, 35.0]))
    (flat_m2,) = unoccluded_areas_m2(world, [[(pose, CAMERA)]])
    (raised_m2,) = unoccluded_areas_m2(world | {"terrain": "slope:20"}, [[(pose, CAMERA)]])
    height_m = float(build_scene(SceneParameters(**world, terrain="slope:20")).persons[0].position_enu_m[2])
    assert height_m > 5.0
    # Nearer to the camera, it covers more of the focal plane.
    assert raised_m2 == pytest.approx(flat_m2 * (35.0 / (35.0 - height_m)) ** 2, rel=0.1)


def test_leaves_are_met_before_the_ground_behind_them() -> None:
    scene = build_scene(replace(BARE, trees_per_ha=400.0, side_m=20.0, terrain="slope:30", persons=0))
    thermal = Renderer(scene).view(nadir_pose(np.array([0.0, 18.0, 45.0])), CAMERA, 0.0)
    flat = Renderer(build_scene(replace(BARE, trees_per_ha=400.0, side_m=20.0, persons=0))).view(
        nadir_pose(np.array([0.0, 18.0, 42.0])), CAMERA, 0.0
    )
    assert scene.forest.mesh.material[0] == Material.LEAF
    shares = [(np.abs(image[..., 1] - image[..., 0]) > 15.0).mean() for image in (thermal, flat)]
    assert shares[0] == pytest.approx(shares[1], abs=0.1)
