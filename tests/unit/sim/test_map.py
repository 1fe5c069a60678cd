"""The base map of a simulated forest."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pmtiles")

from aos_gcs.api.basemap_file import check_basemap
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_sim.map_picture import CELL_M, draw_map, forest_picture
from aos_sim.world.scene import Scene, SceneParameters, build_scene
from tests.fakes.map_files import LATITUDE_DEG, LONGITUDE_DEG, ShownMap

ORIGIN = GeodeticPosition(LATITUDE_DEG, LONGITUDE_DEG, 500.0)
LOW_M, HIGH_M = np.array([-40.0, -40.0]), np.array([40.0, 60.0])


@pytest.fixture(scope="module")
def scene() -> Scene:
    return build_scene(SceneParameters(trees_per_ha=60.0, side_m=40.0), ORIGIN)


def pixel(picture: np.ndarray, east_m: float, north_m: float) -> np.ndarray:
    return picture[int((HIGH_M[1] - north_m) / CELL_M), int((east_m - LOW_M[0]) / CELL_M)]


def test_crowns_stand_where_the_trees_are_and_nothing_else_does(scene: Scene) -> None:
    picture = forest_picture(scene, LOW_M, HIGH_M)
    bare = forest_picture(build_scene(SceneParameters(trees_per_ha=0.0, side_m=40.0), ORIGIN), LOW_M, HIGH_M)
    assert picture.shape == (400, 320, 4)
    assert (picture[..., 3] == 255).all()
    for (east_m, north_m), radius_m in zip(scene.forest.trunk_enu_m, scene.forest.crown_radius_m, strict=True):
        assert (pixel(picture, east_m, north_m) != pixel(bare, east_m, north_m)).any()
        assert radius_m > CELL_M
    changed = (picture != bare).any(axis=-1).mean()
    crowns = np.pi * float((scene.forest.crown_radius_m**2).sum()) / 8000.0
    assert 0.5 * crowns < changed < 1.8 * crowns
    assert (forest_picture(scene, LOW_M, HIGH_M) == picture).all(), "the same world has the same map"


def test_slopes_away_from_the_light_are_darker() -> None:
    def brightness(terrain: str) -> float:
        bare = SceneParameters(trees_per_ha=0.0, side_m=40.0, terrain=terrain)
        return float(forest_picture(build_scene(bare, ORIGIN), LOW_M, HIGH_M)[..., :3].mean())

    assert brightness("slope:40") < 0.85 * brightness("flat")


def test_the_archive_shows_the_picture_at_its_place(tmp_path: Path, scene: Scene) -> None:
    draw_map(tmp_path / "map.pmtiles", scene, ORIGIN)
    check_basemap(tmp_path / "map.pmtiles")
    shown = ShownMap(tmp_path / "map.pmtiles")
    picture = forest_picture(scene, LOW_M, HIGH_M)
    tallest = int(np.argmax(scene.forest.height_m))
    east_m, north_m = scene.forest.trunk_enu_m[tallest]
    seen = np.array(shown.colour(east_m, north_m)[:3], dtype=float)
    assert seen == pytest.approx(pixel(picture, east_m, north_m)[:3].astype(float), abs=25.0)
    assert shown.colour(east_m, 400.0)[3] == 0
    assert (tmp_path / "map.pmtiles").stat().st_size < 2_000_000
