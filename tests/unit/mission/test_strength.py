"""Searches with too few vehicles: whom they wait for, and what they end with. In virtual time."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from types import SimpleNamespace

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.errors import MissionFailedError
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.search.strength import TAKE_OFF_S, SwarmStrength

pytestmark = pytest.mark.looptime

SWAP_S, ALL_LOST_S, SEARCH_S = 20.0, 15.0, 600.0
LOW = "battery at 10%"


@dataclass
class FakeMember:
    vehicle_id: int
    task: Task
    left_for_battery: str = ""
    follows_us: bool = True
    airborne: bool = True


@dataclass
class FakeSwarm:
    """The part of a flight's context that a swarm is gathered by."""

    members: list[FakeMember]
    fewest: int = 2
    notices: list[str] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)

    def strength(self, *, may_be_relieved: bool = False) -> SwarmStrength:
        settings = SimpleNamespace(
            fewest_vehicles=self.fewest,
            deadlines=SimpleNamespace(all_lost_s=ALL_LOST_S, search_s=SEARCH_S),
            relay=SimpleNamespace(swap_s=SWAP_S),
        )
        roster = SimpleNamespace(members=lambda *tasks: [m for m in self.members if not tasks or m.task in tasks])
        journal = SimpleNamespace(
            notice=lambda _severity, text: self.notices.append(text), set_message=self.messages.append
        )
        clock = self.clock = LoopClock()
        begun_s = clock.now_s()
        journal.elapsed_s = lambda: clock.now_s() - begun_s
        context = SimpleNamespace(roster=roster, settings=settings, journal=journal, clock=self.clock)
        return SwarmStrength(
            context,  # type: ignore[arg-type]
            covered_fraction=lambda: 0.46,
            may_be_relieved=lambda: may_be_relieved,
        )


async def test_batteries_end_a_search_at_once_where_nobody_takes_over() -> None:
    swarm = FakeSwarm([FakeMember(1, Task.SWARM), FakeMember(2, Task.RETURNING, LOW)])
    strength = swarm.strength()
    begun_s = swarm.clock.now_s()
    assert await strength.gather() == []
    assert swarm.clock.now_s() == begun_s
    (notice,) = swarm.notices
    assert notice == (
        "Search ended by the batteries: 1 left in the swarm, 2 needed (vehicle 2: battery at 10%). "
        "46 % of the area was in a frame. All vehicles return"
    )


async def test_the_battery_of_a_single_vehicle_ends_its_search() -> None:
    swarm = FakeSwarm([FakeMember(1, Task.RETURNING, LOW)], fewest=1)
    assert await swarm.strength(may_be_relieved=True).gather() == []
    assert swarm.messages == [], "a replacement has nobody to fly to"


@pytest.mark.parametrize(
    "others",
    [
        [FakeMember(2, Task.HELD, follows_us=False), FakeMember(3, Task.HELD, follows_us=False)],
        [FakeMember(2, Task.RETURNING), FakeMember(3, Task.SWARM, LOW)],
    ],
)
async def test_what_batteries_have_not_caused_is_a_failure(others: list[FakeMember]) -> None:
    swarm = FakeSwarm([FakeMember(1, Task.RETURNING), *others])
    with pytest.raises(MissionFailedError, match=r"The swarm needs 2 vehicles, but has \d left and 0 lost"):
        await swarm.strength().gather()
    assert swarm.notices == []


async def test_a_swarm_waits_for_a_change_of_batteries_no_longer_than_that_takes() -> None:
    swarm = FakeSwarm([FakeMember(1, Task.SWARM), FakeMember(2, Task.LANDED, LOW)])
    strength = swarm.strength(may_be_relieved=True)
    begun_s = swarm.clock.now_s()
    assert await strength.gather() == []
    assert swarm.clock.now_s() - begun_s == pytest.approx(SWAP_S + TAKE_OFF_S, abs=1.0)


async def test_a_swarm_waits_for_lost_vehicles_for_a_while_and_for_one_that_joins_until_it_has_come() -> None:
    joining = FakeMember(3, Task.JOINING)
    swarm = FakeSwarm([FakeMember(1, Task.SWARM), FakeMember(2, Task.LOST), joining])
    strength = swarm.strength()
    gathering = asyncio.create_task(strength.gather())
    await swarm.clock.sleep(ALL_LOST_S - 1.0)
    assert swarm.messages[-1] == "Waiting for 1 lost vehicles."
    await swarm.clock.sleep(SWAP_S + TAKE_OFF_S + 60.0)
    assert swarm.messages[-1] == "Waiting for a replacement: 1 left in the swarm."
    joining.task = Task.SWARM
    assert [member.vehicle_id for member in await gathering] == [1, 3]


async def test_vehicles_that_somebody_holds_are_waited_for_until_the_time_of_the_search_is_over() -> None:
    held = FakeMember(2, Task.HELD)
    swarm = FakeSwarm([FakeMember(1, Task.SWARM), held])
    strength = swarm.strength()
    gathering = asyncio.create_task(strength.gather())
    await swarm.clock.sleep(SEARCH_S - 10.0)
    assert swarm.messages[-1] == "Waiting for 1 held vehicles: resume them, or return all."
    held.task = Task.SWARM
    assert len(await gathering) == 2
    held.task = Task.HELD
    assert await strength.gather() == []
    assert swarm.notices == ["Maximum search time reached: all vehicles return"]
