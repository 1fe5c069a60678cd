"""Reports that one forged packet must not bring about: landings, stopped motors, positions far away."""

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.mavlink.session import MavlinkSession
from aos_gcs.ports import LandedState
from tests.fakes.mavlink_vehicle import FakeVehicle

A = PeerAddress(0, "10.0.0.1", 5001)


def flying() -> tuple[MavlinkSession, FakeVehicle]:
    session, vehicle = MavlinkSession(254, 5.0), FakeVehicle()
    vehicle.armed, vehicle.landed = True, mavlink.MAV_LANDED_STATE_IN_AIR
    hear(session, vehicle, 0.0, 3.0)
    return session, vehicle


def hear(session: MavlinkSession, vehicle: FakeVehicle, from_s: float, until_s: float) -> None:
    """Receive telemetry once a second."""
    while from_s <= until_s:
        vehicle.boot_ms = round(1000 * (100.0 + from_s))
        session.feed(vehicle.telemetry(), A, from_s)
        from_s += 1.0


def forge_landing(session: MavlinkSession, vehicle: FakeVehicle, now_s: float, times: int = 1) -> None:
    vehicle.armed, vehicle.landed = False, mavlink.MAV_LANDED_STATE_ON_GROUND
    for _ in range(times):
        session.feed(vehicle.telemetry(), A, now_s)
    vehicle.armed, vehicle.landed = True, mavlink.MAV_LANDED_STATE_IN_AIR


def test_one_forged_landing_counts_for_nothing() -> None:
    session, vehicle = flying()
    forge_landing(session, vehicle, 3.5, times=5)  # copies of it, too
    state = session.records[1].state(3.6)
    assert (state.armed, state.landed) == (True, LandedState.IN_AIR)
    assert session.records[1].ownership.is_claimed
    hear(session, vehicle, 4.0, 5.0)
    forge_landing(session, vehicle, 5.5)  # the genuine reports between them deny both
    state = session.records[1].state(5.6)
    assert (state.armed, state.landed) == (True, LandedState.IN_AIR)


def test_a_take_over_outlives_one_forged_report_of_stopped_motors() -> None:
    session, vehicle = flying()
    vehicle.custom_mode = 16  # POSHOLD
    hear(session, vehicle, 4.0, 4.0)
    assert session.records[1].state(4.1).taken_over
    forge_landing(session, vehicle, 4.5)
    assert session.records[1].state(4.6).taken_over


def test_a_landing_counts_from_the_second_report() -> None:
    session, vehicle = flying()
    vehicle.armed, vehicle.landed = False, mavlink.MAV_LANDED_STATE_ON_GROUND
    hear(session, vehicle, 4.0, 5.0)
    state = session.records[1].state(5.1)
    assert (state.armed, state.landed, state.armed_at_s, state.landed_at_s) == (False, LandedState.ON_GROUND, 5.0, 5.0)


def test_one_position_far_away_is_not_believed_and_two_are() -> None:
    session, vehicle = flying()
    here = session.records[1].state(3.0).position
    vehicle.latitude_deg += 0.001
    session.feed(vehicle.position(), A, 3.2)
    assert session.records[1].state(3.3).position == here
    vehicle.latitude_deg -= 0.001
    session.feed(vehicle.position(), A, 3.4)
    vehicle.latitude_deg += 0.001
    session.feed(vehicle.position(), A, 3.6)
    state = session.records[1].state(3.7)
    assert (state.position, state.position_at_s) == (here, 3.4)
    session.feed(vehicle.position(), A, 3.8)  # the receiver has really moved
    state = session.records[1].state(3.9)
    assert state.position is not None
    assert state.position.latitude_deg == vehicle.latitude_deg
