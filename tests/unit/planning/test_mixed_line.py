"""Lines of mixed altitude layers: who flies where, and what that shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aos_gcs.planning.detection.expected_views import line_of, predicted_detection
from aos_gcs.planning.detection.mixed_line import mixed_formation, mixed_layers
from aos_gcs.planning.estimate import planned_legs
from aos_gcs.planning.legs import ScanLeg, leg_formation
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.settings import ForestSettings
from tests.unit.mission.test_layers import assert_apart, assert_granted, launch_points, layers_above, limits_of

FOREST = ForestSettings(canopy_height_m=18.0, crown_base_m=4.4, occlusion=0.84)
SQUARE = ((-60.0, 0.0), (60.0, 0.0), (60.0, 120.0), (-60.0, 120.0))
NORTH = ScanLeg((0.0, 0.0), (0.0, 1.0), 100.0)


@pytest.mark.parametrize(
    ("count", "layers"),
    [(1, [0]), (2, [0, 1]), (3, [0, 2, 1]), (5, [0, 4, 2, 3, 1]), (10, [0, 9, 7, 2, 5, 4, 3, 6, 8, 1])],
)
def test_every_third_place_has_a_low_layer_and_the_highest_are_near_the_ends(count: int, layers: list[int]) -> None:
    assert mixed_layers(count).tolist() == layers


def test_more_is_expected_of_a_line_of_mixed_layers_than_of_one_whose_layers_ascend() -> None:
    plan = MissionPlan(
        vehicles=6, area_enu_m=SQUARE, forest=FOREST, line_spacing_m=20.0, leg_spacing_m=120.0, search_speed_mps=6.0
    )
    ascending, mixed = (
        predicted_detection(one, planned_legs(one, 0.0), 0.0, 400) for one in (plan, replace(plan, pod=0.9))
    )
    assert ascending is not None
    assert mixed is not None
    assert mixed.standing > ascending.standing + 0.01


def test_vehicles_keep_their_places_over_the_ground_on_the_way_back() -> None:
    line = line_of(MissionPlan(vehicles=3, area_enu_m=SQUARE), 0.0)
    assert line.heights_on_m(NORTH).tolist() == [35.0, 37.5, 40.0]
    assert line.heights_on_m(NORTH.reversed).tolist() == [40.0, 37.5, 35.0]
    aside = ScanLeg((0.0, 0.0), (1.0, 0.0), 100.0)
    assert line.heights_on_m(aside).tolist() == [35.0, 37.5, 40.0]


def test_vehicles_form_the_line_by_their_layers_and_stay_in_it_on_the_way_back() -> None:
    launched_m = np.array([[5.0 * number, -80.0] for number in range(5)])
    layers_m = [40.0, 35.0, 45.0, 37.5, 42.5]
    places_m = mixed_formation(NORTH, launched_m, layers_m, 20.0)
    assert sorted(zip(places_m[:, 0].tolist(), layers_m, strict=True)) == [
        (-40.0, 35.0),
        (-20.0, 45.0),
        (0.0, 40.0),
        (20.0, 42.5),
        (40.0, 37.5),
    ]
    ahead_m = places_m + np.array([0.0, 100.0])
    np.testing.assert_allclose(mixed_formation(NORTH.reversed, ahead_m, layers_m, 20.0), ahead_m)


def test_nobody_crosses_most_of_the_line_to_mix_it_anew() -> None:
    here_m = np.array([[20.0 * number, 0.0] for number in range(5)])
    ascending_m = [35.0, 37.5, 40.0, 42.5, 45.0]
    leg = ScanLeg((40.0, 0.0), (0.0, -1.0), 100.0)
    assert mixed_formation(leg, here_m, ascending_m, 20.0).tolist() == leg_formation(leg, here_m, 20.0).tolist()


@settings(max_examples=15, deadline=None)
@given(launch_points(), st.floats(3.0, 12.0), st.floats(0.0, 6.28))
def test_paths_to_a_line_of_mixed_layers_are_flown_whole(
    homes_enu_m: np.ndarray, spacing_m: float, heading_rad: float
) -> None:
    above_enu_m, limits = layers_above(homes_enu_m), limits_of(homes_enu_m)
    leg = ScanLeg((0.0, 90.0), (float(np.sin(heading_rad)), float(np.cos(heading_rad))), 50.0)
    spaced_m = min(spacing_m, 110.0 / len(homes_enu_m))
    line_m = mixed_formation(leg, above_enu_m[:, :2], above_enu_m[:, 2].tolist(), spaced_m)
    line_enu_m = np.column_stack([line_m, above_enu_m[:, 2]])
    assert_apart(above_enu_m, line_enu_m, limits)
    assert_granted(above_enu_m, line_enu_m, limits)
