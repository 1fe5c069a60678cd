"""Links that are lost: what is said of the cause."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.mission.fleet.link_watch import LinkWatch
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import LinkQuality, VehicleState
from tests.fakes.fleet import FakeFleet
from tests.fakes.roster import give_task

pytestmark = pytest.mark.looptime


@pytest.mark.parametrize(
    ("stall_s", "delay_s", "end"),
    [
        (0.0, 0.0, "Check its link"),
        (2.0, 0.0, "Check its link. This station stood still for 2.0 s meanwhile: its own overload may be the cause"),
        (0.0, 6.0, "Check its link. Its messages arrive 6 s late: this station or the link may be overloaded"),
    ],
)
async def test_a_lost_link_is_reported_with_an_overload_of_the_station(
    caplog: pytest.LogCaptureFixture, stall_s: float, delay_s: float, end: str
) -> None:
    clock = LoopClock()
    journal, roster = Journal(clock), Roster(FakeFleet(clock, 1, None), clock)
    (member,) = roster.refresh()
    give_task(roster, member, Task.SWARM)
    await clock.sleep(10.0)
    state = VehicleState(vehicle_id=1, heard_at_s=4.0, link=LinkQuality("here", telemetry_delay_s=delay_s))
    member.vehicle = SimpleNamespace(state=state)  # type: ignore[assignment]
    if stall_s:
        journal.note_stall(stall_s)
    LinkWatch(roster, clock, journal).look(member, 5.0)
    assert member.task is Task.LOST
    assert caplog.messages[-1] == f"Vehicle 1: link lost for 6 s: its own failsafe flies it now. {end}"
