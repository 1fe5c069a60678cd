import math
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.walks import Walk
from aos_sim.errors.model import NONE
from aos_sim.errors.wind import Wind
from aos_sim.render import Renderer
from aos_sim.render.lighting import TO_SUN, light_ground
from aos_sim.render.raycaster import RayCaster
from aos_sim.render.renderer import SKY_RGB, SKY_TEMPERATURE_CELSIUS
from aos_sim.render.sway import Sway
from aos_sim.world.distractors import DistractorKind, make_distractor
from aos_sim.world.person import Person, Posture
from aos_sim.world.scene import Scene, SceneParameters, build_scene
from tests.fakes.visibility import person_visibility

CAMERA = CameraModel.from_fov(96, 96, math.radians(50))


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def person_at(east_m: float, north_m: float, height_m: float = 1.75, name: str = "anna") -> Person:
    return Person(name, np.array([east_m, north_m, 0.0]), 0.0, height_m, Posture.STANDING, (200, 40, 40), 32.0, 26.0)


@pytest.fixture(scope="module")
def bare_scene() -> Scene:
    return build_scene(SceneParameters(seed=2, trees_per_ha=0, side_m=30.0))


@pytest.fixture(scope="module")
def bare(bare_scene: Scene) -> Renderer:
    return Renderer(bare_scene)


@pytest.fixture(scope="module")
def forest() -> Renderer:
    return Renderer(build_scene(SceneParameters(seed=2, side_m=30.0)))


def above(renderer: Renderer, east_m: float = 0.0, north_m: float = 0.0, height_m: float = 35.0) -> Pose:
    return nadir_pose(renderer.scene.persons[0].position_enu_m + np.array([east_m, north_m, height_m]))


# --- geometry -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("heading_rad", [0.0, 0.8, math.pi / 2, -2.5])
@pytest.mark.parametrize("offset_m", [(0.0, 0.0), (4.0, 0.0), (-1.5, 3.0)])
def test_person_appears_where_the_camera_model_says(
    bare: Renderer, heading_rad: float, offset_m: tuple[float, float]
) -> None:
    camera = CameraModel.from_fov(300, 256, math.radians(50))
    middle = np.array([1.0, 20.0, 0.3])
    pose = nadir_pose(middle + np.array([*offset_m, 12.0]), heading_rad)
    small = bare.with_persons([person_at(1.0, 20.0, height_m=0.6)])
    rows, columns = np.nonzero(small.person_masks(pose, camera).unoccluded)
    homogeneous = camera.K @ pose.R_cam2enu.T @ (middle - pose.position_enu_m)
    u, v = homogeneous[:2] / homogeneous[2]
    assert (columns.min() + columns.max()) / 2 == pytest.approx(u, abs=1.0)
    assert (rows.min() + rows.max()) / 2 == pytest.approx(v, abs=1.0)


def test_heat_of_a_person_in_the_north_is_in_the_upper_half(bare: Renderer) -> None:
    frame = bare.with_persons([person_at(0.0, 24.0)]).render(nadir_pose([0, 20, 15]), CAMERA, rng())
    row, column = np.unravel_index(int(frame.thermal_celsius.argmax()), frame.thermal_celsius.shape)
    assert row < 30
    assert abs(column - 47.5) < 4


def test_ground_texture_belongs_to_the_world_and_not_to_the_view(bare: Renderer) -> None:
    shift_px = 7
    metres = shift_px * 20.0 / CAMERA.fx_px
    west = bare.render(nadir_pose([0.0, -5.0, 20.0]), CAMERA, rng(1)).rgb.astype(int)
    east = bare.render(nadir_pose([metres, -5.0, 20.0]), CAMERA, rng(2)).rgb.astype(int)
    turned = bare.render(nadir_pose([0.0, -5.0, 20.0], math.pi), CAMERA, rng(3)).rgb.astype(int)
    for other, reference in ((east[:, :-shift_px], west[:, shift_px:]), (turned[::-1, ::-1], west)):
        difference = other - reference
        assert np.median(np.abs(difference)) <= 3
        assert np.corrcoef(other.ravel(), reference.ravel())[0, 1] > 0.9
    assert np.corrcoef(turned.ravel(), west.ravel())[0, 1] < np.corrcoef(turned[::-1, ::-1].ravel(), west.ravel())[0, 1]


def test_looking_up_shows_the_sky(bare: Renderer) -> None:
    frame = bare.render(Pose(np.array([0.0, 20.0, 10.0]), np.eye(3)), CAMERA, rng())
    np.testing.assert_allclose(frame.rgb.mean(axis=(0, 1)), SKY_RGB, atol=0.5)
    assert frame.thermal_celsius.mean() == pytest.approx(SKY_TEMPERATURE_CELSIUS, abs=0.05)


