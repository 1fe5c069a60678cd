"""The layers of a simulated mission over relief."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("rasterio")

from aos_gcs.config.file import parse_config
from aos_gcs.config.model import ServiceConfig
from aos_gcs.config.settings import mission_settings
from aos_gcs.errors import ConfigurationError
from aos_gcs.runtime.simulated.demo import DemoOptions
from aos_gcs.runtime.simulated.demo_terrain import terrain_tables
from aos_gcs.scripting import ScriptOptions
from tests.fakes.relief import ORIGIN, Relief, hill, terrain, write_relief

MISSION = {
    "vehicles": 4,
    "any_vehicles": True,
    "origin_deg": (ORIGIN.latitude_deg, ORIGIN.longitude_deg, ORIGIN.altitude_amsl_m),
    "area_enu_m": ((-25.0, 8.0), (25.0, 8.0), (25.0, 88.0), (-25.0, 88.0)),
}


def config(**tables: object) -> ServiceConfig:
    return parse_config({"link": {"urls": ["udpin://127.0.0.1:1"]}, "mission": MISSION, **tables}, source="test")


@pytest.mark.parametrize(("relief", "lowest_m"), [(hill(5.0, 40.0, 21.6), 57.0), (hill(5.0, 40.0, -21.6), 35.0)])
def test_layers_are_as_much_higher_as_the_highest_ground_and_the_plan_can_be_flown(
    tmp_path: Path, relief: Relief, lowest_m: float
) -> None:
    tables = terrain_tables(write_relief(tmp_path / "ground.tif", relief, origin=ORIGIN), config())
    settings = mission_settings(config(**tables))
    assert settings.flight.lowest_layer_m == lowest_m
    assert settings.focus_follows_ground


def test_layers_that_follow_the_ground_stay_as_high_above_it_as_usual(tmp_path: Path) -> None:
    file = write_relief(tmp_path / "ground.tif", hill(5.0, 40.0, 21.6), origin=ORIGIN)
    known = config(preflight={"upload_fence": True})
    settings = mission_settings(config(**terrain_tables(file, known, follow=True)))
    assert settings.layers_follow_ground
    assert settings.flight.lowest_layer_m == 35.0
    assert settings.preflight.upload_fence
    assert settings.preflight.overrides.keys() == {"climb of the return"}


def test_layers_over_level_ground_have_nothing_to_follow() -> None:
    with pytest.raises(ConfigurationError, match="--follow-ground needs a --terrain"):
        DemoOptions(follow_ground=True)


def test_scripts_fly_level_layers() -> None:
    area_enu_m = ((0.0, 0.0), (10.0, 0.0), (10.0, 10.0))
    with pytest.raises(ConfigurationError, match=r"terrain\.follow is for missions only"):
        ScriptOptions(vehicles=2, area_enu_m=area_enu_m, terrain=terrain(Path("ground.tif"), follow=True))


def test_a_ground_elsewhere_is_refused(tmp_path: Path) -> None:
    origin = replace(ORIGIN, latitude_deg=ORIGIN.latitude_deg + 1.0)
    file = write_relief(tmp_path / "ground.tif", hill(0.0, 0.0, 1.0), origin=origin)
    with pytest.raises(ConfigurationError, match=r"ground\.tif: the ground below the mission is not known"):
        terrain_tables(file, config())
