"""Launch and return points, and the paths between them and the search area, in preflight."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.model.checks import CheckStatus, PreflightCheck
from aos_gcs.mission.preflight import checks
from aos_gcs.mission.preflight.ground import check_ground
from aos_gcs.planning.settings import MissionSettings

AREA = ((-50.0, 0.0), (50.0, 0.0), (50.0, 100.0), (-50.0, 100.0))
FENCE = ((-70.0, -40.0), (70.0, -40.0), (70.0, 120.0), (-70.0, 120.0))
POND = ((-5.0, -35.0), (5.0, -35.0), (5.0, -25.0), (-5.0, -25.0))
WALL = ((-80.0, -20.0), (80.0, -20.0), (80.0, -10.0), (-80.0, -10.0))
SETTINGS = MissionSettings(2, AREA, ImagingSettings())
HOMES = {1: np.array([0.0, -30.0, 0.0]), 2: np.array([20.0, -30.0, 0.0])}


def ground(no_go: tuple[Any, ...] = (), **changes: Any) -> dict[int, PreflightCheck]:
    limits = SafetyLimits(fence_enu_m=FENCE, floor_m=20.0, ceiling_m=60.0, no_go_enu_m=no_go, margin_m=2.0)
    return {check.vehicle_id: check for check in check_ground(HOMES, limits, replace(SETTINGS, **changes))}


def test_open_ground_passes() -> None:
    assert {check.status for check in ground().values()} == {CheckStatus.PASS}
    assert set(ground()) == {1, 2}


def test_a_vehicle_in_a_no_go_zone_fails_alone() -> None:
    found = ground((POND,))
    assert (found[1].status, found[2].status) == (CheckStatus.FAIL, CheckStatus.PASS)
    assert "inside of no-go zone 1" in found[1].text
    assert found[1].remedy == "move one of them"
    assert not found[1].overridable


def test_no_vehicle_starts_where_no_path_leads_to_the_area() -> None:
    found = ground((WALL,))
    assert {check.status for check in found.values()} == {CheckStatus.FAIL}
    assert "cut off" in found[2].text
    assert found[2].remedy


@pytest.mark.parametrize(
    ("place", "text"),
    [((0.0, -30.0), "inside of no-go zone 1"), ((0.0, -39.0), "1.0 m from the geofence"), ((0.0, -50.0), "outside of")],
)
def test_a_barred_return_point_fails_for_the_mission(place: tuple[float, float], text: str) -> None:
    check = ground((POND,), return_enu_m=place)[checks.MISSION]
    assert check.status is CheckStatus.FAIL
    assert text in check.text
    assert "move" in check.remedy
