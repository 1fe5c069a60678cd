"""Procedures of single vehicles beside the mission, such as flying home alone or joining the swarm."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine


class VehicleTasks:
    """Runs at most one procedure per vehicle; a newer one ends an older one. All end with ``run``."""

    def __init__(self) -> None:
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
        self._tasks[vehicle_id] = self._group.create_task(procedure)

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
