"""Spacing of the demo's vehicles on the ground and in flight."""

from __future__ import annotations

import pytest

from aos_gcs.config.file import parse_config
from aos_gcs.config.settings import mission_settings
from aos_gcs.errors import ConfigurationError
from aos_gcs.runtime.simulated.demo import DemoOptions, _simulator_command, _tables
from aos_sim.swarm import SwarmOptions, home_positions_enu_m


@pytest.mark.parametrize(("errors", "layers_m", "launch_m"), [("rtk", 2.5, "5.0"), ("gnss", 7.5, "10.0")])
def test_service_and_simulator_are_told_the_distances_of_a_grade(errors: str, layers_m: float, launch_m: str) -> None:
    options = DemoOptions(errors=errors)
    settings = mission_settings(parse_config(_tables(options, 14550), source="demo"))
    assert settings.flight.layer_spacing_m == layers_m
    assert ("home altitude" in settings.preflight.overrides) == (errors == "gnss")
    assert settings.registration.enabled == (errors == "gnss")
    assert settings.uncertainty.position_horizontal_m == {"rtk": 0.5, "gnss": 1.0}[errors]
    command = _simulator_command(options, 14550, options.folder, options.folder)
    assert command[command.index("--launch-spacing") + 1] == launch_m


def test_launch_points_lie_as_far_apart_as_told() -> None:
    east_m = home_positions_enu_m(3, spacing_m=10.0)[:, 0]
    assert east_m.tolist() == [-10.0, 0.0, 10.0]
    with pytest.raises(ConfigurationError, match="--launch-spacing must lie within 1 and 20"):
        SwarmOptions(launch_spacing_m=0.5)