def test_horizon_divides_sky_and_ground(bare: Renderer) -> None:
    north = Pose(np.array([0.0, -10.0, 10.0]), np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]))
    thermal = bare.with_persons([]).render(north, CAMERA, rng()).thermal_celsius
    assert thermal[:47].max() < SKY_TEMPERATURE_CELSIUS + 1
    assert thermal[49:].min() > 5


def test_shadow_falls_away_from_the_sun(bare_scene: Scene) -> None:
    square = np.array([[-1, -1, 10], [1, -1, 10], [1, 1, 10], [-1, 1, 10]], np.float32) + np.float32([0, 20, 0])
    ground = light_ground(bare_scene, RayCaster(square[[[0, 1, 2], [0, 2, 3]]]))
    centre = np.array([0.0, 20.0]) - 10 * TO_SUN[:2] / TO_SUN[2]
    east, north = (np.ravel(axis) for axis in np.meshgrid(np.linspace(-15, 15, 151), np.linspace(5, 35, 151)))
    samples, lit = ground.sample(east, north), bare_scene.ground.sample(east, north)
    is_shaded = samples[:, 3] == lit[:, 3]
    np.testing.assert_allclose([east[is_shaded].mean(), north[is_shaded].mean()], centre, atol=0.15)
    assert np.count_nonzero(is_shaded) * 0.2**2 == pytest.approx(4.0, rel=0.15)


# --- visibility -----------------------------------------------------------------------------------------------------


def test_visibility_without_forest_is_one(bare: Renderer) -> None:
    assert person_visibility(bare, above(bare, 5, 5), CAMERA) == 1.0


def test_visibility_out_of_view_is_none(bare: Renderer) -> None:
    assert person_visibility(bare, above(bare, 100), CAMERA) is None
    assert person_visibility(bare.with_persons([]), above(bare), CAMERA) is None


def test_forest_hides_a_part_of_the_person() -> None:
    """The mean over views is 0.15-0.20 (benchmarks/bench_render.py); this sample is small, hence the wide band."""
    camera = CameraModel.from_fov(512, 512, math.radians(50))
    shares = []
    for seed in range(1, 7):
        renderer = Renderer(build_scene(SceneParameters(seed=seed, side_m=25.0)))
        angles = rng(seed).uniform(0, 2 * math.pi, 8)
        views = [above(renderer, 8 * math.cos(a), 8 * math.sin(a), 39.5) for a in angles]
        shares += [person_visibility(renderer, view, camera) for view in views]
    assert 0.0 <= min(shares) < max(shares) <= 1.0
    assert 0.08 < np.mean(shares) < 0.32


def test_masks_agree_with_the_image(forest: Renderer) -> None:
    camera = CameraModel.from_fov(256, 256, math.radians(20))
    seen = 0
    for angle in np.linspace(0, 2 * math.pi, 8, endpoint=False):
        pose = above(forest, 6 * math.cos(angle), 6 * math.sin(angle))
        masks = forest.person_masks(pose, camera)
        thermal = forest.render(pose, camera, rng()).thermal_celsius
        assert not np.any(masks.visible & ~masks.unoccluded)
        np.testing.assert_array_equal(thermal > 20, masks.visible)
        seen += np.count_nonzero(masks.visible)
    assert seen > 0


def test_person_behind_another_one_is_hidden_whatever_their_order(bare: Renderer) -> None:
    pose = Pose(np.array([0.0, 0.0, 0.9]), np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]))
    near, far = person_at(0, 6, name="near"), person_at(0, 9, 1.0, name="far")
    for order in ([near, far], [far, near]):
        both = bare.with_persons(order)
        assert person_visibility(both, pose, CAMERA, "near") == 1.0
        alone = np.count_nonzero(bare.with_persons([far]).person_masks(pose, CAMERA).unoccluded)
        assert np.count_nonzero(both.person_masks(pose, CAMERA, "far").visible) < alone


def test_masks_by_name_add_up_and_unknown_names_are_refused(bare: Renderer) -> None:
    pair = bare.with_persons([person_at(-3, 20, name="anna"), person_at(3, 20, name="ben")])
    pose = nadir_pose([0, 20, 20])
    anna, ben, both = (pair.person_masks(pose, CAMERA, name).visible for name in ("anna", "ben", None))
    assert np.nonzero(anna)[1].max() < 48 <= np.nonzero(ben)[1].min()
    np.testing.assert_array_equal(anna | ben, both)
    with pytest.raises(KeyError, match="carl"):
        pair.person_masks(pose, CAMERA, "carl")


