"""Addresses that vehicles are heard from, and whose identity they have."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.mavlink.session import Event
from aos_gcs.ports import Severity
from tests.fakes.mavlink_session import decoded, new_session, notices
from tests.fakes.mavlink_vehicle import FakeVehicle

A, B = PeerAddress(0, "10.0.0.1", 5001), PeerAddress(0, "10.0.0.2", 5002)


# --- routes ---------------------------------------------------------------------------------------------------------


def test_messages_go_to_the_address_of_their_vehicle_alone() -> None:
    session = new_session()
    session.feed(FakeVehicle(1).heartbeat(), A, 0.0)
    session.feed(FakeVehicle(2).heartbeat(), B, 0.0)
    session.take_outgoing()
    session.send(2, 1, mavlink.MAVLink_command_long_message(2, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))
    assert [peer for peer, _message in decoded(session.take_outgoing())] == [B]
    session.feed(FakeVehicle(2).heartbeat(), A, 20.0)
    session.take_outgoing()
    session.send(2, 1, mavlink.MAVLink_command_long_message(2, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))
    assert [peer for peer, _message in decoded(session.take_outgoing())] == [A]


def test_our_heartbeat_goes_once_to_each_address_with_vehicles_and_to_called_ones() -> None:
    session = new_session()
    called = PeerAddress(1, "10.0.0.9", 14550)
    session.add_peer(called)
    session.feed(FakeVehicle(1).heartbeat() + FakeVehicle(2).heartbeat(), A, 0.0)
    session.feed(b"noise", B, 0.0)
    session.take_outgoing()
    assert session.is_heartbeat_due(0.0)
    session.send_heartbeat(0.0)
    sent = decoded(session.take_outgoing())
    assert sorted(peer for peer, _message in sent) == [A, called]
    heartbeat = sent[0][1]
    assert (heartbeat.type, heartbeat.get_srcSystem(), heartbeat.get_srcComponent()) == (mavlink.MAV_TYPE_GCS, 254, 190)
    assert not session.is_heartbeat_due(0.9)
    assert session.is_heartbeat_due(1.0)


def test_peers_are_bounded_and_those_with_vehicles_stay() -> None:
    session = new_session()
    session.feed(FakeVehicle(1).heartbeat(), A, 0.0)
    for port in range(2000):
        session.feed(b"?", PeerAddress(0, "10.9.9.9", port), 1.0 + port)
    assert len(session._peers) == 512
    assert A in session._peers


def test_noise_of_one_peer_does_not_touch_another() -> None:
    session = new_session()
    packet = FakeVehicle(1).heartbeat()
    session.feed(packet[:10], A, 0.0)
    session.feed(b"\xfd\xff\x00" + bytes(40), B, 0.0)
    session.feed(packet[10:], A, 0.0)
    assert list(session.records) == [1]


def test_loss_is_counted_per_component() -> None:
    session = new_session()
    vehicle = FakeVehicle()
    for number in range(40):
        session.feed(vehicle.heartbeat() + vehicle.camera_heartbeat(), A, float(number))
        vehicle.encoder.skip(1)
    loss = session.records[1].state(40.0).packet_loss_fraction
    assert loss == pytest.approx(39 / (39 + 80))


# --- identity -------------------------------------------------------------------------------------------------------


def test_two_living_addresses_with_one_id_are_critical_until_one_is_silent() -> None:
    session = new_session()
    first, second = FakeVehicle(1), FakeVehicle(1)
    events: list[Event] = []
    for step in range(4):
        events += session.feed(first.heartbeat(), A, step * 1.0)
        events += session.feed(second.heartbeat(), B, step * 1.0 + 0.5)
    events += session.poll(4.0)
    assert [notice.severity for notice in notices(events) if notice.severity is Severity.CRITICAL] == [
        Severity.CRITICAL
    ]
    assert session.records[1].identity.is_ambiguous(4.0)
    for step in range(20):
        session.feed(first.heartbeat(), A, 4.0 + step)
        session.poll(4.0 + step)
    assert not session.records[1].identity.is_ambiguous(24.0)


def test_another_board_at_a_second_address_is_ambiguous_at_once() -> None:
    session = new_session()
    first, second = FakeVehicle(1), FakeVehicle(1)
    second.uid = 77
    session.feed(first.heartbeat() + first.version(), A, 0.0)
    events = session.feed(second.heartbeat() + second.version(), B, 0.2)
    assert [notice.severity for notice in notices(events)] == [Severity.CRITICAL]


def test_a_vehicle_that_moves_to_another_address_is_still_itself() -> None:
    session = new_session()
    vehicle = FakeVehicle(1)
    session.feed(vehicle.heartbeat() + vehicle.version(), A, 0.0)
    session.feed(vehicle.heartbeat() + vehicle.version(), B, 1.0)
    session.feed(vehicle.heartbeat(), B, 2.0)
    assert not session.records[1].identity.is_ambiguous(2.0)
