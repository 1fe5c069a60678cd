"""The tasks of vehicles as a table: which may follow which."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from aos_gcs.errors import AosError
from aos_gcs.mission.model.vehicles import Task

_STOPPABLE = frozenset({Task.HELD, Task.RETURNING, Task.LANDING})
"""Tasks that every vehicle in the air can be given, also one that took off without the mission."""

TASK_TRANSITIONS: Mapping[Task, frozenset[Task]] = MappingProxyType(
    {
        Task.IDLE: frozenset({Task.SWARM, Task.JOINING}) | _STOPPABLE,
        # Back to IDLE: the motors did not start.
        Task.JOINING: frozenset({Task.IDLE, Task.SWARM, Task.LOST}) | _STOPPABLE,
        Task.SWARM: frozenset({Task.LANDED, Task.LOST}) | _STOPPABLE,
        Task.HELD: frozenset({Task.SWARM, Task.LANDED, Task.LOST}) | _STOPPABLE,
        Task.RETURNING: frozenset({Task.LANDED, Task.LOST}) | _STOPPABLE,
        Task.LANDING: frozenset({Task.LANDED, Task.LOST}) | _STOPPABLE,
        Task.LANDED: frozenset({Task.JOINING}) | _STOPPABLE,
        # Heard again, a vehicle goes on; IDLE is for one that fell silent before its motors started.
        Task.LOST: frozenset({Task.IDLE, Task.SWARM}) | _STOPPABLE,
    }
)
"""Tasks that may follow each task. A task may always follow itself."""


class TaskTransitionError(AosError):
    """A vehicle was given a task that cannot follow its present one: a defect of the program, not of a user."""


def check_task(vehicle_id: int, current: Task, following: Task) -> None:
    """Check that a vehicle may be given a task.

    Raises:
        TaskTransitionError: the table does not have the transition.
    """
    if following is not current and following not in TASK_TRANSITIONS[current]:
        raise TaskTransitionError(f"Vehicle {vehicle_id} cannot change from the task {current} to {following}.")


def task_when_heard_again(task: Task) -> Task:
    """Return the task with which a vehicle that is lost goes on; one that was joining waits for the operator."""
    return Task.HELD if task is Task.JOINING else task
