"""Spacing of the laboratory's vehicles on the ground and in flight, by the errors of their positions."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from aos_gcs.airspace.accuracy import CONFIDENCE, Accuracy, beside_errors_m, greatest_accuracy_m
from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.imaging.geolocation import Uncertainty
from aos_gcs.lab.flights import FlightParameters, build_flight
from aos_gcs.lab.missions.model import MissionsSettings
from aos_gcs.lab.spacing import spacing_for
from aos_gcs.planning.settings import FlightSettings
from aos_gcs.ports import Clock, FlightMode
from aos_gcs.runtime.simulated.virtual_mission import mission_settings
from aos_sim.errors.model import GRADES
from aos_sim.flights.swarm import FlownSwarm

ORIGIN = GeodeticPosition(48.3, 14.3, 400.0)


@pytest.mark.parametrize("grade", GRADES)
def test_layers_and_launch_points_of_a_grade_bear_its_errors(grade: str) -> None:
    spacing, accuracy = spacing_for(grade), Accuracy(*GRADES[grade].position.accuracy_m)
    assert greatest_accuracy_m(UNLIMITED.separation_m, spacing.layers_m) >= accuracy.vertical_m
    # Reported distances of launch points err, too.
    reported_m = spacing.launch_m - CONFIDENCE * math.sqrt(2.0) * accuracy.horizontal_m
    assert reported_m >= UNLIMITED.launch_distance_m + beside_errors_m(accuracy)


def test_what_is_set_takes_the_place_of_what_a_grade_needs() -> None:
    assert MissionsSettings(layer_spacing_m=9.0).spacing("gnss").layers_m == 9.0
    assert MissionsSettings(launch_spacing_m=12.0).spacing("rtk").launch_m == 12.0
    assert MissionsSettings().spacing("rtk").overrides == {}


@pytest.mark.parametrize("grade", GRADES)
def test_missions_without_corrections_reckon_with_their_accuracy_and_learn_poses_from_frames(grade: str) -> None:
    flight = build_flight(FlightParameters(1, 2, 0.0, has_person=False, side_m=20.0, image_size_px=64, errors=grade))
    settings = mission_settings(flight, 2, "aos-apso", 1, spacing=spacing_for(grade))
    usual = Uncertainty()
    if grade != "gnss":
        assert (settings.uncertainty, settings.registration.enabled) == (usual, False)
        return
    horizontal_m, vertical_m = GRADES[grade].position.accuracy_m
    assert settings.registration.enabled
    assert settings.uncertainty.position_horizontal_m == pytest.approx(horizontal_m, abs=0.05)
    assert settings.uncertainty.position_vertical_m == pytest.approx(vertical_m, abs=0.05)


@pytest.mark.parametrize(("field", "value"), [("layer_spacing_m", 0.0), ("launch_spacing_m", math.nan)])
def test_spacings_out_of_range_name_the_option(field: str, value: float) -> None:
    with pytest.raises(ConfigurationError, match=f"--{field.removesuffix('_m').replace('_', '-')} must lie within 1"):
        MissionsSettings(**{field: value})


@pytest.mark.parametrize("speed_mps", [FlightSettings().leg_speed_mps, FlightSettings().cruise_speed_mps])
def test_vehicles_in_neighbouring_layers_keep_the_separation_in_gusts(speed_mps: float) -> None:
    """Pairs that pass above each other in the middle of their ways, 800 times."""
    pairs, leg_m, layers_m = 40, 40.0, (35.0, 35.0 + spacing_for("rtk").layers_m)
    clock = SimpleNamespace(s=0.0)
    homes_enu_m = np.array([[20.0 * pair, 3.0 * one, 0.0] for pair in range(pairs) for one in range(2)])
    swarm = FlownSwarm(
        cast("Clock", SimpleNamespace(now_s=lambda: clock.s)), LocalFrame(ORIGIN), homes_enu_m, GRADES["rtk"], seed=5
    )
    for leg in range(20):
        for row, pilot in enumerate(swarm.pilots):
            pair, one = divmod(row, 2)
            pilot.armed = pilot.lifting = True
            pilot.speed_mps = speed_mps
            north_m = leg_m * ((leg + one) % 2)
            # The first leg leads up, side by side.
            place_enu_m = np.array([20.0 * pair + (3.0 * one if leg == 0 else 0.0), north_m, layers_m[one]])
            pilot.fly(FlightMode.GUIDED, place_enu_m)
        clock.s += leg_m / speed_mps + (25.0 if leg == 0 else 6.0)
        swarm.advance()
    assert swarm.min_separation_m is not None
    assert swarm.min_separation_m >= UNLIMITED.separation_m
