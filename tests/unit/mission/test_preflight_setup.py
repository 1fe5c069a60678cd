"""The checks of what vehicles tell when asked."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.airspace.geofence import vehicle_fence
from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.model.checks import CheckStatus, PreflightCheck
from aos_gcs.mission.preflight import checks
from aos_gcs.mission.preflight.inspection import Inspection, TrialFrame
from aos_gcs.mission.preflight.setup import ReturnBounds, check_setup, check_system_ids
from aos_gcs.ports import Geofence, Safeguard, VehicleState
from tests.fakes.fleet import ORIGIN
from tests.fakes.good_facts import GOOD_FACTS

PASS, WARN, FAIL = CheckStatus.PASS, CheckStatus.WARN, CheckStatus.FAIL
FRAME = LocalFrame(ORIGIN)
STATE = VehicleState(3, autopilot="px4", position=ORIGIN)
FENCE = Geofence(((48.3, 14.3), (48.3, 14.31), (48.31, 14.31)), ceiling_above_home_m=42.0)
SHOT = TrialFrame(640, 512, ("thermal",), ORIGIN, math.radians(88.0), is_rotation=True)
GOOD = Inspection(replace(GOOD_FACTS, fence=FENCE), frame=SHOT, planned_fence=FENCE)
OFF = Safeguard(False, "none (X = 0)", "set X to 1")


def facts(**changes: Any) -> Inspection:
    return replace(GOOD, facts=replace(GOOD_FACTS, fence=FENCE, **changes))


def shot(**changes: Any) -> Inspection:
    return replace(GOOD, frame=replace(SHOT, **changes))


def check_of(name: str, inspection: Inspection, layer_m: float | None = 35.0, **ground: Any) -> PreflightCheck:
    return {check.name: check for check in check_setup(STATE, inspection, ReturnBounds(layer_m, **ground))}[name]


def test_good_answers_pass_and_show_their_numbers() -> None:
    found = check_setup(STATE, GOOD, ReturnBounds(35.0))
    assert [check.name for check in found] == [
        checks.FIRMWARE,
        checks.GEOFENCE,
        checks.LINK_LOSS,
        checks.LOW_BATTERY,
        checks.OTHER_FAILSAFES,
        checks.ARMING_CHECKS,
        checks.RETURN_PLACE,
        checks.RETURN_HEIGHT,
        checks.CAMERA,
    ]
    assert {check.status for check in found} == {PASS}
    texts = {check.name: check.text for check in found}
    assert texts[checks.FIRMWARE] == "px4 4.7.0"
    assert texts[checks.GEOFENCE] == "as planned, 3 corners, up to 42 m: return"
    assert texts[checks.LINK_LOSS] == "return after 5 s"
    assert texts[checks.CAMERA] == "640 x 512, thermal, 88° below the horizon, 0.0 m from the vehicle"


@pytest.mark.parametrize(
    ("name", "inspection", "status", "text", "remedy"),
    [
        (checks.FIRMWARE, facts(firmware=""), WARN, "not reported", "check it"),
        (checks.LINK_LOSS, facts(link_loss=OFF), FAIL, "none (X = 0)", "set X to 1"),
        (checks.LOW_BATTERY, facts(low_battery=OFF), FAIL, "none (X = 0)", "set X to 1"),
        (checks.OTHER_FAILSAFES, facts(other_failsafes=OFF), FAIL, "none (X = 0)", "set X to 1"),
        (checks.ARMING_CHECKS, facts(arming_checks=OFF), FAIL, "none (X = 0)", "set X to 1"),
        (checks.RETURN_PLACE, facts(return_place=OFF), FAIL, "none (X = 0)", "set X to 1"),
        (checks.GEOFENCE, facts(at_fence=OFF), FAIL, "not enforced: none (X = 0)", "set X to 1"),
        (checks.GEOFENCE, replace(GOOD, facts=GOOD_FACTS), FAIL, "none", "upload geofences"),
        (checks.GEOFENCE, replace(GOOD, upload_problem="no space"), FAIL, "upload failed", "no space"),
        (
            checks.GEOFENCE,
            replace(GOOD, planned_fence=replace(FENCE, ceiling_above_home_m=50.0)),
            FAIL,
            "not the mission's",
            "upload geofences",
        ),
        (checks.RETURN_HEIGHT, facts(return_height_m=36.0), FAIL, "36 m", "(RTL_ALT) to 35 m"),
        (
            checks.RETURN_HEIGHT,
            facts(return_climb_m=5.0),
            FAIL,
            "30 m, and 5 m above where it is",
            "set return heights",
        ),
        (
            checks.RETURN_HEIGHT,
            replace(GOOD, return_problem="it keeps it"),
            FAIL,
            "30 m, change refused",
            "it keeps it",
        ),
        (checks.CAMERA, replace(GOOD, frame=None, frame_problem="it hangs"), FAIL, "no frame", "it hangs"),
        (checks.CAMERA, shot(is_rotation=False), FAIL, "640 x 512, thermal, no orientation", "mounted"),
        (checks.CAMERA, shot(below_horizon_rad=0.5), WARN, "29° below the horizon", "point it down"),
        (
            checks.CAMERA,
            shot(position=FRAME.to_geodetic([0.0, 20.0, 0.0])),
            FAIL,
            "20.0 m from the vehicle",
            "its pose is wrong",
        ),
    ],
)
def test_what_is_wrong_is_named_with_its_remedy(
    name: str, inspection: Inspection, status: CheckStatus, text: str, remedy: str
) -> None:
    check = check_of(name, inspection)
    assert check.status is status
    assert text in check.text
    assert remedy in check.remedy
    assert check.overridable is (status is FAIL)


def test_what_is_being_asked_for_cannot_be_overridden_yet() -> None:
    found = check_setup(STATE, Inspection(), ReturnBounds(35.0))
    assert {check.name: check.status for check in found} == {
        checks.FIRMWARE: WARN,
        checks.GEOFENCE: FAIL,
        checks.LINK_LOSS: FAIL,
        checks.LOW_BATTERY: FAIL,
        checks.OTHER_FAILSAFES: FAIL,
        checks.ARMING_CHECKS: FAIL,
        checks.RETURN_PLACE: FAIL,
        checks.RETURN_HEIGHT: FAIL,
        checks.CAMERA: FAIL,
    }
    assert not any(check.overridable for check in found)
    assert not check_of(checks.GEOFENCE, replace(GOOD, planned_fence=None)).overridable
    set_now = check_of(checks.RETURN_HEIGHT, replace(GOOD, wanted_return_m=35.0))
    assert (set_now.status, set_now.overridable, set_now.remedy[:4]) == (FAIL, False, "wait")
    written = check_of(checks.GEOFENCE, replace(GOOD, facts=GOOD_FACTS, may_upload=True))
    assert (written.status, written.overridable, written.remedy[:4]) == (FAIL, False, "wait")


def test_what_a_vehicle_does_not_tell_can_be_overridden() -> None:
    check = check_of(checks.LINK_LOSS, Inspection(problem="vehicle 3 does not report its parameters in time"))
    assert (check.status, check.overridable) == (FAIL, True)
    assert "does not report" in check.remedy


def test_a_return_below_the_layer_stays_in_it() -> None:
    assert check_of(checks.RETURN_HEIGHT, GOOD, 30.0).status is PASS
    assert check_of(checks.RETURN_HEIGHT, GOOD, 29.0).status is FAIL
    assert check_of(checks.RETURN_HEIGHT, GOOD, None).status is PASS


@pytest.mark.parametrize(
    ("height_m", "layer_m", "least_m", "text", "remedy"),
    [
        (30.0, 35.0, 30.05, "30 m", ""),
        (
            30.0,
            35.0,
            32.5,
            "2.5 m below the floor above the ground at the hill",
            "to between 32.5 m and 35 m, its",
        ),
        (30.0, None, 32.5, "2.5 m below the floor", "to 32.5 m or more, or allow"),
        (30.0, 35.0, 41.0, "11.0 m below the floor", "raise the layers by 6.0 m"),
        (36.0, 35.0, 32.5, "36 m", "it would climb through other layers: set it with another ground station (RTL_ALT)"),
        (36.0, 35.0, 32.5, "36 m", "to between 32.5 m and 35 m, its layer"),
    ],
)
def test_a_return_clears_the_ground_on_its_way(
    height_m: float, layer_m: float | None, least_m: float, text: str, remedy: str
) -> None:
    found = facts(return_height_m=height_m)
    check = check_of(
        checks.RETURN_HEIGHT, found, layer_m, least_m=least_m, least_of="the floor above the ground at the hill"
    )
    assert check.status is (FAIL if remedy else PASS)
    assert text in check.text
    assert remedy in check.remedy


@pytest.mark.parametrize(("height_m", "climb_m", "is_so"), [(35.0, 0.0, True), (34.9, 0.0, False), (35.0, 2.0, False)])
def test_a_return_height_is_the_wanted_one_to_the_centimetre(height_m: float, climb_m: float, is_so: bool) -> None:
    found = replace(facts(return_height_m=height_m, return_climb_m=climb_m), wanted_return_m=35.0)
    assert found.has_wanted_return is is_so
    assert found.is_good(STATE) is is_so


def test_a_frame_without_a_position_to_compare_with_is_no_failure() -> None:
    found = check_setup(replace(STATE, position=None), GOOD, ReturnBounds(35.0))
    assert found[-1].text == "640 x 512, thermal, 88° below the horizon"
    assert found[-1].status is PASS


def test_ids_are_told_apart_by_address_and_board() -> None:
    states = [VehicleState(1), VehicleState(2), VehicleState(3, is_ambiguous=True), VehicleState(4)]
    found = check_system_ids(states, {1: "ab", 2: "ab", 3: "cd", 4: ""})
    assert [check.status for check in found] == [WARN, WARN, FAIL, PASS]
    assert found[0].text == "its board has the same id as that of vehicle 2"
    assert found[2].text == "two vehicles use it"
    assert not found[2].overridable
    assert found[3].text == "its own"


@given(st.floats(-2000.0, 2000.0), st.floats(-2000.0, 2000.0), st.floats(1.0, 3000.0), st.floats(-50.0, 50.0))
def test_the_vehicles_fence_is_ours_to_two_centimetres(
    west_m: float, south_m: float, size_m: float, home_up_m: float
) -> None:
    triangle = ((west_m, south_m), (west_m + size_m, south_m), (west_m, south_m + size_m))
    limits = SafetyLimits(fence_enu_m=triangle, floor_m=20.0, ceiling_m=60.0, no_go_enu_m=(triangle,))
    fence = vehicle_fence(limits, FRAME, home_up_m)
    assert fence.ceiling_above_home_m == pytest.approx(60.0 - home_up_m, abs=0.051)
    for ring in (fence.inclusion_deg, *fence.exclusions_deg):
        for (latitude_deg, longitude_deg), corner_m in zip(ring, triangle, strict=True):
            placed_m = FRAME.to_enu(replace(ORIGIN, latitude_deg=latitude_deg, longitude_deg=longitude_deg))[:2]
            assert np.linalg.norm(placed_m - corner_m) < 0.02
