"""Missions of the laboratory over relief: how high they fly, and studies from before there was terrain."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.lab.flights import Flight, FlightParameters, build_flight
from aos_gcs.lab.missions.model import MissionsSettings
from aos_gcs.lab.missions.store import MissionsFolder
from aos_gcs.lab.study_folder import SETTINGS_FILE
from aos_gcs.planning.settings import FlightSettings
from aos_gcs.planning.terrain.ground import ground_heights_m
from aos_gcs.runtime.simulated.virtual_mission import mission_settings


def flight_over(terrain: str) -> Flight:
    return build_flight(FlightParameters(1, 3, 0.0, has_person=True, side_m=25.0, image_size_px=64, terrain=terrain))


def test_layers_lie_as_much_higher_as_the_highest_ground_of_the_area() -> None:
    flight = flight_over("slope:20")
    assert flight.highest_ground_m == pytest.approx(5.0)
    settings = mission_settings(flight, 3, "aos-apso", 1)
    assert settings.flight.lowest_layer_m == pytest.approx(FlightSettings().lowest_layer_m + 5.0)
    level = mission_settings(flight_over("flat"), 3, "aos-apso", 1)
    assert level.flight == FlightSettings()


def test_a_mission_over_relief_knows_its_ground(tmp_path: Path) -> None:
    pytest.importorskip("rasterio")
    flight, file = flight_over("slope:20"), tmp_path / "ground.tif"
    assert flight.write_ground(file)
    settings = mission_settings(flight, 3, "aos-apso", 1, ground=file)
    assert settings.focus_follows_ground
    assert settings.preflight.set_return_height
    assert settings.terrain is not None
    (height_m,) = ground_heights_m(settings.terrain, flight.origin, np.array([(0.0, 33.0)]))
    assert height_m == pytest.approx(5.0, abs=0.05)


def test_layers_that_follow_the_ground_are_not_raised(tmp_path: Path) -> None:
    pytest.importorskip("rasterio")
    flight, file = flight_over("slope:20"), tmp_path / "ground.tif"
    assert flight.write_ground(file)
    settings = mission_settings(flight, 3, "aos-apso", 1, ground=file, follow=True)
    assert settings.layers_follow_ground
    assert settings.flight == FlightSettings()


def test_layers_over_level_ground_have_nothing_to_follow() -> None:
    with pytest.raises(ConfigurationError, match="--follow-ground needs a --terrain"):
        MissionsSettings(follow_ground=True)


def test_focal_surfaces_are_told_apart_and_checked() -> None:
    settings = MissionsSettings(terrain="slope:20", surface="level")
    assert settings.name == "aos-apso, focal surface level"
    with pytest.raises(ConfigurationError, match="--surface needs a --terrain"):
        MissionsSettings(surface="level")
    with pytest.raises(ConfigurationError, match="--surface must be terrain or level, got 'plane'"):
        MissionsSettings(terrain="hills", surface="plane")


def test_level_ground_is_written_nowhere(tmp_path: Path) -> None:
    flight, file = flight_over("flat"), tmp_path / "ground.tif"
    assert not flight.write_ground(file)
    assert not file.exists()
    assert mission_settings(flight, 3, "aos-apso", 1).terrain is None


@pytest.mark.parametrize("terrain", ["ground.tif", "slope:abc", "valley"])
def test_what_no_flight_can_have_is_refused(terrain: str) -> None:
    with pytest.raises(ConfigurationError, match="--terrain"):
        flight_over(terrain)


def test_a_study_from_before_there_was_terrain_goes_on_over_level_ground(tmp_path: Path) -> None:
    settings = MissionsSettings(vehicles=3)
    MissionsFolder(tmp_path, settings)
    file = tmp_path / SETTINGS_FILE
    known = json.loads(file.read_text(encoding="utf-8"))
    assert known.pop("terrain") == "flat"
    file.write_text(json.dumps(known), encoding="utf-8")
    MissionsFolder(tmp_path, settings)
    with pytest.raises(ConfigurationError, match="other settings"):
        MissionsFolder(tmp_path, MissionsSettings(vehicles=3, terrain="hills"))
