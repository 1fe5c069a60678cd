"""One vehicle of a fleet, the same for both drivers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractAsyncContextManager

from aos_drivers.vehicle.cameras.exposure import CaptureTools, VehicleAccess
from aos_drivers.vehicle.cameras.runner import CaptureRunner, FrameSource, make_source
from aos_drivers.vehicle.commands import CommandRunner
from aos_drivers.vehicle.setup import SetupRunner
from aos_gcs.geometry.heights import AboveHomeM
from aos_gcs.ports import Capture, Command, Geofence, IntervalCaptures, VehicleFacts, VehicleState


class MavlinkVehicle:
    """A vehicle of a fleet (``aos_gcs.ports.Vehicle``)."""

    def __init__(
        self,
        access: VehicleAccess,
        tools: CaptureTools,
        make_component_source: Callable[[], FrameSource],
        our_system_id: int,
    ) -> None:
        record, send, changes = access.record, access.send, access.changes
        self._record = record
        self._clock = tools.clock
        self._commands = CommandRunner(record, send, changes, tools.clock)
        self._setup = SetupRunner(record, send, changes, tools.clock, our_system_id)
        self._captures = CaptureRunner(access, tools, make_source(access, tools, make_component_source))

    @property
    def state(self) -> VehicleState:
        """The latest telemetry."""
        return self._record.state(self._clock.now_s())

    def reclaim(self) -> None:
        """Count the present mode and target as ours; see the port."""
        self._record.control.reclaim()

    async def execute(self, command: Command, deadline_s: float) -> None:
        """Execute the command; see the port."""
        await self._commands.run(command, deadline_s)

    async def inspect(self, deadline_s: float) -> VehicleFacts:
        """Read the vehicle's settings; see the port."""
        return await self._setup.inspect(deadline_s)

    async def upload_fence(self, fence: Geofence, deadline_s: float) -> None:
        """Replace the vehicle's fence; see the port."""
        await self._setup.upload_fence(fence, deadline_s)

    async def set_return_height(self, height_above_home_m: AboveHomeM, deadline_s: float) -> None:
        """Set the height of the vehicle's own return; see the port."""
        await self._setup.set_return_height(height_above_home_m, deadline_s)

    async def restore_return(self, settings: Mapping[str, float], deadline_s: float) -> None:
        """Restore the settings of the vehicle's own return; see the port."""
        await self._setup.restore_return(settings, deadline_s)

    async def capture(self, deadline_s: float) -> Capture:
        """Expose one image and fetch it; see the port."""
        return await self._captures.run(deadline_s)

    def interval(self, period_s: float, deadline_s: float) -> AbstractAsyncContextManager[IntervalCaptures]:
        """Have the camera take images by itself; see the port."""
        return self._captures.interval(period_s, deadline_s)
