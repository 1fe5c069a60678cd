"""Telemetry that MAVSDK reports for one vehicle, written into its record."""

from __future__ import annotations

import math
from collections.abc import Callable

from mavsdk.plugins import telemetry as plugin
from mavsdk.plugins.mavlink_direct import MavlinkDirect, MavlinkMessage
from mavsdk.system import System
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.mavsdk.core import LoopDispatcher, message_from_direct
from aos_drivers.vehicle.position_report import position_from_e7
from aos_drivers.vehicle.record import VehicleRecord
from aos_drivers.vehicle.status_text import notice_severity
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AboveHomeM, AmslM
from aos_gcs.ports import Clock, LandedState, Notice

_LANDED = {
    plugin.LandedState.ON_GROUND: LandedState.ON_GROUND,
    plugin.LandedState.IN_AIR: LandedState.IN_AIR,
    plugin.LandedState.TAKING_OFF: LandedState.TAKING_OFF,
    plugin.LandedState.LANDING: LandedState.LANDING,
}
_DIRECT = (
    "HEARTBEAT",
    "COMMAND_ACK",
    "EKF_STATUS_REPORT",
    "ESTIMATOR_STATUS",
    "GPS_RAW_INT",
    "POSITION_TARGET_GLOBAL_INT",
    "POSITION_TARGET_LOCAL_NED",
    "SCALED_PRESSURE",
    "VIBRATION",
)
"""Messages with data that the telemetry plugin lacks: the autopilot's own mode and target, the state of its estimator,
the quality of its satellite fix and what its barometer measures."""


class TelemetryFeed:
    """Subscriptions to one vehicle that keep its record up to date. Policy: newer values replace older ones."""

    def __init__(
        self,
        system: System,
        direct: MavlinkDirect,
        record: VehicleRecord,
        *,
        clock: Clock,
        dispatcher: LoopDispatcher,
        on_change: Callable[[], None],
        notify: Callable[[Notice], None],
    ) -> None:
        """``on_change`` is called after every value; ``notify`` takes the vehicle's status texts."""
        self._record = record
        self._clock = clock
        self._on_change = on_change
        self._notify = notify
        self._plugin = plugin.Telemetry(system)
        self._subscribe(direct, dispatcher)

    def _subscribe(self, direct: MavlinkDirect, dispatcher: LoopDispatcher) -> None:
        handlers = {
            self._plugin.subscribe_position: self._take_position,
            self._plugin.subscribe_velocity_ned: self._take_velocity,
            self._plugin.subscribe_heading: self._take_heading,
            self._plugin.subscribe_home: self._take_home,
            self._plugin.subscribe_landed_state: self._take_landed,
            self._plugin.subscribe_battery: self._take_battery,
            self._plugin.subscribe_health: self._take_health,
            self._plugin.subscribe_status_text: self._take_text,
        }
        for subscribe, handler in handlers.items():
            subscribe(dispatcher.to_loop(self._announced(handler)))
        for name in _DIRECT:
            direct.subscribe_message(name, dispatcher.to_loop(self._announced(self._take_direct)))

    def _announced(self, handler: Callable[..., None]) -> Callable[..., None]:
        def handle(value: object) -> None:
            handler(value)
            self._on_change()

        return handle

    def _take_position(self, position: plugin.Position) -> None:
        telemetry = self._record.telemetry
        is_taken = telemetry.take_position(geodetic(position), self._sent_at_s())
        if is_taken and math.isfinite(position.relative_altitude_m):
            telemetry.relative_altitude_m = AboveHomeM(position.relative_altitude_m)

    def _take_velocity(self, velocity: plugin.VelocityNed) -> None:
        velocity_enu_mps = (velocity.east_m_s, velocity.north_m_s, -velocity.down_m_s)
        if all(map(math.isfinite, velocity_enu_mps)):
            self._record.telemetry.velocity_enu_mps = velocity_enu_mps

    def _take_heading(self, heading: plugin.Heading) -> None:
        if math.isfinite(heading.heading_deg):
            self._record.telemetry.heading_rad = math.radians(heading.heading_deg % 360.0)

    def _take_home(self, home: plugin.HomePosition) -> None:
        telemetry = self._record.telemetry
        telemetry.home = geodetic(home) or telemetry.home

    def _take_landed(self, landed: plugin.LandedState) -> None:
        self._record.telemetry.take_landed(_LANDED.get(landed, LandedState.UNKNOWN), self._sent_at_s())

    def _take_battery(self, battery: plugin.Battery) -> None:
        telemetry = self._record.telemetry
        if battery.id == 0 and 0.0 <= battery.remaining_percent <= 100.0:
            telemetry.battery_fraction = battery.remaining_percent / 100.0
            telemetry.battery_at_s = self._clock.now_s()
        if battery.id == 0 and battery.voltage_v > 0.0:
            telemetry.battery_voltage_v = battery.voltage_v

    def _take_health(self, health: plugin.Health) -> None:
        self._record.telemetry.prearm_healthy = health.is_armable

    def _take_text(self, status: plugin.StatusText) -> None:
        # MAVSDK counts from debug up, MAVLink from emergency down.
        severity = mavlink.MAV_SEVERITY_DEBUG - int(status.type)
        text = status.text.strip()
        if severity == mavlink.MAV_SEVERITY_DEBUG or not text:
            return
        if severity <= mavlink.MAV_SEVERITY_WARNING:
            self._record.take_warning(text, self._clock.now_s())
        self._notify(Notice(notice_severity(severity, text), text, self._record.vehicle_id))

    def _sent_at_s(self) -> float:
        """Return when the message that is processed now was sent."""
        return self._record.delay.sent_at_s(self._clock.now_s())

    def _take_direct(self, direct: MavlinkMessage) -> None:
        record, now_s = self._record, self._clock.now_s()
        message = message_from_direct(direct)
        if direct.message_name == "COMMAND_ACK":
            for transaction in record.transactions:
                transaction.on_ack(message, (direct.system_id, direct.component_id), now_s)
            if message.command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
                record.streams.on_ack()
        elif direct.component_id != record.target.component_id:
            return
        elif direct.message_name == "HEARTBEAT":
            record.take_heartbeat(message, now_s)
        else:
            record.take_telemetry(message, message.get_msgId(), now_s)


def geodetic(position: plugin.Position | plugin.HomePosition) -> GeodeticPosition | None:
    """Return one of MAVSDK's positions, or None for what means "unknown"."""
    latitude_deg, longitude_deg, altitude_amsl_m = (
        position.latitude_deg,
        position.longitude_deg,
        position.absolute_altitude_m,
    )
    if not all(map(math.isfinite, (latitude_deg, longitude_deg, altitude_amsl_m))):
        return None
    return position_from_e7(round(latitude_deg * 1e7), round(longitude_deg * 1e7), AmslM(altitude_amsl_m))
