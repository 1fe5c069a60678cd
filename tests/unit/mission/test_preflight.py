"""The matrix of preflight checks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.model.checks import CheckStatus, PreflightCheck
from aos_gcs.mission.preflight.altitudes import check_altitudes
from aos_gcs.mission.preflight.checks import in_order
from aos_gcs.mission.preflight.telemetry import check_all, check_layers, check_vehicles
from aos_gcs.ports import LandedState, LinkQuality, VehicleState
from tests.fakes.fleet import ORIGIN, FakeFleet

pytestmark = pytest.mark.looptime


@dataclass
class FixedVehicle:
    """A vehicle that only has a state."""

    state: VehicleState


@dataclass
class FixedFleet:
    members: Mapping[int, Any]

    def vehicles(self) -> Mapping[int, Any]:
        return self.members


async def two_vehicles(**changes: Any) -> Roster:
    """Two good vehicles 5 m apart, the second one with a changed state."""
    clock = LoopClock()
    await clock.sleep(10.0)
    states = {number: vehicle.state for number, vehicle in FakeFleet(clock, 2, None).members.items()}
    states[2] = replace(states[2], **changes)
    roster = Roster(FixedFleet({number: FixedVehicle(state) for number, state in states.items()}), clock)
    roster.frame = LocalFrame(ORIGIN)
    roster.refresh()
    return roster


async def matrix(distance_m: float = 2.0, **changes: Any) -> tuple[PreflightCheck, ...]:
    roster = await two_vehicles(**changes)
    found = check_all(roster, roster.members(), distance_m)
    assert found == in_order(found)
    assert len({(check.vehicle_id, check.name) for check in found}) == len(found)
    return found


async def failures(distance_m: float = 2.0, **changes: Any) -> list[PreflightCheck]:
    return [check for check in await matrix(distance_m, **changes) if check.status is CheckStatus.FAIL]


async def test_good_vehicles_pass_everything() -> None:
    assert await failures() == []


@pytest.mark.parametrize(
    ("changes", "name", "remedy"),
    [
        ({"autopilot": "unknown"}, "autopilot", "use ArduCopter or PX4"),
        ({"heard_at_s": 6.0}, "link", "check its radio"),
        ({"heard_at_s": None}, "link", "check its radio"),
        ({"gps_fix": 2}, "position", "no 3D position fix"),
        ({"gps_fix": None}, "position", "no 3D position fix"),
        ({"home": None}, "home", "wait for the position estimate"),
        ({"battery_fraction": 0.49}, "battery", "replace the battery"),
        ({"battery_fraction": None}, "battery", "replace the battery"),
        ({"heard_at_s": 10.0, "battery_at_s": -11.0}, "battery", "battery monitor"),
        ({"ready_to_arm": False, "text": "PreArm: compass"}, "ready to arm", "PreArm: compass"),
        ({"ready_to_arm": None}, "ready to arm", "wait for its own checks"),
    ],
)
async def test_what_is_wrong_is_named_with_its_remedy(changes: dict[str, Any], name: str, remedy: str) -> None:
    (check,) = await failures(**changes)
    assert (check.vehicle_id, check.name) == (2, name)
    assert remedy in check.remedy


async def test_a_vehicle_without_a_position_has_no_launch_point() -> None:
    found = {check.name: check.describe() for check in await failures(position=None, gps_fix=6)}
    assert found.keys() >= {"position", "launch point"}
    assert found["position"] == (
        "vehicle 2, position: RTK fix, 12 satellites, but no position yet; "
        "wait until its autopilot has a position estimate"
    )


async def test_launch_points_too_near_to_each_other_fail_on_both_sides() -> None:
    found = await failures(distance_m=5.4)
    assert [(check.vehicle_id, check.name) for check in found] == [(1, "launch point"), (2, "launch point")]
    assert found[0].describe() == "vehicle 1, launch point: 5.0 m from vehicle 2; place them 5.5 m apart"


async def test_vehicles_that_are_not_heard_are_counted() -> None:
    (check,) = check_vehicles(await two_vehicles(), 4)
    assert (check.vehicle_id, check.name) == (0, "vehicles")
    assert check.describe() == "vehicles: 2 of 4 heard; switch the others on, or lower the number"


@pytest.mark.parametrize(
    ("changes", "name", "text"),
    [
        ({"packet_loss_fraction": 0.25}, "link", "25 % lost"),
        ({"link": LinkQuality("a", round_trip_s=1.5, clock_offset_s=3.0)}, "link", "1500 ms round trip"),
        ({"link": None}, "clock", "offset not known"),
        ({"link": LinkQuality("a")}, "clock", "offset not known"),
        ({"link": LinkQuality("a", clock_offset_s=3.0, clock_drift=-0.002)}, "clock", "drifts by -2000 µs per second"),
        ({"satellites": 5}, "position", "5 satellites"),
        ({"hdop": 3.1}, "position", "HDOP 3.1"),
    ],
)
async def test_what_is_worth_knowing_is_a_warning(changes: dict[str, Any], name: str, text: str) -> None:
    found = {check.name: check for check in await matrix(**changes) if check.vehicle_id == 2}
    assert found[name].status is CheckStatus.WARN
    assert not found[name].blocks
    assert text in found[name].text
    assert found[name].remedy


async def test_good_links_and_clocks_are_told_with_their_numbers() -> None:
    link = LinkQuality("a", round_trip_s=0.012, clock_offset_s=3.0, clock_drift=2e-5)
    found = {check.name: check for check in await matrix(link=link, packet_loss_fraction=0.01, hdop=0.8)}
    assert found["link"].text == "heard 0.0 s ago, 1 % lost, 12 ms round trip"
    assert found["clock"].text == "offset known, drifts by +20 µs per second"
    assert found["position"].text == "RTK fix, 12 satellites, HDOP 0.8"
    assert {found[name].status for name in ("link", "clock", "position")} == {CheckStatus.PASS}


async def test_layers_have_to_be_free() -> None:
    roster = await two_vehicles()
    first, second = roster.members()
    assert [check.text for check in check_layers(roster, roster.members(), 2.0, None)] == ["none yet", "none yet"]
    first.layer_height_m, second.layer_height_m = 35.0, 37.0
    assert [check.status for check in check_layers(roster, roster.members(), 2.0, None)] == [CheckStatus.PASS] * 2
    second.layer_height_m = 36.0
    assert [check.remedy[:13] for check in check_layers(roster, roster.members(), 2.0, None)] == [
        "vehicle 2 has",
        "vehicle 1 has",
    ]


async def test_a_layer_that_somebody_flies_in_is_not_free() -> None:
    position = LocalFrame(ORIGIN).to_geodetic([50.0, 50.0, 35.5])
    roster = await two_vehicles(armed=True, landed=LandedState.IN_AIR, position=position)
    first, second = roster.members()
    first.layer_height_m, second.layer_height_m = 35.0, 50.0
    assert [check.status for check in check_layers(roster, roster.members(), 2.0, None)] == [
        CheckStatus.FAIL,
        CheckStatus.PASS,
    ]


async def altitude_checks(spacing_m: float = 2.5, **changes: Any) -> dict[str, PreflightCheck]:
    roster = await two_vehicles(**changes)
    found = check_altitudes(roster, roster.members(), 1.5, spacing_m)
    return {check.name: check for check in found if check.vehicle_id == 2}


@pytest.mark.parametrize(
    ("changes", "spacing_m", "text", "remedy"),
    [
        ({"vertical_accuracy_m": None}, 5.0, "not reported, RTK fix", "send MAVLink 2"),
        ({"vertical_accuracy_m": 0.2}, 2.5, "± 0.40 m (95 %), RTK fix", "set the layer spacing to 2.8 m or more"),
        ({"vertical_accuracy_m": 0.03}, 2.2, "± 0.06 m (95 %), RTK fix", "set the layer spacing to 2.3 m or more"),
        ({"vertical_accuracy_m": 1.5}, 5.0, "± 3.00 m (95 %), RTK fix", "set the layer spacing to 6.4 m or more"),
        ({"gps_fix": 3}, 2.5, "± 0.06 m (95 %), 3D fix", "layers of 2.5 m need an RTK fix"),
        ({"altitude_test_ratio": 0.9}, 5.0, "estimator in doubt (90% of what it accepts)", "restart it"),
    ],
)
async def test_altitudes_must_be_accurate_enough_for_the_layers(
    changes: dict[str, Any], spacing_m: float, text: str, remedy: str
) -> None:
    check = (await altitude_checks(spacing_m, **changes))["altitude accuracy"]
    assert (check.status, check.overridable) == (CheckStatus.FAIL, True)
    assert text in check.text
    assert remedy in check.remedy
    assert (await altitude_checks())["altitude accuracy"].status is CheckStatus.PASS


async def test_homes_that_disagree_by_more_than_the_layers_bear_fail() -> None:
    home = replace(ORIGIN, altitude_amsl_m=ORIGIN.altitude_amsl_m + 2.0)
    changes = {"home": home, "position": home, "height_above_home_m": 0.0}
    check = (await altitude_checks(2.5, **changes))["home altitude"]
    assert (check.status, check.overridable) == (CheckStatus.FAIL, True)
    assert check.text == "1.0 m above the median of all"
    assert "0.2 m are allowed" in check.remedy
    assert (await altitude_checks(6.0, **changes))["home altitude"].status is CheckStatus.PASS
    assert (await altitude_checks(home=None))["home altitude"].text == "unknown"
