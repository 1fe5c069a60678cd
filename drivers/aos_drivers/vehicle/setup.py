"""Reading a vehicle's settings, uploading its geofence and setting its return height."""

from __future__ import annotations

import math
from collections.abc import Mapping

from aos_drivers.vehicle.autopilots.setup import Setup
from aos_drivers.vehicle.commands import Send
from aos_drivers.vehicle.exchange import Exchange
from aos_drivers.vehicle.fence.items import items_of, polygons_of
from aos_drivers.vehicle.fence.rally import RallyCount
from aos_drivers.vehicle.fence.transfer import FenceDownload, FenceUpload
from aos_drivers.vehicle.parameters.encoding import Parameter
from aos_drivers.vehicle.parameters.transfer import ParameterRead, ParameterWrite
from aos_drivers.vehicle.record import VehicleRecord
from aos_drivers.vehicle.waiting import CLOCK_RESOLUTION_S, Changes
from aos_gcs.errors import CommandRefusedError, CommandTimeoutError
from aos_gcs.geometry.heights import AboveHomeM
from aos_gcs.ports import Clock, Geofence, VehicleFacts

_VERSION_S = 2.0
"""Time to wait for the version, which is requested from the first heartbeat on."""


class SetupRunner:
    """Settings of one vehicle: the part of ``Vehicle`` that reads and writes them."""

    def __init__(self, record: VehicleRecord, send: Send, changes: Changes, clock: Clock, our_system_id: int) -> None:
        self._record = record
        self._send = send
        self._changes = changes
        self._clock = clock
        self._our_system_id = our_system_id

    async def inspect(self, deadline_s: float) -> VehicleFacts:
        """See ``Vehicle.inspect``."""
        setup = self._setup()
        found = await self._read(setup, deadline_s)
        fence = await self._read_fence(setup, found, deadline_s)
        rally = RallyCount(self._record.target, self._our_system_id)
        await self._run(rally, deadline_s)
        if not self._record.telemetry.firmware:
            self._record.request_version()
            until_s = min(deadline_s, self._clock.now_s() + _VERSION_S)
            await self._changes.wait_for(lambda: bool(self._record.telemetry.firmware), until_s)
        telemetry = self._record.telemetry
        return VehicleFacts(
            firmware=telemetry.firmware,
            board_id=telemetry.board_id,
            link_loss=setup.link_loss(found, self._our_system_id),
            low_battery=setup.low_battery(found),
            arming_checks=setup.arming_checks(found),
            other_failsafes=setup.other_failsafes(found),
            return_place=setup.return_place(found, rally.count or 0),
            fence=fence,
            at_fence=setup.at_fence(found),
            return_height_m=setup.return_height_m(found),
            return_climb_m=setup.return_climb_m(found),
            return_settings={name: found[name].value for name in setup.return_parameters(found, 0.0)},
        )

    async def upload_fence(self, fence: Geofence, deadline_s: float) -> None:
        """See ``Vehicle.upload_fence``."""
        setup, record = self._setup(), self._record
        if not fence.inclusion_deg:
            raise CommandRefusedError(f"the geofence for vehicle {record.vehicle_id} has no inclusion polygon")
        ceiling_m = fence.ceiling_above_home_m
        if ceiling_m is not None and not ceiling_m > 0.0:
            raise CommandRefusedError(
                f"the ceiling of the geofence is {-ceiling_m:.0f} m below the home of vehicle {record.vehicle_id}: "
                "nothing was written; check the altitude of the mission's origin"
            )
        upload = FenceUpload(record.target, items_of(fence, record.target), self._our_system_id)
        await self._run(upload, deadline_s)
        found = await self._read(setup, deadline_s)
        found |= await self._write(setup, found, setup.fence_parameters(found, fence.ceiling_above_home_m), deadline_s)
        stored = await self._read_fence(setup, found, deadline_s)
        if stored is None or not stored.is_same_as(fence):
            raise CommandRefusedError(
                f"vehicle {record.vehicle_id} stored a different geofence than the uploaded one: check its messages"
            )

    async def set_return_height(self, height_above_home_m: AboveHomeM, deadline_s: float) -> None:
        """See ``Vehicle.set_return_height``."""
        if not (math.isfinite(height_above_home_m) and height_above_home_m > 0.0):
            raise CommandRefusedError(
                f"a return height of {height_above_home_m} m is impossible: choose one above home"
            )
        setup = self._setup()
        found = await self._read(setup, deadline_s)
        await self._write_on_ground(setup, found, setup.return_parameters(found, height_above_home_m), deadline_s)

    async def restore_return(self, settings: Mapping[str, float], deadline_s: float) -> None:
        """See ``Vehicle.restore_return``."""
        setup = self._setup()
        found = await self._read(setup, deadline_s)
        strange = [name for name in settings if name not in setup.return_parameters(found, 0.0)]
        if strange:
            raise CommandRefusedError(f"{strange[0]} is not a return setting of vehicle {self._record.vehicle_id}")
        await self._write_on_ground(setup, found, settings, deadline_s)

    def _setup(self) -> Setup:
        record = self._record
        if record.is_ambiguous(self._clock.now_s()):
            raise CommandRefusedError(f"two vehicles use system id {record.vehicle_id}: change the id of one of them")
        if record.autopilot.setup is None:
            raise CommandRefusedError(
                f"vehicle {record.vehicle_id} is not a PX4 or ArduPilot multicopter: its parameters are not supported"
            )
        return record.autopilot.setup

    async def _read(self, setup: Setup, deadline_s: float) -> dict[str, Parameter]:
        read = ParameterRead(self._record.target, setup.encoding, setup.required, setup.optional)
        await self._run(read, deadline_s)
        if further := setup.further(read.found):
            more = ParameterRead(self._record.target, setup.encoding, further)
            await self._run(more, deadline_s)
            return {**read.found, **more.found}
        return read.found

    async def _write_on_ground(
        self, setup: Setup, found: Mapping[str, Parameter], wanted: Mapping[str, float], deadline_s: float
    ) -> None:
        if self._record.telemetry.armed:
            raise CommandRefusedError(
                f"vehicle {self._record.vehicle_id} is armed: its return settings can be changed only while disarmed"
            )
        await self._write(setup, found, wanted, deadline_s)

    async def _write(
        self, setup: Setup, found: Mapping[str, Parameter], wanted: Mapping[str, float], deadline_s: float
    ) -> dict[str, Parameter]:
        """Set what differs from ``found``, wait until the vehicle repeats it, and return it."""
        changed = {
            name: Parameter(value, found[name].kind) for name, value in wanted.items() if found[name].value != value
        }
        if changed:
            await self._run(ParameterWrite(self._record.target, setup.encoding, changed), deadline_s)
        return changed

    async def _read_fence(self, setup: Setup, found: Mapping[str, Parameter], deadline_s: float) -> Geofence | None:
        download = FenceDownload(self._record.target, self._our_system_id)
        await self._run(download, deadline_s)
        inclusions, exclusions, others = polygons_of(download.items)
        if not download.items:
            return None
        return Geofence(
            inclusion_deg=inclusions[0] if inclusions else (),
            exclusions_deg=tuple(exclusions),
            ceiling_above_home_m=setup.ceiling_m(found),
            radius_about_home_m=setup.radius_m(found),
            other_items=others + sum(map(len, inclusions[1:])),
        )

    async def _run(self, exchange: Exchange, deadline_s: float) -> None:
        """Run an exchange to its end.

        Raises:
            CommandRefusedError: the vehicle refuses.
            CommandTimeoutError: it has not ended by ``deadline_s``.
        """
        record, clock = self._record, self._clock
        record.exchanges[exchange] = None
        try:
            while not exchange.is_done:
                now_s = clock.now_s() + CLOCK_RESOLUTION_S
                if now_s >= deadline_s:
                    raise CommandTimeoutError(
                        f"vehicle {record.vehicle_id} does not {exchange.name} in time: check link and vehicle"
                    )
                for message in exchange.poll(now_s):
                    self._send(record.vehicle_id, record.target.component_id, message)
                await self._wait(exchange, deadline_s)
        finally:
            record.exchanges.pop(exchange)

    async def _wait(self, exchange: Exchange, deadline_s: float) -> None:
        """Wait until the exchange has something to do."""
        due_s = exchange.due_s
        await self._changes.wait_for(lambda: exchange.is_done or exchange.due_s < due_s, min(deadline_s, due_s))
