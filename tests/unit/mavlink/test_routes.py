"""Several links per vehicle: which one is used, and what is counted once."""

from __future__ import annotations

import hypothesis.strategies as st
from hypothesis import given, settings
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.links.framing import FrameParser
from aos_drivers.links.identity import Identity
from aos_drivers.links.routes import SILENT_S, ComponentRoute, DuplicateFilter
from aos_drivers.mavlink.session import Event, MavlinkSession
from aos_gcs.ports import Notice, Severity
from tests.fakes.mavlink_vehicle import FakeVehicle

WIFI, RADIO = PeerAddress(0, "10.0.0.1", 5001), PeerAddress(1, "/dev/ttyUSB0", 57600)
UID_A, UID_B = b"a" * 8, b"b" * 8


def criticals(events: list[Event]) -> list[str]:
    return [event.text for event in events if isinstance(event, Notice) and event.severity is Severity.CRITICAL]


def asked_for_version(session: MavlinkSession) -> set[PeerAddress]:
    return {
        outgoing.peer
        for outgoing in session.take_outgoing()
        for message in FrameParser().feed(outgoing.packet)
        if message.get_type() == "COMMAND_LONG"
        and (message.command, message.param1)
        == (mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION)
    }


def commanded_at(session: MavlinkSession) -> PeerAddress:
    session.take_outgoing()
    session.send(1, 1, mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))
    (outgoing,) = session.take_outgoing()
    return outgoing.peer


class TwoPorts:
    """A vehicle with two telemetry ports: own sequence numbers on each, one board behind both."""

    def __init__(self) -> None:
        self.session = MavlinkSession(254, 5.0)
        self.vehicles = {WIFI: FakeVehicle(1), RADIO: FakeVehicle(1)}
        self.vehicles[RADIO].encoder.skip(100)
        self.events: list[Event] = []

    def fly(self, from_s: float, to_s: float, links: tuple[PeerAddress, ...], answers: bool = True) -> None:
        for tick in range(round(from_s * 10), round(to_s * 10)):
            for peer in links:
                vehicle = self.vehicles[peer]
                vehicle.boot_ms = tick * 100
                self.events += self.session.feed(vehicle.heartbeat() + vehicle.position(), peer, tick / 10)
            self.events += self.session.poll(tick / 10)
            for peer in asked_for_version(self.session) if answers else ():
                if peer in links:
                    self.events += self.session.feed(self.vehicles[peer].version(), peer, tick / 10)


def test_a_vehicle_with_two_links_is_one_vehicle_and_stays_at_the_first() -> None:
    flight = TwoPorts()
    flight.fly(0.0, 20.0, (WIFI, RADIO))
    assert criticals(flight.events) == []
    assert list(flight.session.records) == [1]
    assert commanded_at(flight.session) == WIFI
    assert flight.session.records[1].route.living(20.0) == 2


def test_a_silent_link_is_left_for_the_living_one_within_its_time() -> None:
    flight = TwoPorts()
    flight.fly(0.0, 10.0, (WIFI, RADIO))
    flight.fly(10.0, 10.0 + SILENT_S + 0.2, (RADIO,))
    assert commanded_at(flight.session) == RADIO
    assert f"is now reached at {RADIO}" in [event.text for event in flight.events if isinstance(event, Notice)]
    flight.fly(12.2, 20.0, (WIFI, RADIO))
    assert commanded_at(flight.session) == RADIO, "a link that is as good as the other is no reason to change"


def test_the_streams_are_requested_on_the_link_that_is_used_now() -> None:
    flight = TwoPorts()
    flight.fly(0.0, 10.0, (WIFI, RADIO))
    flight.fly(10.0, 12.0, (RADIO,))
    vehicle = flight.vehicles[RADIO]
    vehicle.boot_ms += 100
    flight.session.feed(vehicle.position(), RADIO, 12.1)
    flight.session.take_outgoing()
    flight.session.poll(12.2)
    assert [outgoing.peer for outgoing in flight.session.take_outgoing()][:1] == [RADIO]


def test_two_ports_without_a_board_identity_are_two_vehicles_until_it_comes() -> None:
    flight = TwoPorts()
    flight.fly(0.0, 5.0, (WIFI, RADIO), answers=False)
    assert len(criticals(flight.events)) == 1
    flight.session.feed(flight.vehicles[WIFI].version(), WIFI, 5.0)
    flight.session.feed(flight.vehicles[RADIO].version(), RADIO, 5.0)
    assert not flight.session.records[1].identity.is_ambiguous(5.0)


