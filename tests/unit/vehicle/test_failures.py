"""Reports that cannot be taken in: what is lost, and who is told."""

from __future__ import annotations

import logging
from collections.abc import Callable

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.vehicle import telemetry
from aos_drivers.vehicle.cameras import payload
from aos_gcs.ports import LandedState, Severity
from tests.fakes.mavlink_session import decoded, new_session, notices
from tests.fakes.mavlink_vehicle import FakeVehicle

A = PeerAddress(0, "10.0.0.1", 5001)
POSITION = mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT


def fail(*_: object) -> None:
    raise ZeroDivisionError("of a test")


@pytest.mark.parametrize("handlers", [telemetry._HANDLERS, payload._HANDLERS], ids=["telemetry", "motion"])
def test_a_report_that_fails_costs_none_of_those_that_waited_with_it(
    handlers: dict[int, Callable[..., None]], monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    session, vehicle = new_session(), FakeVehicle()
    session.feed(vehicle.telemetry(), A, 0.0)
    record = session.records[1]
    assert record.telemetry.position is not None
    assert record.payload.clock.offset_s(None) is not None
    monkeypatch.setitem(handlers, POSITION, fail)
    vehicle.landed, vehicle.height_m = mavlink.MAV_LANDED_STATE_IN_AIR, 12.0
    for number in range(3):
        session.feed(vehicle.position() + vehicle.gps(fix=4) + vehicle.extended_state(), A, 1.0 + number / 10)
    assert record.telemetry.gps_fix == 4
    assert record.telemetry.landed is LandedState.IN_AIR
    assert record.payload.clock.offset_s(None) is not None
    assert record.failures.count == 3
    told = [each for each in notices(session.poll(2.0)) if each.severity is Severity.CRITICAL]
    (notice,) = told
    assert notice.vehicle_id == 1
    assert "GLOBAL_POSITION_INT: ZeroDivisionError('of a test')" in notice.text
    assert "failed at 3 packets" in notice.text
    (logged,) = [each for each in caplog.records if each.levelno >= logging.ERROR]
    assert logged.exc_info


def test_reports_that_go_on_failing_are_told_once_a_minute(monkeypatch: pytest.MonkeyPatch) -> None:
    session, vehicle = new_session(), FakeVehicle()
    monkeypatch.setitem(telemetry._HANDLERS, POSITION, fail)
    told = []
    for second in range(125):
        session.feed(vehicle.heartbeat() + vehicle.position(), A, float(second))
        assert session.records[1].telemetry.position is None
        told += [each.text for each in notices(session.poll(float(second))) if each.severity is Severity.CRITICAL]
    assert [text.split(" at ")[1].split(" ")[0] for text in told] == ["1", "61", "121"]


def test_a_packet_that_fails_ends_no_link_and_costs_no_packet_behind_it(monkeypatch: pytest.MonkeyPatch) -> None:
    session, vehicle = new_session(), FakeVehicle()
    session.feed(vehicle.telemetry(), A, 0.0)
    record = session.records[1]
    monkeypatch.setattr(record.texts, "feed", fail)
    session.feed(vehicle.status_text("words") + vehicle.gps(fix=4), A, 1.0)
    assert record.telemetry.gps_fix == 4
    (text,) = [each.text for each in notices(session.poll(1.0)) if each.severity is Severity.CRITICAL]
    assert "STATUSTEXT: ZeroDivisionError" in text


def test_a_packet_of_a_stranger_that_fails_is_told_without_a_vehicle(monkeypatch: pytest.MonkeyPatch) -> None:
    session = new_session()
    monkeypatch.setattr(session, "_find_vehicle", fail)
    session.feed(FakeVehicle().heartbeat(), A, 1.0)
    (notice,) = notices(session.poll(1.0))
    assert (notice.vehicle_id, notice.severity) == (None, Severity.CRITICAL)
    assert "HEARTBEAT: ZeroDivisionError" in notice.text


def test_a_vehicle_whose_requests_fail_ends_no_heartbeats_and_no_requests_to_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session, other = new_session(), PeerAddress(0, "10.0.0.2", 5002)
    session.feed(FakeVehicle(1).heartbeat(), A, 0.0)
    session.feed(FakeVehicle(2).heartbeat(), other, 0.0)
    monkeypatch.setattr(session.records[1], "due_requests", fail)
    told = [each for each in notices(session.poll(1.0)) if each.severity is Severity.CRITICAL]
    assert [each.vehicle_id for each in told] == [1]
    assert other in {peer for peer, _message in decoded(session.take_outgoing())}
    session.send_heartbeat(1.0)
    assert {peer for peer, _message in decoded(session.take_outgoing())} == {A, other}
