"""The ground of simulated worlds that is not level: its shape, what stands on it, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_sim.world.mesh import Material
from aos_sim.world.person import Posture
from aos_sim.world.relief import Relief
from aos_sim.world.scene import Scene, SceneParameters, build_scene
from aos_sim.world.terrain import HILLS_RELIEF_M, make_relief
from aos_sim.world.terrain_file import write_geotiff
from aos_sim.world_file import read_world_file, write_world_file
from aos_sim.world_options import world_of
from tests.fakes.command_line import exit_status
from tests.fakes.relief import ORIGIN, hill, write_relief

SLOPE = SceneParameters(seed=4, side_m=40.0, trees_per_ha=60.0, persons=5, animals=1, stones=1, terrain="slope:20")
BOX = (-20.0, -20.0, 20.0, 48.0)


@pytest.fixture(scope="module")
def slope() -> Scene:
    return build_scene(SLOPE)


@pytest.fixture(scope="module")
def flat() -> Scene:
    return build_scene(replace(SLOPE, terrain="flat"))


def relief_of(scene: Scene) -> Relief:
    assert scene.relief is not None
    return scene.relief


def hills(seed: int) -> Relief:
    relief = make_relief("hills", seed, BOX, level_north_m=8.0, origin=None)
    assert relief is not None
    return relief


def test_a_slope_begins_at_the_forest_and_rises_by_its_percentage(slope: Scene) -> None:
    relief = relief_of(slope)
    north_m = np.array([-25.0, 0.0, 8.0, 9.0, 33.0, 48.0])
    np.testing.assert_allclose(relief.height_m(3.3, north_m), [0.0, 0.0, 0.0, 0.2, 5.0, 8.0], atol=1e-12)
    np.testing.assert_allclose(relief.normal(3.3, 33.0), np.array([0.0, -0.2, 1.0]) / np.hypot(0.2, 1.0))
    assert relief.gradient(0.0, 1000.0)[1] == 0.0
    assert relief.height_m(0.0, 1000.0) == relief.highest_m


@pytest.mark.parametrize("seed", range(5))
def test_hills_have_their_relief_and_a_level_launch_site(seed: int) -> None:
    relief = hills(seed)
    assert relief.highest_m - relief.lowest_m == pytest.approx(HILLS_RELIEF_M)
    assert HILLS_RELIEF_M >= 60.0
    assert not relief.height_m(*np.meshgrid(np.linspace(-50, 50, 21), np.linspace(-22, 0, 12))).any()
    rise = np.hypot(*relief.gradient(*np.random.default_rng(seed).uniform(-200, 200, (2, 2000))))
    assert rise.max() < 1.0


def test_hills_come_from_their_seed() -> None:
    np.testing.assert_array_equal(hills(1).heights_m, hills(1).heights_m)
    assert not np.allclose(hills(1).heights_m, hills(2).heights_m)


def test_triangles_are_the_ground_that_heights_are_asked_of() -> None:
    relief = hills(3)
    triangles = relief.triangles_enu_m().astype(np.float64)
    weights = np.random.default_rng(0).dirichlet((1.0, 1.0, 1.0), len(triangles))
    points = np.einsum("nc,nca->na", weights, triangles)
    np.testing.assert_allclose(points[:, 2], relief.height_m(points[:, 0], points[:, 1]), atol=1e-3)
    up = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    assert (up[:, 2] > 0.0).all()


def test_everything_stands_on_the_ground_at_the_places_of_the_flat_world(slope: Scene, flat: Scene) -> None:
    relief = relief_of(slope)
    assert flat.relief is None
    for raised, level in zip((*slope.persons, *slope.distractors), (*flat.persons, *flat.distractors), strict=True):
        np.testing.assert_array_equal(raised.position_enu_m[:2], level.position_enu_m[:2])
        assert raised.position_enu_m[2] == relief.height_m(*level.position_enu_m[:2]) > 2.0
        assert level.position_enu_m[2] == 0.0
    mesh, level_mesh = slope.forest.mesh, flat.forest.mesh
    np.testing.assert_array_equal(mesh.albedo_rgb, level_mesh.albedo_rgb)
    lift_m = (mesh.triangles_enu_m - level_mesh.triangles_enu_m)[..., 2]
    trees = len(slope.forest.trunk_enu_m)
    for material, count in ((Material.LEAF, 2400), (Material.BARK, 14)):
        of_trees = lift_m[mesh.material == material][: trees * count].reshape(trees, -1)
        wanted_m = np.broadcast_to(relief.height_m(*slope.forest.trunk_enu_m.T)[:, np.newaxis], of_trees.shape)
        np.testing.assert_allclose(of_trees, wanted_m, atol=1e-5)
    branches = mesh.triangles_enu_m[-64 * trees :].reshape(trees, -1, 3)
    assert np.abs(branches[..., :2].mean(axis=1) - slope.forest.trunk_enu_m).max() < 2.0


def test_walkers_go_up_and_down_the_slope() -> None:
    walking = build_scene(replace(SLOPE, trees_per_ha=0.0, posture=Posture.WALKING, walking_mps=1.0))
    heights_m = []
    for at_s in (0.0, 2.0, 5.0):
        for person in walking.persons_at(at_s):
            assert person.position_enu_m[2] == relief_of(walking).height_m(*person.position_enu_m[:2])
            heights_m.append(person.position_enu_m[2])
    assert np.ptp(heights_m[::5]) > 0.1


def test_a_body_that_lies_follows_the_slope() -> None:
    lying = build_scene(replace(SLOPE, trees_per_ha=0.0, posture=Posture.LYING))
    from aos_sim.world.person import person_mesh  # noqa: PLC0415

    for person in lying.persons:
        points = lying.draped(person_mesh(person), person.position_enu_m).triangles_enu_m.reshape(-1, 3)
        above_m = points[:, 2] - relief_of(lying).height_m(points[:, 0], points[:, 1])
        assert -0.05 < above_m.min() < 0.1
        assert above_m.max() < 0.5


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("mountain", "--terrain must be flat, hills, slope:PERCENT or a GeoTIFF or ASC file"),
        ("slope:", "--terrain slope:PERCENT needs a number"),
        ("slope:abc", "--terrain slope:PERCENT needs a number, such as slope:20, got 'slope:abc'"),
        ("slope:nan", "--terrain slope:PERCENT must lie within -50 and 50"),
        ("slope:51", "--terrain slope:PERCENT must lie within -50 and 50, got 'slope:51'"),
    ],
)
def test_what_is_no_terrain_is_refused(text: str, sentence: str) -> None:
    with pytest.raises(ConfigurationError) as refused:
        SceneParameters(terrain=text)
    assert sentence in str(refused.value)


def test_a_world_file_carries_its_terrain_and_older_ones_are_flat(tmp_path: Path, slope: Scene) -> None:
    path = tmp_path / "world.json"
    write_world_file(path, world_of(slope), ORIGIN, {1: (0.0, 0.0, 0.0)}, 1e9)
    read = replace(SLOPE, side_m=100.0)
    assert read_world_file(path) == (read, ORIGIN)
    text = path.read_text(encoding="utf-8")
    assert f"{slope.persons[0].position_enu_m[2]}" in text
    path.write_text(text.replace(' "terrain": "slope:20",\n', ""), encoding="utf-8")
    assert read_world_file(path)[0] == replace(read, terrain="flat")


class TestFiles:
    """A ground from an elevation model."""

    @pytest.fixture(autouse=True)
    def _needs_rasterio(self) -> None:
        pytest.importorskip("rasterio")

    def parameters(self, path: Path) -> SceneParameters:
        return SceneParameters(side_m=40.0, trees_per_ha=0.0, terrain=str(path))

    def test_its_heights_count_from_the_origin(self, tmp_path: Path) -> None:
        shape = hill(10.0, 30.0, 12.0)
        path = write_relief(tmp_path / "ground.tif", lambda e, n: shape(e, n) + 3.0, origin=ORIGIN, cell=2.0)
        scene = build_scene(self.parameters(path), ORIGIN)
        east, north = np.random.default_rng(1).uniform((-80, -80), (80, 120), (500, 2)).T
        wanted_m = shape(east, north) - shape(np.zeros(1), np.zeros(1))
        np.testing.assert_allclose(relief_of(scene).height_m(east, north), wanted_m, atol=0.05)
        assert relief_of(scene).height_m(0.0, 0.0) == pytest.approx(0.0, abs=0.01)
        assert scene.persons[0].position_enu_m[2] > 1.0

    @pytest.mark.parametrize(
        ("reach_m", "hole", "sentence"),
        [
            (110.0, False, "ends at -120 m east and"),
            (400.0, True, "has a hole at"),
        ],
    )
    def test_a_file_that_ends_or_has_holes_is_refused_with_the_place(
        self, tmp_path: Path, reach_m: float, hole: bool, sentence: str
    ) -> None:
        def ground(east: np.ndarray, north: np.ndarray) -> np.ndarray:
            return np.where(hole & (np.hypot(east - 50.0, north - 50.0) < 8.0), np.nan, 0.0 * east)

        path = write_relief(tmp_path / "ground.tif", ground, origin=ORIGIN, reach_m=reach_m)
        with pytest.raises(ConfigurationError, match=rf"--terrain .*ground\.tif {sentence}"):
            build_scene(self.parameters(path), ORIGIN)

    def test_an_origin_elsewhere_or_at_another_altitude_is_refused(self, tmp_path: Path) -> None:
        path = write_relief(tmp_path / "ground.tif", lambda east, _: 0.0 * east, origin=ORIGIN)
        with pytest.raises(ConfigurationError, match=r"600\.0 m above sea level at the origin, not 260"):
            build_scene(self.parameters(path), replace(ORIGIN, altitude_amsl_m=260.0))
        with pytest.raises(ConfigurationError, match="no height at the origin"):
            build_scene(self.parameters(path), replace(ORIGIN, latitude_deg=10.0))
        with pytest.raises(ConfigurationError, match="give --origin"):
            build_scene(self.parameters(path))

    def test_a_ground_that_was_written_is_the_same_to_a_service_and_to_a_simulator(self, tmp_path: Path) -> None:
        from aos_gcs.elevation.model import ElevationModel, ModelKind  # noqa: PLC0415 - needs the extra

        path, relief = tmp_path / "hills.tif", hills(5)
        write_geotiff(path, relief, ORIGIN)
        model, frame = ElevationModel([path], ModelKind.TERRAIN), LocalFrame(ORIGIN)
        east, north = np.random.default_rng(2).uniform((-110, -110), (110, 140), (40, 2)).T
        up = relief.height_m(east, north)
        places = [frame.to_geodetic(point) for point in np.column_stack([east, north, up])]
        amsl_m = model.heights_amsl_m([p.latitude_deg for p in places], [p.longitude_deg for p in places])
        np.testing.assert_allclose(amsl_m, [place.altitude_amsl_m for place in places], atol=0.05)
        again = make_relief(str(path), 0, BOX, level_north_m=8.0, origin=ORIGIN)
        assert again is not None
        np.testing.assert_allclose(again.height_m(east, north), up, atol=0.02)

    def test_the_command_writes_the_ground_of_its_scene_and_exits(self, tmp_path: Path) -> None:
        path = tmp_path / "slope.tif"
        assert exit_status(["sim", "--terrain", "slope:20", "--terrain-file", str(path), "--terrain-only"]) == 0
        read = make_relief(str(path), 0, BOX, level_north_m=8.0, origin=GeodeticPosition(48.3, 14.3, 260.0))
        assert read is not None
        assert read.height_m(3.0, 58.0) == pytest.approx(10.0, abs=0.02)

    def test_a_file_that_cannot_be_written_is_named(self, tmp_path: Path) -> None:
        with pytest.raises(ConfigurationError, match=r"--terrain-file .*hills\.tif cannot be written"):
            write_geotiff(tmp_path / "none" / "hills.tif", hills(5), ORIGIN)

    def test_a_file_without_coordinate_system_or_none_at_all_is_refused(self, tmp_path: Path) -> None:
        plain = tmp_path / "plain.asc"
        plain.write_text("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n", encoding="ascii")
        with pytest.raises(ConfigurationError, match=r"--terrain .*plain\.asc: .*no coordinate system"):
            build_scene(self.parameters(plain), ORIGIN)
        with pytest.raises(ConfigurationError, match=r"--terrain .*gone\.tif: .*does not exist"):
            build_scene(self.parameters(tmp_path / "gone.tif"), ORIGIN)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["sim", "--terrain", "slope:steep"], "--terrain slope:PERCENT needs a number"),
        (["sim", "--terrain", "gone.tif"], "gone.tif does not exist"),
        (["sim", "--trees-per-ha", "0", "--terrain-file", "t.tif"], "--terrain-file needs ground that is not level"),
        (["sim-camera", "--link", "udpin://127.0.0.1:14540", "--terrain", "gone.tif"], "give --origin"),
    ],
)
def test_commands_refuse_it_with_a_sentence(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert exit_status(arguments) == 2
    error = capsys.readouterr().err
    assert sentence in error
    assert "Traceback" not in error
