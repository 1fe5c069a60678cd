"""Vehicles that are displayed but never commanded."""

from __future__ import annotations

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.autopilots.base import AutopilotDialect, Step, Target
from aos_drivers.vehicle.telemetry import Telemetry
from aos_gcs.errors import CommandRefusedError
from aos_gcs.ports import Command, FlightMode


class UnknownDialect(AutopilotDialect):
    """Dialect of everything that is not a PX4 or ArduPilot multicopter."""

    name = "unknown"

    def mode(self, heartbeat: mavlink.MAVLink_heartbeat_message) -> tuple[FlightMode, str]:
        """See the base class."""
        return FlightMode.UNKNOWN, f"mode {heartbeat.custom_mode}"

    def is_ready(self, telemetry: Telemetry, now_s: float) -> bool | None:
        """See the base class."""
        del telemetry, now_s
        return None

    def steps(self, command: Command, target: Target, telemetry: Telemetry, now_s: float) -> list[Step]:
        """Refuse."""
        del telemetry, now_s
        raise CommandRefusedError(
            f"vehicle {target.system_id} is not a PX4 or ArduPilot multicopter: "
            f"{type(command).__name__} is not supported"
        )
