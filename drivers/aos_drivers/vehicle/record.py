"""Everything known about one vehicle; changed by the session, read by the vehicle's commands."""

from __future__ import annotations

import math

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.errors import FrameCounts
from aos_drivers.frames.settings import CameraSettings
from aos_drivers.links.address import PeerAddress
from aos_drivers.links.boot_time import BOOT_TIMED_IDS, boot_ms_of
from aos_drivers.links.former import FormerOwner
from aos_drivers.links.framing import without_signature
from aos_drivers.links.identity import Identity
from aos_drivers.links.ownership import Ownership
from aos_drivers.links.routes import ComponentRoute, DuplicateFilter
from aos_drivers.vehicle.autopilots.base import AutopilotDialect, Target
from aos_drivers.vehicle.autopilots.choice import dialect_of
from aos_drivers.vehicle.cameras.component_record import CAMERA_IDS, CameraRecord, camera_rank
from aos_drivers.vehicle.cameras.payload import PayloadRecord, motion_rates_hz
from aos_drivers.vehicle.control import ControlWatch
from aos_drivers.vehicle.delay import TelemetryDelay
from aos_drivers.vehicle.exchange import Exchange
from aos_drivers.vehicle.failures import ReportFailures
from aos_drivers.vehicle.status_text import StatusTexts, is_about_arming
from aos_drivers.vehicle.streams import OneTimeRequests, StreamKeeper, higher_rates
from aos_drivers.vehicle.telemetry import MOST_UNREAD, REPORT_IDS, Telemetry, has_no_position
from aos_drivers.vehicle.timesync import ClockEstimator
from aos_drivers.vehicle.transaction import CommandTransaction
from aos_gcs.ports import ComponentLink, FlightMode, LinkQuality, Notice, Severity, VehicleState

_PAUSE_S = 2.0
_ATTEMPTS = 8
_SNAPSHOT_LIFE_S = 0.05
"""Age at which the snapshot is renewed for changes without a packet, such as addresses that become silent."""
_MAX_COMPONENTS = 16
_STRANGER_PAUSE_S = 60.0
_ARMING_TEXT_S = 10.0
"""Time for which the reason of a refusal to arm is kept although the vehicle's own checks pass."""
_TARGET_IDS = (mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT, mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED)
_COMING_DOWN = frozenset({FlightMode.RETURN, FlightMode.LAND})
_HEARTBEAT, _CAMERA_INFORMATION = mavlink.MAVLINK_MSG_ID_HEARTBEAT, mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION
_INTRODUCTIONS = frozenset({_HEARTBEAT, _CAMERA_INFORMATION})
"""Messages by which a camera can be known."""


