"""Missions of the laboratory over relief: how high they fly, and studies from before there was terrain."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.lab.flights import Flight, FlightSettings, build_flight
from aos_gcs.lab.missions.model import MissionsSettings
from aos_gcs.lab.missions.store import MissionsFolder
from aos_gcs.lab.study_folder import SETTINGS_FILE
from aos_gcs.planning.settings import FlightSettings as FlightPlan
from aos_gcs.runtime.virtual_mission import mission_settings


def flight_over(terrain: str) -> Flight:
    return build_flight(FlightSettings(1, 3, 0.0, has_person=True, side_m=25.0, image_size_px=64, terrain=terrain))


def test_layers_lie_as_much_higher_as_the_highest_ground_of_the_area() -> None:
    flight = flight_over("slope:20")
    assert flight.highest_ground_m == pytest.approx(5.0)
    settings = mission_settings(flight, 3, "aos-apso", 1)
    assert settings.flight.lowest_layer_m == pytest.approx(FlightPlan().lowest_layer_m + 5.0)
    level = mission_settings(flight_over("flat"), 3, "aos-apso", 1)
    assert level.flight == FlightPlan()


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
