"""The laboratory's world: what cameras see of the target, with and without the forest."""

import math

import numpy as np
import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.groundmap.detection import Posture
from aos_gcs.lab.worlds import Target, World, WorldParameters, build_world
from aos_sim.lab_world import build_lab_world

CAMERA = CameraModel.from_fov(512, 512, math.radians(50.0))
TARGET = Target((0.0, 30.0))


@pytest.fixture(scope="module")
def forest() -> World:
    return build_world(WorldParameters(seed=3, side_m=40.0))


@pytest.fixture(scope="module")
def meadow() -> World:
    return build_world(WorldParameters(seed=3, trees_per_ha=0.0, side_m=40.0))


def above(*offsets_m: tuple[float, float], height_m: float = 35.0) -> list[Pose]:
    east_m, north_m = TARGET.position_enu_m
    return [nadir_pose([east_m + x, north_m + y, height_m]) for x, y in offsets_m]


def test_without_trees_everything_is_seen(meadow: World) -> None:
    views = meadow.view_target(above((0, 0), (5, -3)), CAMERA, TARGET)
    assert views.unoccluded.any(axis=(1, 2)).all()
    assert np.array_equal(views.seen, views.unoccluded)


def test_the_forest_hides_a_part(forest: World) -> None:
    rng = np.random.default_rng(0)
    views = forest.view_target(above(*rng.uniform(-12, 12, (40, 2))), CAMERA, TARGET)
    assert not (views.seen & ~views.unoccluded).any()
    assert 0.02 < views.seen.sum() / views.unoccluded.sum() < 0.5


def test_a_standing_person_hides_the_ground_behind_it(meadow: World) -> None:
    west_view = meadow.view_target(above((-10, 0)), CAMERA, TARGET)
    _, columns = np.nonzero(west_view.unoccluded[0])
    east_m = west_view.west_m + (columns + 0.5) * west_view.resolution_m - TARGET.position_enu_m[0]
    # The head at 1.75 m, seen from 10 m aside and 35 m up, lies 10 * 1.75 / (35 - 1.75) m behind the feet.
    assert east_m.max() == pytest.approx(10 * 1.75 / 33.25, abs=0.15)
    assert east_m.min() > -0.4


def test_a_view_ends_at_the_edge_of_the_image(meadow: World) -> None:
    reach_m = 35.0 * math.tan(math.radians(25.0))
    views = meadow.view_target(above((0, 0), (reach_m - 2, 0), (reach_m + 2, 0), (reach_m, 0)), CAMERA, TARGET)
    whole, near, outside, cut = views.unoccluded.sum(axis=(1, 2))
    assert whole > 0
    assert near > 0
    assert outside == 0
    assert 0 < cut < near


def test_the_raster_stays_where_the_target_stays_and_follows_it_by_whole_cells(meadow: World) -> None:
    first = meadow.view_target(above((0, 0)), CAMERA, TARGET)
    again = meadow.view_target(above((3, 2)), CAMERA, TARGET)
    moved = meadow.view_target(above((0, 0)), CAMERA, Target((1.03, 30.0)))
    assert (first.west_m, first.north_m) == (again.west_m, again.north_m)
    assert (moved.west_m - first.west_m) / first.resolution_m == pytest.approx(20, abs=1e-6)


@pytest.mark.parametrize(
    ("posture", "area_m2"), [(Posture.STANDING, 0.15), (Posture.SITTING, 0.3), (Posture.LYING, 0.6)]
)
def test_area_from_above_by_posture(meadow: World, posture: Posture, area_m2: float) -> None:
    target = Target(TARGET.position_enu_m, 0.7, posture)
    views = meadow.view_target(above((0, 0)), CAMERA, target)
    assert views.unoccluded.sum() * views.resolution_m**2 == pytest.approx(area_m2, rel=0.35)


def test_images_show_the_target_where_it_is_said_to_be(meadow: World) -> None:
    rng = np.random.default_rng(1)
    camera = CameraModel.from_fov(128, 128, math.radians(50.0))
    with_target, without = (
        meadow.render(above((0, 0), height_m=12.0), camera, target, rng)[0] for target in (TARGET, None)
    )
    assert with_target.shape == (128, 128, 4)
    assert with_target[62:66, 62:66, 3].max() > 20.0
    assert without[..., 3].max() < 20.0


@pytest.mark.parametrize(("field", "value"), [("terrain", "alps"), ("forest", "palms"), ("trees_per_ha", -1.0)])
def test_refuses_what_it_cannot_build(field: str, value: object) -> None:
    with pytest.raises(ConfigurationError, match=field):
        build_lab_world(WorldParameters(seed=0, **{field: value}))  # type: ignore[arg-type]
