"""Advice on the aperture before the start."""

from __future__ import annotations

from dataclasses import replace

import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.aperture import plan_aperture, smallest_spacing_m
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.model.checks import CheckStatus
from aos_gcs.mission.preflight.plan import check_aperture
from aos_gcs.planning.detection.aperture import advise
from aos_gcs.planning.settings import FlightSettings, ForestSettings, MissionSettings

FOREST = ForestSettings(canopy_height_m=18.0, crown_base_m=6.0)
AREA = ((0.0, 0.0), (50.0, 0.0), (50.0, 50.0))


def mission(vehicles: int = 10, c4_m: float = 4.2, **flight: float) -> MissionSettings:
    return MissionSettings(
        vehicles=vehicles,
        area_enu_m=AREA,
        imaging=ImagingSettings(),
        strategy_parameters={"c4_m": c4_m},
        flight=FlightSettings(**flight),
        forest=FOREST,
    )


def test_advice_uses_the_missions_own_layers() -> None:
    advice = advise(mission(lowest_layer_m=35.0, layer_spacing_m=3.0), FOREST)
    assert advice.plan.layers_m == tuple(35.0 + 3.0 * layer for layer in range(10))
    assert advice.plan.spacing_m == pytest.approx(smallest_spacing_m(62.0, 12.0, 1.4))


def test_heights_count_from_the_focal_plane() -> None:
    raised = replace(mission(), imaging=ImagingSettings(plane_height_m=5.0))
    assert advise(raised, FOREST).plan.layers_m[0] == 30.0


def test_a_spacing_below_the_smallest_useful_one_is_told() -> None:
    narrow = advise(mission(layer_spacing_m=0.1, c4_m=3.0), FOREST)
    assert any("below the smallest useful spacing of 4.2 m" in warning for warning in narrow.warnings)
    wide = advise(mission(layer_spacing_m=0.1, c4_m=5.0), FOREST)
    assert not any("smallest useful spacing" in warning for warning in wide.warnings)


def test_too_few_vehicles_are_told_with_the_number_that_is_enough() -> None:
    few = advise(mission(vehicles=3), FOREST)
    assert (
        few.needed
        == plan_aperture(
            altitude_m=35.0, fov_rad=0.87, canopy_height_m=18.0, crown_base_m=6.0, occluder_size_m=1.4, occlusion=0.85
        ).drones
    )
    assert any(f"{few.needed} reach 95%" in warning for warning in few.warnings)
    assert advise(mission(vehicles=few.needed, c4_m=8.0, layer_spacing_m=0.1), FOREST).plan.saturation >= 0.95


def test_the_check_informs_and_never_fails() -> None:
    (check,) = check_aperture(mission(vehicles=3))
    assert (check.vehicle_id, check.status, check.blocks) == (0, CheckStatus.WARN, False)
    assert "3 vehicles" in check.text
    assert check.remedy == "; ".join(advise(mission(vehicles=3), FOREST).warnings)
    assert check_aperture(replace(mission(), forest=None)) == ()


def test_flying_below_the_tree_tops_is_refused() -> None:
    with pytest.raises(ConfigurationError, match="above the tree tops"):
        advise(mission(lowest_layer_m=15.0), FOREST)
