"""Links that are lost: what is said of the cause."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.fleet.watches.links import LONGEST_DOUBT_S, RESTORED_AFTER_S, LinkWatch
from aos_gcs.mission.health import Punctuality
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
        (
            2.0,
            0.0,
            "Check its link. This station was unresponsive for 2.0 s meanwhile: its own overload may be the cause",
        ),
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
    LinkWatch(roster, clock, journal, Punctuality(0.1)).look(member, 5.0)
    assert member.task is Task.LOST
    assert caplog.messages[-1] == f"Vehicle 1: link lost for 6 s: its own failsafe flies it now. {end}"


class WatchedLink:
    """One vehicle of the swarm that is heard or silent, looked at ten times per second."""

    def __init__(self, caplog: pytest.LogCaptureFixture) -> None:
        self.clock = LoopClock()
        self._caplog = caplog
        self._roster = Roster(FakeFleet(self.clock, 1, None), self.clock)
        self.punctuality = Punctuality(0.1)
        self._watch = LinkWatch(self._roster, self.clock, Journal(self.clock), self.punctuality)
        self.member: Member
        (self.member,) = self._roster.refresh()
        give_task(self._roster, self.member, Task.SWARM)
        self._vehicle = self.member.vehicle
        self._heard_at_s = self.clock.now_s()

    async def look(self, for_s: float, *, heard: bool, late_s: float = 0.0) -> None:
        """Look at it for some time."""
        until_s = self.clock.now_s() + for_s
        while self.clock.now_s() < until_s:
            await self.clock.sleep(0.1 + late_s)
            if heard:
                self._heard_at_s = self.clock.now_s()
            state = replace(self._vehicle.state, heard_at_s=self._heard_at_s, armed_at_s=self._heard_at_s)
            self.member.vehicle = SimpleNamespace(state=state)  # type: ignore[assignment]
            self.punctuality.look(self.clock.now_s())
            self._watch.look(self.member, 5.0)

    def hold(self) -> None:
        """Give it the task of an operator's hold."""
        self._roster.assign(self.member, Task.HELD)

    def told(self, text: str) -> int:
        """Return how many notices contain a text."""
        return sum(text in message for message in self._caplog.messages)


async def test_a_link_that_comes_and_goes_stays_lost_until_it_has_been_good_for_some_time(
    caplog: pytest.LogCaptureFixture,
) -> None:
    link = WatchedLink(caplog)
    await link.look(6.0, heard=False)
    for _ in range(10):
        await link.look(RESTORED_AFTER_S - 0.5, heard=True)
        assert link.member.task is Task.LOST
        await link.look(2.5, heard=False)
    assert (link.told("link lost"), link.told("link restored")) == (1, 0)
    await link.look(RESTORED_AFTER_S + 0.5, heard=True)
    assert link.member.task is Task.HELD, "it was silent for too long to go on by itself"
    assert (link.told("link lost"), link.told("link restored")) == (1, 1)


async def test_a_link_that_is_lost_again_soon_has_to_be_good_for_longer(caplog: pytest.LogCaptureFixture) -> None:
    link = WatchedLink(caplog)
    for doubt_s in (RESTORED_AFTER_S, 2 * RESTORED_AFTER_S, LONGEST_DOUBT_S, LONGEST_DOUBT_S):
        await link.look(6.0, heard=False)
        await link.look(doubt_s - 0.2, heard=True)
        assert link.member.task is Task.LOST
        await link.look(0.6, heard=True)
        assert link.member.task is Task.SWARM
    await link.look(70.0, heard=True)
    await link.look(6.0, heard=False)
    await link.look(RESTORED_AFTER_S + 0.4, heard=True)
    assert link.member.task is Task.SWARM


async def test_a_silence_counts_until_the_link_is_back_not_until_it_is_trusted(
    caplog: pytest.LogCaptureFixture,
) -> None:
    link = WatchedLink(caplog)
    await link.look(29.0, heard=False)
    await link.look(4.0, heard=True)
    assert link.told("link restored after 29 s: it goes on in the swarm") == 1


async def test_a_link_that_is_lost_while_the_station_is_late_is_reported_as_its_overload(
    caplog: pytest.LogCaptureFixture,
) -> None:
    link = WatchedLink(caplog)
    await link.look(10.0, heard=True, late_s=0.5)
    await link.look(6.0, heard=False, late_s=0.5)
    assert caplog.messages[-1].endswith(
        "This station is overloaded, which may be the cause: close other programs on this computer"
    )


async def test_an_operator_commands_a_lost_vehicle_as_soon_as_it_is_heard(caplog: pytest.LogCaptureFixture) -> None:
    link = WatchedLink(caplog)
    await link.look(6.0, heard=False)
    assert not link.member.is_reachable
    await link.look(0.5, heard=True)
    assert (link.member.task, link.member.is_reachable) == (Task.LOST, True)
    link.hold()
    await link.look(0.5, heard=True)
    assert link.told("link restored") == 1
