"""The matrix of preflight checks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.model import CheckStatus, PreflightCheck
from aos_gcs.mission.preflight import check_all
from aos_gcs.mission.roster import Roster
from aos_gcs.ports import VehicleState
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


async def failures(expected: int = 2, distance_m: float = 2.0, **changes: Any) -> list[PreflightCheck]:
    """Check two good vehicles 5 m apart, the second one with a changed state, and return what has failed."""
    clock = LoopClock()
    await clock.sleep(10.0)
    states = {number: vehicle.state for number, vehicle in FakeFleet(clock, 2, None).members.items()}
    states[2] = replace(states[2], **changes)
    roster = Roster(FixedFleet({number: FixedVehicle(state) for number, state in states.items()}), clock)
    roster.frame = LocalFrame(ORIGIN)
    roster.refresh()
    checks = check_all(roster, expected, distance_m)
    assert [check.vehicle_id for check in checks] == sorted(check.vehicle_id for check in checks)
    assert len({(check.vehicle_id, check.name) for check in checks}) == len(checks)
    return [check for check in checks if check.status is CheckStatus.FAIL]


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
        ({"battery_fraction": 0.49}, "battery", "change the battery"),
        ({"battery_fraction": None}, "battery", "change the battery"),
        ({"ready_to_arm": False, "text": "PreArm: compass"}, "ready to arm", "PreArm: compass"),
        ({"ready_to_arm": None}, "ready to arm", "wait for its own checks"),
    ],
)
async def test_what_is_wrong_is_named_with_its_remedy(changes: dict[str, Any], name: str, remedy: str) -> None:
    (check,) = await failures(**changes)
    assert (check.vehicle_id, check.name) == (2, name)
    assert remedy in check.remedy


async def test_a_vehicle_without_a_position_has_no_launch_point() -> None:
    assert {(check.vehicle_id, check.name) for check in await failures(position=None)} >= {
        (2, "position"),
        (2, "launch point"),
    }


async def test_launch_points_too_near_to_each_other_fail_on_both_sides() -> None:
    found = await failures(distance_m=5.5)
    assert [(check.vehicle_id, check.name) for check in found] == [(1, "launch point"), (2, "launch point")]
    assert found[0].describe() == "vehicle 1, launch point: 5.0 m from vehicle 2; put them 5.5 m apart"


async def test_vehicles_that_are_not_heard_are_counted() -> None:
    (check,) = await failures(expected=4)
    assert (check.vehicle_id, check.name) == (0, "vehicles")
    assert check.describe() == "vehicles: 2 of 4 are heard; switch the others on or lower the number"
