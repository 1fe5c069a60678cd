"""What service and simulator are told of a relay of batteries."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace

import pytest

from aos_gcs.cli import demo as command
from aos_gcs.config.file import parse_config
from aos_gcs.config.settings import mission_settings
from aos_gcs.errors import ConfigurationError
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.runtime.simulated.demo import (
    MAX_SWAP_S,
    MAX_VEHICLES,
    RELAY_AREA_ENU_M,
    RELAY_BATTERY_S,
    RELAY_SPEED_MPS,
    SEARCH_AREA_ENU_M,
    DemoOptions,
    _simulator_command,
    _tables,
)
from tests.fakes.command_line import exit_status


def told(options: DemoOptions) -> tuple[MissionSettings, dict[str, str]]:
    """Return the settings of the service's mission, and the simulator's options with their values."""
    settings = mission_settings(parse_config(_tables(options, 14550), source="demo"))
    arguments = _simulator_command(options, 14550, options.folder, options.folder)
    return settings, {one: value for one, value in pairwise(arguments) if one.startswith("--")}


def test_a_relay_searches_a_larger_area_slowly_with_two_more_vehicles_on_small_batteries() -> None:
    settings, simulator = told(DemoOptions(vehicles=6, batteries=True, swap_s=35.0))
    assert (settings.vehicles, simulator["--vehicles"]) == (6, "8")
    assert settings.area_enu_m == RELAY_AREA_ENU_M
    assert settings.flight.search_speed_mps == RELAY_SPEED_MPS
    assert settings.relay.enabled
    assert settings.relay.swap_s == 35.0
    assert (simulator["--battery-life"], simulator["--swap"]) == (str(RELAY_BATTERY_S), "35.0")
    assert not settings.detection.stop_at_first, "a search that ends at the first person outlasts no battery"
    assert settings.deadlines.search_s > 3.0 * RELAY_BATTERY_S


def test_without_it_the_simulator_has_its_own_batteries_and_no_more_vehicles_than_the_mission() -> None:
    settings, simulator = told(DemoOptions(vehicles=6))
    assert (settings.vehicles, simulator["--vehicles"]) == (6, "6")
    assert settings.area_enu_m == SEARCH_AREA_ENU_M
    assert not settings.relay.enabled
    assert settings.detection.stop_at_first
    assert simulator.keys().isdisjoint({"--battery-life", "--swap"})


def test_those_that_relieve_others_count_as_simulated_vehicles() -> None:
    with pytest.raises(ConfigurationError, match="--vehicles must lie within 1 and 100, but is 101"):
        DemoOptions(vehicles=MAX_VEHICLES - 1, batteries=True)


def test_a_change_of_batteries_has_limits() -> None:
    with pytest.raises(ConfigurationError, match=f"--swap must lie within 1 and {MAX_SWAP_S}, but is 0"):
        DemoOptions(batteries=True, swap_s=0.0)


def test_the_command_line_asks_for_a_relay(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[DemoOptions] = []
    monkeypatch.setattr(command, "_fly", lambda options, *_, **__: given.append(options))
    score = SimpleNamespace(person_found=True, landed=8, vehicles=8)
    monkeypatch.setattr(command, "run_until_terminated", lambda _: score)
    assert exit_status(("demo", "--batteries", "--vehicles", "6", "--swap", "30")) == 0
    assert exit_status(("demo",)) == 0
    assert [(one.batteries, one.flown, one.swap_s) for one in given] == [(True, 8, 30.0), (False, 10, 20.0)]