def test_distractors_are_seen_but_are_no_persons(bare_scene: Scene) -> None:
    stone = make_distractor(rng(1), DistractorKind.STONE, np.array([3.0, 20.0, 0.0]))
    renderer = Renderer(replace(bare_scene, persons=(person_at(-3, 20),), distractors=(stone,)))
    pose = nadir_pose([0, 20, 15])
    masks = renderer.person_masks(pose, CAMERA)
    warm = renderer.render(pose, CAMERA, rng()).thermal_celsius > stone.temperature_celsius - 1.0
    assert np.nonzero(masks.unoccluded)[1].max() < 48
    assert np.nonzero(warm)[1].max() > 48


def covered_area_m2(renderer: Renderer, pose: Pose, camera: CameraModel) -> float:
    pixel_m = pose.position_enu_m[2] / camera.fx_px
    return np.count_nonzero(renderer.person_masks(pose, camera).unoccluded) * pixel_m**2


def test_unoccluded_area_of_a_lying_person_from_far_above_is_that_of_the_body(bare: Renderer) -> None:
    camera = CameraModel.from_fov(128, 128, math.radians(2))
    lying = bare.with_persons([replace(person_at(0, 20), posture=Posture.LYING)])
    area = covered_area_m2(lying, nadir_pose([0, 20, 200]), camera)
    assert 0.4 < area < 0.9
    assert area == pytest.approx(covered_area_m2(lying, nadir_pose([0.5, 20, 150]), camera), rel=0.05)


# --- appearance -----------------------------------------------------------------------------------------------------


def test_temperatures_are_within_their_bands(forest: Renderer, bare: Renderer) -> None:
    margin = 5 * NONE.thermal.netd_k
    canopy = forest.with_persons([]).render(above(forest), CAMERA, rng()).thermal_celsius
    assert 8 - margin < canopy.min() < canopy.max() < 14 + margin
    pose = above(bare, height_m=10)
    thermal, mask = bare.render(pose, CAMERA, rng()).thermal_celsius, bare.person_masks(pose, CAMERA).visible
    assert 24 - margin < thermal[mask].min() < thermal[mask].max() < 33 + margin
    assert thermal[~mask].max() < 14 + margin


def test_leaves_are_green(forest: Renderer) -> None:
    red, green, blue = forest.render(above(forest), CAMERA, rng()).rgb.reshape(-1, 3).mean(axis=0)
    assert green > red > blue


def test_equal_generators_give_equal_frames_and_others_do_not(forest: Renderer) -> None:
    first, same, other = (forest.render(above(forest), CAMERA, rng(seed)) for seed in (7, 7, 8))
    np.testing.assert_array_equal(first.rgb, same.rgb)
    np.testing.assert_array_equal(first.thermal_celsius, same.thermal_celsius)
    assert not np.array_equal(first.thermal_celsius, other.thermal_celsius)


def test_noise_has_the_sensors_deviation(bare: Renderer) -> None:
    first, second = (bare.render(above(bare), CAMERA, rng(seed)) for seed in (1, 2))
    thermal = (first.thermal_celsius - second.thermal_celsius).std() / math.sqrt(2)
    colour = (first.rgb.astype(float) - second.rgb).std() / math.sqrt(2)
    assert thermal == pytest.approx(NONE.thermal.netd_k, rel=0.05)
    assert colour == pytest.approx(NONE.optics.colour_noise, rel=0.05)


def test_frame_has_the_shape_and_types_of_the_camera(bare: Renderer) -> None:
    frame = bare.render(above(bare), CameraModel.from_fov(40, 30, 1.0), rng())
    assert (frame.rgb.shape, frame.rgb.dtype) == ((30, 40, 3), np.uint8)
    assert (frame.thermal_celsius.shape, frame.thermal_celsius.dtype) == ((30, 40), np.float32)


def test_thinned_backdrop_repeats_pixels_but_shows_bodies_in_full(forest: Renderer) -> None:
    camera = CameraModel.from_fov(101, 96, math.radians(25))
    pose = above(forest, 6.0)
    full, thinned = (forest.render(pose, camera, rng(), stride).thermal_celsius for stride in (1, 2))
    np.testing.assert_array_equal(full[::2, ::2], thinned[::2, ::2])
    is_warm = full > 20.0
    np.testing.assert_array_equal(thinned > 20.0, is_warm)
    np.testing.assert_array_equal(full[is_warm], thinned[is_warm])
    assert not np.array_equal(full, thinned)


def test_number_of_threads_does_not_change_the_frames(forest: Renderer) -> None:
    poses = [above(forest, east) for east in range(4)]
    alone = [forest.render(pose, CAMERA, own) for pose, own in zip(poses, rng(3).spawn(4), strict=True)]
    with ThreadPoolExecutor(4) as pool:
        shared = pool.map(lambda pose, own: forest.render(pose, CAMERA, own), poses, rng(3).spawn(4))
    for one, other in zip(alone, shared, strict=True):
        np.testing.assert_array_equal(one.rgb, other.rgb)
        np.testing.assert_array_equal(one.thermal_celsius, other.thermal_celsius)