def test_the_same_packets_over_two_links_count_once_and_prove_one_vehicle() -> None:
    session = MavlinkSession(254, 5.0)
    vehicle = FakeVehicle(1)
    events: list[Event] = []
    for tick in range(200):
        vehicle.boot_ms += 100
        packets = vehicle.heartbeat() + vehicle.position()
        events += session.feed(packets, WIFI, tick / 10)
        events += session.feed(packets, RADIO, tick / 10 + 0.05)
        events += session.poll(tick / 10 + 0.06)
    assert criticals(events) == []
    packets_counted = sum(isinstance(event, tuple) for event in events)
    assert packets_counted <= 400 + 2, "only those before the second address was known may count twice"
    assert session.records[1].loss_fraction() == 0.0


def test_other_boards_behind_two_addresses_are_never_the_same_vehicle() -> None:
    identity = Identity()
    for address, uid in ((WIFI, UID_A), (RADIO, UID_B)):
        identity.hear(address, 0.0)
        identity.hear_uid(address, uid, 0.0)
    for _ in range(10):
        identity.hear_twice(RADIO, WIFI)
    assert not identity.is_same_vehicle(WIFI, RADIO)
    assert identity.is_ambiguous(1.0)


def test_two_vehicles_with_one_board_identity_are_told_apart_by_when_they_started() -> None:
    """All PX4 in simulation have the same identity."""
    session = MavlinkSession(254, 5.0)
    first, second = FakeVehicle(1), FakeVehicle(1)
    second.boot_ms += 60_000
    second.encoder.skip(100)
    events: list[Event] = []
    for tick in range(60):
        for vehicle, peer in ((first, WIFI), (second, RADIO)):
            vehicle.boot_ms += 100
            version = vehicle.version() if tick == 5 else b""
            events += session.feed(vehicle.heartbeat() + vehicle.position() + version, peer, tick / 10)
        events += session.poll(tick / 10)
    assert len(criticals(events)) == 1
    assert session.records[1].identity.is_ambiguous(6.0)


def test_a_restart_of_a_vehicle_on_two_links_is_one_restart_and_no_second_vehicle() -> None:
    flight = TwoPorts()
    flight.fly(0.0, 20.0, (WIFI, RADIO))
    for vehicle in flight.vehicles.values():
        vehicle.boot_ms = 0
    for tick in range(60):
        for peer, vehicle in flight.vehicles.items():
            vehicle.boot_ms += 100
            flight.events += flight.session.feed(vehicle.heartbeat() + vehicle.position(), peer, 20.0 + tick / 10)
        flight.events += flight.session.poll(20.0 + tick / 10)
    told = [event.text for event in flight.events if isinstance(event, Notice)]
    assert told.count("has restarted") == 1
    assert criticals(flight.events) == []


def test_a_link_that_loses_clearly_less_is_preferred_but_only_for_the_same_vehicle() -> None:
    for is_same in (True, False):
        route = ComponentRoute()
        for number in range(300):
            if number % 2 == 0:
                route.hear(WIFI, number % 256, number / 10, is_same_vehicle=True)
            route.hear(RADIO, number % 256, number / 10, is_same_vehicle=is_same)
        assert route.address == (RADIO if is_same else WIFI)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 30), st.floats(0.0, 3.0), st.booleans()), min_size=1, max_size=200))
def test_a_route_is_always_an_address_that_was_heard_and_never_a_dead_one(
    packets: list[tuple[int, float, bool]],
) -> None:
    route = ComponentRoute()
    heard_at_s: dict[PeerAddress, float] = {}
    now_s = 0.0
    for number, (sender, pause_s, is_same) in enumerate(packets):
        now_s += pause_s
        address = PeerAddress(0, "h", sender)
        heard_at_s[address] = now_s
        route.hear(address, number % 256, now_s, is_same)
        assert route.address is not None
        assert now_s - heard_at_s[route.address] <= SILENT_S
        assert len(route._paths) <= 8


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(st.binary(max_size=2), st.booleans(), st.floats(0.0, 0.01)), max_size=1500))
def test_a_packet_is_a_duplicate_only_from_another_address_and_memory_is_bounded(
    packets: list[tuple[bytes, bool, float]],
) -> None:
    duplicates = DuplicateFilter()
    now_s = 0.0
    for content, is_radio, pause_s in packets:
        now_s += pause_s
        address = RADIO if is_radio else WIFI
        assert duplicates.first_sender(content, address, now_s) != address
        assert len(duplicates._seen) <= 1024


def test_the_same_packet_after_the_window_is_new() -> None:
    duplicates = DuplicateFilter()
    assert duplicates.first_sender(b"packet", WIFI, 0.0) is None
    assert duplicates.first_sender(b"packet", RADIO, 0.9) == WIFI
    assert duplicates.first_sender(b"packet", RADIO, 1.1) is None
