"""What single vehicles do while the mission goes on without them, such as flying home or joining the swarm."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine


class Errands:
    """One errand per vehicle at most; a newer one ends an older one. All are owned, and end, with ``run``."""

    def __init__(self) -> None:
        self._group: asyncio.TaskGroup | None = None
        self._tasks: dict[int, asyncio.Task[None]] = {}

    async def run(self) -> None:
        """Run errands until cancelled."""
        async with asyncio.TaskGroup() as self._group:
            await asyncio.Event().wait()

    def start(self, vehicle_id: int, errand: Coroutine[None, None, None]) -> None:
        """Begin a vehicle's errand.

        Raises:
            RuntimeError: nobody runs errands; a defect of the caller.
        """
        self.stop(vehicle_id)
        if self._group is None:
            errand.close()
            raise RuntimeError("errands are started before run()")
        self._tasks[vehicle_id] = self._group.create_task(errand)

    def is_out(self, vehicle_id: int) -> bool:
        """Whether a vehicle has an errand that is not done."""
        return vehicle_id in self._tasks and not self._tasks[vehicle_id].done()

    def stop(self, vehicle_id: int) -> None:
        """End a vehicle's errand, if it has one; what it was told last remains."""
        task = self._tasks.pop(vehicle_id, None)
        if task is not None:
            task.cancel()

    def stop_all(self) -> None:
        """End all errands."""
        for vehicle_id in tuple(self._tasks):
            self.stop(vehicle_id)
