"""Procedures of single vehicles beside the mission, such as flying home alone or joining the swarm."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine

from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.member import FLYING
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Disarm, Hold, Severity


class VehicleTasks:
    """Runs at most one procedure per vehicle; a newer one ends an older one. All end with ``run``.

    A procedure that fails by a defect of the program holds its vehicle; all others fly on.

    Args:
        context: returns the context of the present flight.
    """

    def __init__(self, context: Callable[[], FlightContext]) -> None:
        self._context = context
        self._group: asyncio.TaskGroup | None = None
        self._tasks: dict[int, asyncio.Task[None]] = {}

    async def run(self) -> None:
        """Run procedures until cancelled."""
        async with asyncio.TaskGroup() as self._group:
            await asyncio.Event().wait()

    def start(self, vehicle_id: int, procedure: Coroutine[None, None, None]) -> None:
        """Begin a vehicle's procedure.

        Raises:
            RuntimeError: ``run`` has not begun; a defect of the caller.
        """
        self.stop(vehicle_id)
        if self._group is None:
            procedure.close()
            raise RuntimeError("a vehicle's procedure was started before run()")
        task = self._tasks[vehicle_id] = self._group.create_task(self._guard(vehicle_id, procedure))
        # One that is stopped before it has begun was never awaited.
        task.add_done_callback(lambda _: procedure.close())

    async def _guard(self, vehicle_id: int, procedure: Coroutine[None, None, None]) -> None:
        try:
            await procedure
        except Exception as error:
            await self._hold(vehicle_id, error)

    async def _hold(self, vehicle_id: int, error: Exception) -> None:
        """Hold the vehicle of a procedure that has failed; one that still stands on the ground stops its motors."""
        context = self._context()
        (member,) = context.roster.select([vehicle_id])
        text = f"internal error, it is held: {error!r}. Return it, or land it"
        context.journal.notice(Severity.CRITICAL, text, vehicle_id)
        if not context.roster.may_fly(member):
            return
        if member.task in FLYING:
            context.roster.assign(member, Task.HELD)
        if not member.has_pilot:
            await context.flight.command(member, Hold() if member.airborne else Disarm())

    def is_running(self, vehicle_id: int) -> bool:
        """Return whether a vehicle has a procedure that is not finished."""
        return vehicle_id in self._tasks and not self._tasks[vehicle_id].done()

    def stop(self, vehicle_id: int) -> None:
        """End a vehicle's procedure, if it has one; its last command stays in force."""
        task = self._tasks.pop(vehicle_id, None)
        if task is not None:
            task.cancel()

    def stop_all(self) -> None:
        """End all procedures."""
        for vehicle_id in tuple(self._tasks):
            self.stop(vehicle_id)
