"""One vehicle that MAVSDK has found: its telemetry, its camera and the packets for it."""

from __future__ import annotations

from collections.abc import Callable

from mavsdk.plugins.mavlink_direct import MavlinkDirect
from mavsdk.system import System
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.mavsdk.component import ComponentSource
from aos_drivers.mavsdk.core import LoopDispatcher, direct_from_message
from aos_drivers.mavsdk.telemetry import TelemetryFeed
from aos_drivers.mavsdk.wire import Wire
from aos_drivers.vehicle.autopilots.base import Target, command_long
from aos_drivers.vehicle.cameras.exposure import CaptureTools, VehicleAccess
from aos_drivers.vehicle.cameras.runner import FrameSource
from aos_drivers.vehicle.mavlink_vehicle import MavlinkVehicle
from aos_drivers.vehicle.record import VehicleRecord
from aos_drivers.vehicle.waiting import Changes
from aos_gcs.ports import DriverContext


class MavsdkVehicle(MavlinkVehicle):
    """A vehicle that MAVSDK has found."""

    def __init__(
        self,
        access: VehicleAccess,
        tools: CaptureTools,
        make_component_source: Callable[[], FrameSource],
        our_system_id: int,
        feed: TelemetryFeed,
    ) -> None:
        """Keep ``feed``, which the subscriptions of MAVSDK refer to, for as long as the vehicle."""
        super().__init__(access, tools, make_component_source, our_system_id)
        self._access = access
        self._feed = feed

    def announce(self) -> None:
        """Wake everything that waits for a change of the vehicle."""
        self._access.changes.announce()

    def poll(self, now_s: float) -> None:
        """Request streams and facts that are due. Call it several times a second."""
        record = self._access.record
        for component_id, command, params in record.due_requests(now_s):
            target = Target(record.vehicle_id, component_id)
            self._access.send(record.vehicle_id, component_id, command_long(target, command, *params))


def make_vehicle(
    system: System,
    record: VehicleRecord,
    *,
    context: DriverContext,
    tools: CaptureTools,
    wire: Wire,
    dispatcher: LoopDispatcher,
) -> MavsdkVehicle:
    """Subscribe to a system of MAVSDK, and return it as a vehicle."""
    direct, changes = MavlinkDirect(system), Changes(context.clock)

    def send(system_id: int, component_id: int, message: mavlink.MAVLink_message) -> None:
        """Send one packet.

        MAVSDK's own queue of commands is not used: without an answer, it keeps repeating an older goto beside the
        newer one that has superseded it.
        """
        direct.send_message(direct_from_message(message, system_id, component_id))

    access = VehicleAccess(record, send, changes, lambda component_id: wire.host_of(record.vehicle_id, component_id))
    feed = TelemetryFeed(
        system,
        direct,
        record,
        clock=context.clock,
        dispatcher=dispatcher,
        on_change=changes.announce,
        notify=context.notify,
    )
    return MavsdkVehicle(
        access, tools, lambda: ComponentSource(system, direct, access, tools, dispatcher), context.system_id, feed
    )
