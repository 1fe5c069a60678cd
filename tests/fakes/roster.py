"""Vehicles with any task, for tests that begin in the middle of a mission."""

from __future__ import annotations

from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.fleet.tasks import TASK_TRANSITIONS
from aos_gcs.mission.model.vehicles import Task


def give_task(roster: Roster, member: Member, task: Task) -> None:
    """Give a vehicle a task, by way of the swarm where it cannot follow directly."""
    if task is not member.task and task not in TASK_TRANSITIONS[member.task]:
        roster.assign(member, Task.SWARM)
    roster.assign(member, task)