def test_partly_visible_person_stands_out_of_the_forest(forest: Renderer) -> None:
    """Mahalanobis distance over red, green, blue and thermal, as in the anomaly detector."""
    camera = CameraModel.from_fov(256, 256, math.radians(25))
    pose = max(
        (above(forest, 6 * math.cos(a), 6 * math.sin(a)) for a in np.linspace(0, 6, 8)),
        key=lambda view: np.count_nonzero(forest.person_masks(view, camera).visible),
    )
    visible = forest.person_masks(pose, camera).visible.ravel()
    frame = forest.render(pose, camera, rng())
    pixels = np.column_stack([frame.rgb.reshape(-1, 3), frame.thermal_celsius.ravel()]).astype(float)
    centred = pixels - pixels.mean(axis=0)
    score = np.einsum("ij,jk,ik->i", centred, np.linalg.inv(np.cov(centred.T)), centred)
    assert np.count_nonzero(visible) >= 8
    assert np.median(score[visible]) > 3 * np.quantile(score[~visible], 0.9998)


def test_missing_embreex_says_what_to_install(bare_scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "embreex.mesh_construction", None)
    with pytest.raises(ConfigurationError, match=r"install aos-gcs\[sim\]"):
        Renderer(bare_scene)


# --- wind -----------------------------------------------------------------------------------------------------------


def test_wind_moves_trees_between_moments_and_nothing_else() -> None:
    scene = build_scene(SceneParameters(seed=2, side_m=30.0))
    windy = Renderer(scene, wind=Wind(6.0))
    pose = above(windy)
    first, same, later = (windy.view(pose, CAMERA, at_s) for at_s in (3.1, 3.4, 8.0))
    np.testing.assert_array_equal(first, same)
    changed = np.mean(np.any(first != later, axis=-1))
    assert 0.2 < changed < 0.95
    # What is seen of the person differs, but not where it stands.
    bodies = [windy.person_masks(pose, CAMERA) for _ in range(2)]
    np.testing.assert_array_equal(bodies[0].unoccluded, bodies[1].unoccluded)
    bare_ground = Renderer(build_scene(SceneParameters(seed=2, trees_per_ha=0, side_m=30.0)), wind=Wind(6.0))
    np.testing.assert_array_equal(bare_ground.view(pose, CAMERA, 3.1), bare_ground.view(pose, CAMERA, 8.0))


def test_a_walking_person_is_seen_where_it_is_at_that_moment(bare_scene: Scene) -> None:
    start = person_at(0.0, 20.0)
    walker = replace(start, posture=Posture.WALKING, walk=Walk(1.0, 8.0, heading_rad=math.pi / 2))
    walking = Renderer(replace(bare_scene, persons=(walker,)))
    pose = above(walking)
    for at_s, east_m, heading_rad in ((0.0, 0.0, math.pi / 2), (3.0, 3.0, math.pi / 2), (6.0, 2.0, 1.5 * math.pi)):
        there = replace(walker, walk=None, position_enu_m=np.array([east_m, 20.0, 0.0]), heading_rad=heading_rad)
        still = Renderer(replace(bare_scene, persons=(there,)))
        np.testing.assert_allclose(walking.view(pose, CAMERA, at_s), still.view(pose, CAMERA, at_s), atol=1e-3)


def test_still_air_leaves_every_moment_alike(forest: Renderer) -> None:
    np.testing.assert_array_equal(forest.view(above(forest), CAMERA, 0.0), forest.view(above(forest), CAMERA, 99.0))


def test_sway_moves_the_canopy_by_its_deviation() -> None:
    down = np.tile(np.array([[0.0, 0.0, -1.0]], np.float32), (4000, 1))
    spread = rng(4).uniform(-0.4, 0.4, (4000, 2)).astype(np.float32)
    down[:, :2] = spread
    origin_m = np.array([0.0, 0.0, 36.0])
    origins, directions = Sway(Wind(10.0, crown_s=0.02, leaf_s=0.01), 1).shear(origin_m, down, 0.0)
    # Where the rays meet the ground nothing moves; at the top of the canopy, half way, they are off by the sway.
    np.testing.assert_allclose(origins + 36.0 * directions, origin_m + 36.0 * down, atol=1e-4)
    off_m = (origins + 18.0 * directions) - (origin_m + 18.0 * down)
    assert off_m[:, 0].std() == pytest.approx(np.hypot(0.2, 0.1), rel=0.25)
    assert not off_m[:, 2].any()
