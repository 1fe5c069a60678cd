"""Places where others expect a vehicle that is not heard any more."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.waypoints import WaypointVerdict
from aos_gcs.clock import LoopClock
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.fleet.bounds import FlightBounds
from aos_gcs.mission.fleet.flight import FlightControl
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import Deadlines, FlightSettings
from aos_gcs.ports import Goto
from tests.fakes.fleet import ORIGIN, FakeFleet
from tests.fakes.roster import give_task

pytestmark = pytest.mark.looptime
HEIGHT_M = 35.0


def lost_on_its_way(
    height_m: float = HEIGHT_M,
    east_m: float = -40.0,
    home_east_m: float = 0.0,
    task: Task = Task.LOST,
    north_m: float = 20.0,
) -> tuple[FlightControl, Roster]:
    """Return control of vehicle 1, and of vehicle 2 that fell silent at 5 m/s on its way from north 20 to north 30."""
    clock = LoopClock()
    fleet = FakeFleet(clock, 2, None)
    roster = Roster(fleet, clock)
    roster.refresh()
    roster.frame = LocalFrame(ORIGIN)
    far_m = 900.0
    settings = FlightSettings()
    limits = SafetyLimits(
        fence_enu_m=((-far_m, -far_m), (far_m, -far_m), (far_m, far_m), (-far_m, far_m)), floor_m=20.0, ceiling_m=60.0
    )
    bounds = FlightBounds(settings.arrival_radius_m, limits)
    control = FlightControl(roster, clock, Journal(clock), settings, Deadlines(), bounds=bounds)
    mover, other = roster.members()
    fleet.members[1].start_enu_m = fleet.members[1].goal_enu_m = np.array([east_m, north_m, height_m])
    vehicle = fleet.members[2]
    vehicle.start_enu_m, vehicle.started_s, vehicle.speed_mps = np.array([0.0, 20.0, HEIGHT_M]), clock.now_s(), 5.0
    vehicle.goal_enu_m = np.array([0.0, 30.0, HEIGHT_M])
    for each in fleet.members.values():
        each.armed = True
    give_task(roster, mover, Task.SWARM)
    give_task(roster, other, task)
    other.waypoint_enu_m, other.home_enu_m = vehicle.goal_enu_m, np.array([home_east_m, 0.0, 0.0])
    other.last_command = Goto(roster.geodetic(other, vehicle.goal_enu_m), 5.0)
    vehicle.silent_since_s = clock.now_s()
    return control, roster


def sent_to(
    control: FlightControl, east_m: float, north_m: float, height_m: float = HEIGHT_M
) -> tuple[WaypointVerdict, str]:
    (record,) = control.vet({1: np.array([east_m, north_m, height_m])})
    return record.verdict, record.reason


async def test_the_motion_that_it_reported_last_counts_for_a_while_and_not_for_ever() -> None:
    control, _ = lost_on_its_way()
    await asyncio.sleep(5.0)
    assert sent_to(control, 40.0, 50.0)[0] is WaypointVerdict.SHORTENED, "it may have flown on beyond its waypoint"
    await asyncio.sleep(60.0)
    for north_m in (50.0, 200.0, 360.0):
        assert sent_to(control, 40.0, north_m)[0] is WaypointVerdict.SENT, "it has not flown 300 m without an order"
    assert sent_to(control, 40.0, 28.0)[0] is WaypointVerdict.SHORTENED, "on its way to its waypoint"
    assert sent_to(control, 40.0, 10.0)[0] is WaypointVerdict.SHORTENED, "on its way home"


async def test_others_fly_around_the_column_of_one_that_was_lost_in_motion() -> None:
    below_m = HEIGHT_M - 10.0
    control, _ = lost_on_its_way(below_m)
    await asyncio.sleep(60.0)
    verdict, reason = sent_to(control, 40.0, 20.0, below_m)
    assert verdict is WaypointVerdict.SHORTENED
    assert "around vehicle 2, which is not heard" in reason


@pytest.mark.parametrize(
    ("task", "verdict"), [(Task.LOST, WaypointVerdict.SHORTENED), (Task.SWARM, WaypointVerdict.SENT)]
)
async def test_its_way_home_from_its_waypoint_is_kept_free_as_that_from_where_it_was_heard(
    task: Task, verdict: WaypointVerdict
) -> None:
    """The failsafe acts seconds after the vehicle was heard last: in a sweep, it has flown most of the way by then."""
    control, _ = lost_on_its_way(east_m=60.0, home_east_m=30.0, task=task)
    await asyncio.sleep(60.0)
    assert sent_to(control, 11.0, 20.0)[0] is verdict, "0.7 m beside the line from its waypoint to its launch point"
    assert sent_to(control, 14.0, 20.0)[0] is WaypointVerdict.SENT


async def test_it_may_turn_for_home_anywhere_on_its_way_to_its_waypoint() -> None:
    """One that flies between the ways home from both ends of that way, 2.8 and 3.9 m beside them, is in its way."""
    control, _ = lost_on_its_way(east_m=4.0, north_m=22.0, home_east_m=30.0)
    await asyncio.sleep(60.0)
    verdict, reason = sent_to(control, 4.0, 23.0)
    assert verdict is not WaypointVerdict.SENT
    assert "vehicle 2" in reason


@pytest.mark.parametrize(("north_m", "is_free"), [(21.0, True), (29.0, False)])
async def test_a_way_is_withdrawn_only_for_what_the_vehicle_meets_after_it_has_stopped(
    north_m: float, is_free: bool
) -> None:
    """A hold cannot keep it from what it passes first, and may let it stop right above that."""
    control, roster = lost_on_its_way(east_m=0.0, north_m=north_m, task=Task.SWARM)
    await asyncio.sleep(0.1)
    hovering, flying = roster.members()
    assert (control.rest_of_way(flying, [hovering], 0.2).fraction == 1.0) is is_free