class VehicleRecord:
    """One vehicle: its autopilot component, its camera, its addresses and the open requests to it."""

    def __init__(
        self,
        target: Target,
        heartbeat: mavlink.MAVLink_heartbeat_message,
        position_hz: float,
        camera: CameraSettings | None = None,
        former: FormerOwner | None = None,
    ) -> None:
        """Request positions at ``position_hz``, and the messages that the ``camera`` needs.

        ``former`` is what is known of the vehicle from the flight that is taken up.
        """
        camera = camera or CameraSettings()
        self.target = target
        self.autopilot: AutopilotDialect = dialect_of(heartbeat)
        self._telemetry = Telemetry()
        self._unread: list[tuple[mavlink.MAVLink_message, float]] = []
        """Reports that are not taken in yet, with the times when they were sent."""
        self.control = ControlWatch()
        self.identity = Identity() if former is None else former.identity
        self.ownership = Ownership(self.identity) if former is None else former.ownership
        self.texts = StatusTexts()
        rates_hz = higher_rates(self.autopilot.stream_rates_hz(position_hz), motion_rates_hz(camera))
        self.streams = StreamKeeper(rates_hz, self.autopilot.stock_stream_ids)
        self.requests = OneTimeRequests()
        self.camera: CameraRecord | None = None
        self.failures = ReportFailures()
        self.payload = PayloadRecord(self.failures)
        self.frames = FrameCounts(camera.source)
        self.transactions: dict[CommandTransaction, None] = {}
        """Commands that await an acknowledgement."""
        self.exchanges: dict[Exchange, None] = {}
        """Exchanges of several messages in progress."""
        self.duplicates = DuplicateFilter()
        self.clock = ClockEstimator()
        self.delay = TelemetryDelay()
        self._routes = {target.component_id: ComponentRoute()}
        self.heard_at_s: float | None = None
        """Time of the autopilot's last packet: a companion's must not hide that the autopilot is silent."""
        self._packets = 0
        self._snapshot: tuple[tuple[int, str, bool], float, VehicleState] | None = None
        """Packets heard and time when it was made, and the state."""
        self.was_ambiguous = False
        self._stranger_told_at_s = -math.inf
        self._request_facts()

    @property
    def vehicle_id(self) -> int:
        """The MAVLink system id."""
        return self.target.system_id

    @property
    def telemetry(self) -> Telemetry:
        """Latest values. Reports wait until somebody asks, at most 32 of them, and are taken in as of their arrival."""
        if self._unread:
            unread, self._unread = self._unread, []
            self.failures.take_in(unread, self._telemetry.update)
        return self._telemetry

    @property
    def route(self) -> ComponentRoute:
        """Route to the autopilot."""
        return self._routes[self.target.component_id]

    def address_of(self, component_id: int) -> PeerAddress | None:
        """Return the address of a component, or the autopilot's for one that was never heard."""
        return self._routes.get(component_id, self.route).address

    def host_of(self, component_id: int) -> str:
        """Return the host of a component; empty on a serial link, or before anything was heard."""
        address = self.address_of(component_id)
        return address.host if address is not None else ""

    def admits(self, component_id: int, peer: PeerAddress, now_s: float, *, is_signed: bool = False) -> bool:
        """Return whether a packet may be the vehicle's; see ``Ownership``."""
        if component_id == self.target.component_id:
            return self.ownership.admits(peer, is_signed, now_s)
        route = self._routes.get(component_id)
        return (route is not None and route.knows(peer)) or self.ownership.admits_component(peer)

    def take_stranger(
        self, message: mavlink.MAVLink_message, peer: PeerAddress, now_s: float, *, is_signed: bool = False
    ) -> Notice | None:
        """Ignore a packet that is not admitted, but for what may prove that it is the vehicle's.

        Returns the notice about its sender, at most once a minute.
        """
        if message.get_srcComponent() == self.target.component_id:
            self.ownership.hear_stranger(message, peer, now_s, is_signed=is_signed)
            if message.get_msgId() in BOOT_TIMED_IDS:
                first = self.duplicates.sender_of(without_signature(message))
                if first is not None and first != peer:
                    self.identity.hear_twice(peer, first)
        if now_s - self._stranger_told_at_s < _STRANGER_PAUSE_S:
            return None
        self._stranger_told_at_s = now_s
        text = f"another sender, at {peer}, uses its system id: ignored. Commands go to {self.route.address}"
        return Notice(Severity.CRITICAL, text, self.vehicle_id)

    def watch_ownership(self, heartbeat: mavlink.MAVLink_heartbeat_message, peer: PeerAddress, now_s: float) -> None:
        """Give the id to the addresses of an armed vehicle, or up when it is known to be disarmed."""
        if not heartbeat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED:
            if not self.telemetry.armed:
                self.ownership.release()
        elif peer == self.route.address:
            self.ownership.claim(peer, now_s)

    def is_ambiguous(self, now_s: float) -> bool:
        """Return whether two vehicles use the id and neither owns it."""
        return not self.ownership.is_claimed and self.identity.is_ambiguous(now_s)

    def hear(
        self, component_id: int, sequence: int, peer: PeerAddress, now_s: float, *, is_signed: bool = False
    ) -> bool:
        """Count a packet; return whether the address of its component has changed."""
        self._packets += 1
        if component_id == self.target.component_id:
            sent_at_s, heard_at_s = self.delay.sent_at_s(now_s), self.heard_at_s
            if heard_at_s is None or sent_at_s > heard_at_s:
                self.heard_at_s = sent_at_s
            self.identity.hear(peer, now_s, is_signed=is_signed)
        route = self._routes.get(component_id)
        if route is None:
            if len(self._routes) >= _MAX_COMPONENTS:
                return False
            route = self._routes[component_id] = ComponentRoute()
        is_same = peer == route.address or self.identity.is_same_vehicle(peer, route.address)
        return route.hear(peer, sequence, now_s, is_same)

    def watch_delay(self, message: mavlink.MAVLink_message, now_s: float) -> None:
        """Find out how long the autopilot's messages are on their way; call it before ``hear``."""
        is_timed = self.delay.is_boot_clock and message.get_msgId() in BOOT_TIMED_IDS
        if is_timed and message.get_srcComponent() == self.target.component_id:
            self.delay.hear(boot_ms_of(message) / 1e3, now_s, self.clock)

    def take_timesync(self, message: mavlink.MAVLink_timesync_message, now_s: float) -> None:
        """Update the estimate of the vehicle's clock."""
        self.clock.on_message(message, now_s)
        self.delay.compare(self.payload.clock.offset_s(), self.clock)

    def notices(self, now_s: float) -> list[Notice]:
        """Return what is new: that telemetry begins to come late, or in time again, or cannot be read."""
        told = []
        if (text := self.delay.change(now_s)) is not None:
            told.append(Notice(Severity.WARNING if self.delay.is_late else Severity.INFO, text, self.vehicle_id))
        if (text := self.failures.text(now_s)) is not None:
            told.append(Notice(Severity.CRITICAL, text, self.vehicle_id))
        return told

    def count_unknown(self, component_id: int, sequence: int, peer: PeerAddress) -> None:
        """Count a packet of an unknown message. Its checksum cannot be tested, so it is used for nothing else."""
        route = self._routes.get(component_id)
        if route is not None:
            route.count(peer, sequence)

    def restart(self) -> None:
        """Forget what does not survive a reboot of the autopilot, and request it again."""
        self._telemetry = self.telemetry.after_restart()
        self.clock, self.delay = ClockEstimator(), TelemetryDelay()
        self.streams.restart()
        self._request_facts()

    def request_version(self) -> None:
        """Request version and identity of the board."""
        self.requests.want(self.target.component_id, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION, _PAUSE_S, _ATTEMPTS)

    def take_heartbeat(self, heartbeat: mavlink.MAVLink_heartbeat_message, now_s: float) -> None:
        """Update mode, motors and control from a heartbeat of the autopilot, unless it is the only one of a landing."""
        telemetry, was_armed = self.telemetry, self.telemetry.armed
        is_armed = bool(heartbeat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
        if not telemetry.take_armed(is_armed, self.delay.sent_at_s(now_s)):
            return
        telemetry.round_trip_s = self.clock.longest_delay_s(now_s)
        autopilot = self.autopilot = dialect_of(heartbeat)
        telemetry.mode, telemetry.mode_name = autopilot.mode(heartbeat)
        is_old = telemetry.text_at_s is not None and now_s - telemetry.text_at_s > _ARMING_TEXT_S
        if is_about_arming(telemetry.text) and (
            (telemetry.armed and not was_armed) or (telemetry.prearm_healthy and is_old)
        ):
            telemetry.text = ""
        self.control.take_height(telemetry.height_above_home_m)
        self.control.take_heartbeat(
            telemetry.mode_name,
            heartbeat,
            autopilot.our_modes(),
            now_s,
            comes_down=telemetry.mode in _COMING_DOWN,
            reports_targets=telemetry.mode in autopilot.modes_with_target,
        )
        if is_armed and not was_armed:  # it moves its home then, and may report that only once
            self._request_home()
        if self.control.misses_target:  # unless another station has changed the rates, it has none
            message_id = mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED
            self.requests.want(self.target.component_id, message_id, 1.0, _ATTEMPTS)

    def take_telemetry(self, message: mavlink.MAVLink_message, message_id: int, now_s: float) -> None:
        """Update telemetry and control from a message of the autopilot."""
        sent_at_s, unread = self.delay.sent_at_s(now_s), self._unread
        if message_id in REPORT_IDS:
            unread.append((message, sent_at_s))
        if message_id not in _TARGET_IDS and len(unread) < MOST_UNREAD:
            return
        telemetry = self.telemetry
        if message_id in _TARGET_IDS:
            self.control.hear_target()
        if message_id == mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT:
            if telemetry.target is not None and telemetry.target.at_s == sent_at_s:
                self.control.take_target(telemetry.target.position, now_s)
        elif message_id == mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED and has_no_position(message):
            self.control.take_target(None, now_s)

    def take_warning(self, text: str, now_s: float) -> None:
        """Update telemetry and control from a status text of severity warning or worse."""
        self.telemetry.text, self.telemetry.text_at_s = text, now_s
        self.control.take_text(text)

    def take_payload(self, message: mavlink.MAVLink_message, message_id: int, component_id: int, now_s: float) -> None:
        """Update poses, exposures and the camera component from a message of a component."""
        if message_id in _INTRODUCTIONS:
            self._find_camera(message, message_id, component_id)
        if self.camera is not None and component_id == self.camera.component_id:
            self.camera.update(message, now_s)
        of_autopilot = component_id == self.target.component_id
        self.payload.update(message, message_id, now_s, self.clock.offset_s, of_autopilot=of_autopilot)

    def _find_camera(self, message: mavlink.MAVLink_message, message_id: int, component_id: int) -> None:
        """Take the sender of ``message`` as the camera if it is one; of several, the first by ``camera_rank`` wins."""
        is_camera = message_id == _CAMERA_INFORMATION or (
            message_id == _HEARTBEAT and message.type == mavlink.MAV_TYPE_CAMERA and component_id in CAMERA_IDS
        )
        if is_camera and (self.camera is None or camera_rank(component_id) < camera_rank(self.camera.component_id)):
            self.camera = CameraRecord(component_id)
            for wanted_id in (_CAMERA_INFORMATION, mavlink.MAVLINK_MSG_ID_CAMERA_CAPTURE_STATUS):
                self.requests.want(component_id, wanted_id, _PAUSE_S, _ATTEMPTS)

    def due_requests(self, now_s: float) -> list[tuple[int, int, tuple[float, ...]]]:
        """Return the requests that are due: component, command and its parameters."""
        due: list[tuple[int, int, tuple[float, ...]]] = []
        for message_id, interval_us in self.streams.due(now_s):
            params = float(message_id), interval_us
            due.append((self.target.component_id, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, params))
        for component_id, message_id in self.requests.poll(now_s):
            due.append((component_id, mavlink.MAV_CMD_REQUEST_MESSAGE, (float(message_id),)))
        gap = self.camera.poll_gaps(now_s) if self.camera is not None else None
        if self.camera is not None and gap is not None:
            captured, (first, last) = mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED, gap
            wanted = float(captured), float(first), float(last if last > first else 0)
            due.append((self.camera.component_id, mavlink.MAV_CMD_REQUEST_MESSAGE, wanted))
        return due

    def loss_fraction(self) -> float | None:
        """Return the share of lost packets over all components, each at the address where it is spoken to."""
        counters = [route.loss for route in self._routes.values()]
        lost = sum(counter.lost for counter in counters)
        total = lost + sum(counter.received for counter in counters)
        return lost / total if total else None

    def link_quality(self, now_s: float) -> LinkQuality | None:
        """Return the quality of the link to the autopilot; None if its packets take no route of ours."""
        if self.route.address is None:
            return None
        return LinkQuality(
            address=str(self.route.address),
            living_addresses=self.route.living(now_s),
            round_trip_s=self.clock.round_trip_s,
            clock_offset_s=self.clock.offset_s,
            clock_drift=self.clock.drift,
            telemetry_delay_s=self.delay.present_s(now_s),
        )

    def state(self, now_s: float) -> VehicleState:
        """Return the snapshot that crosses the port: made anew when a packet has come, and when it gets old.

        The mission asks for it hundreds of times between two packets; what ``reclaim`` changes shows at once.
        """
        made_from = (self._packets, self.control.reason, self.control.has_pilot)
        if self._snapshot is not None:
            former, made_at_s, state = self._snapshot
            if former == made_from and 0.0 <= now_s - made_at_s < _SNAPSHOT_LIFE_S:
                return state
        self._snapshot = made_from, now_s, self._state_now(now_s)
        return self._snapshot[-1]

    def _state_now(self, now_s: float) -> VehicleState:
        telemetry = self.telemetry
        return VehicleState(
            vehicle_id=self.vehicle_id,
            autopilot=self.autopilot.name,
            mode=telemetry.mode,
            mode_name=telemetry.mode_name,
            armed=telemetry.armed,
            armed_at_s=telemetry.heartbeat_at_s,
            landed=telemetry.landed,
            landed_at_s=telemetry.landed_at_s,
            ready_to_arm=self.autopilot.is_ready(telemetry, now_s),
            position=telemetry.position,
            position_at_s=telemetry.position_at_s,
            position_jumps_m=telemetry.jumps.total_m,
            height_above_home_m=telemetry.height_above_home_m,
            velocity_enu_mps=telemetry.velocity_enu_mps,
            heading_rad=telemetry.heading_rad,
            home=telemetry.home,
            battery_fraction=telemetry.battery_fraction,
            battery_at_s=telemetry.battery_at_s,
            battery_voltage_v=telemetry.battery_voltage_v,
            gps_fix=telemetry.gps_fix,
            satellites=telemetry.satellites,
            heard_at_s=self.heard_at_s,
            components=self._component_links(),
            packet_loss_fraction=self.loss_fraction(),
            link=self.link_quality(now_s),
            camera=self.frames.state(),
            text=telemetry.text,
            hdop=telemetry.hdop,
            horizontal_accuracy_m=telemetry.horizontal_accuracy_m,
            vertical_accuracy_m=telemetry.vertical_accuracy_m,
            altitude_test_ratio=telemetry.altitude_test_ratio,
            gps_altitude_amsl_m=telemetry.gps_altitude_amsl_m,
            pressure_hpa=telemetry.pressure_hpa,
            is_ambiguous=self.is_ambiguous(now_s),
            estimator_problem=self.autopilot.estimator_problem(telemetry),
            vibration_mps2=telemetry.vibration_mps2,
            taken_over=self.control.reason,
            has_pilot=self.control.has_pilot,
            failsafe=self.control.failsafe,
            proven=self.ownership.proofs(now_s),
            board_id=telemetry.board_id,
        )

    def _component_links(self) -> tuple[ComponentLink, ...]:
        return tuple(
            ComponentLink(component_id, component_name(component_id), route.heard_at_s)
            for component_id, route in sorted(self._routes.items())
            if component_id != self.target.component_id
        )

    def _request_facts(self) -> None:
        self._request_home()
        self.request_version()

    def _request_home(self) -> None:
        self.requests.want(self.target.component_id, mavlink.MAVLINK_MSG_ID_HOME_POSITION, _PAUSE_S, math.inf)


def component_name(component_id: int) -> str:
    """Return MAVLink's name of a component in words, such as "camera2" or "onboard computer"."""
    entry = mavlink.enums["MAV_COMPONENT"].get(component_id)
    return "" if entry is None else entry.name.removeprefix("MAV_COMP_ID_").replace("_", " ").lower()
