"""The table of tasks: what may follow what, and what must always be possible."""

from __future__ import annotations

from unittest.mock import create_autospec

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.mission.fleet.member import FLYING, Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.fleet.tasks import TASK_TRANSITIONS, TaskTransitionError
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Clock
from tests.fakes.fleet import FakeFleet
from tests.fakes.roster import give_task

WAYS_DOWN = {Task.HELD, Task.RETURNING, Task.LANDING}
tasks = st.sampled_from(list(Task))


def one_vehicle() -> tuple[Roster, Member]:
    clock = create_autospec(Clock, instance=True)
    roster = Roster(FakeFleet(clock, 1, None), clock)
    (member,) = roster.refresh()
    return roster, member


@given(st.lists(tasks, max_size=12))
def test_a_vehicle_follows_the_table_and_keeps_its_task_when_refused(wanted: list[Task]) -> None:
    roster, member = one_vehicle()
    for task in wanted:
        before = member.task
        if task is before or task in TASK_TRANSITIONS[before]:
            roster.assign(member, task)
            assert member.task is task
        else:
            with pytest.raises(TaskTransitionError, match=f"from the task {before} to {task}"):
                roster.assign(member, task)
            assert member.task is before


@given(tasks)
def test_every_vehicle_can_be_held_returned_and_landed(task: Task) -> None:
    assert TASK_TRANSITIONS[task] >= WAYS_DOWN - {task}


@given(st.sampled_from(sorted(FLYING)))
def test_a_vehicle_that_is_heard_again_goes_on_with_what_it_did_but_does_not_join(task: Task) -> None:
    roster, member = one_vehicle()
    give_task(roster, member, task)
    give_task(roster, member, Task.LOST)
    roster.assign(member, Task.LOST)
    assert member.task_when_heard_again is (Task.HELD if task is Task.JOINING else task)
    roster.assign(member, member.task_when_heard_again)


@pytest.mark.parametrize(
    ("task", "following"),
    [
        (Task.IDLE, Task.LOST),
        (Task.IDLE, Task.LANDED),
        (Task.SWARM, Task.JOINING),
        (Task.RETURNING, Task.SWARM),
        (Task.LANDING, Task.SWARM),
        (Task.LANDED, Task.SWARM),
        (Task.LOST, Task.LANDED),
        (Task.LOST, Task.JOINING),
    ],
)
def test_an_impossible_task_is_refused(task: Task, following: Task) -> None:
    roster, member = one_vehicle()
    give_task(roster, member, task)
    with pytest.raises(TaskTransitionError):
        roster.assign(member, following)


def test_only_the_roster_changes_a_task() -> None:
    _, member = one_vehicle()
    with pytest.raises(AttributeError):
        member.task = Task.SWARM  # type: ignore[misc]
