"""Vehicles of a flight that a restarted station takes up: the driver without sockets."""

from __future__ import annotations

from dataclasses import replace

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.links.former import former_owners
from aos_drivers.mavlink.session import MavlinkSession
from aos_gcs.ports import FormerLinks
from tests.fakes.mavlink_vehicle import COPTER_GUIDED, FakeVehicle
from tests.unit.mavlink.test_ownership import HOME, NEW_PORT, STRANGER, Sky, twin

GAP_S = 20.0
"""Time without a station, in which vehicles fly on."""


class StoppedClock:
    """Clock of a program that has just been started, on a machine whose time of day may have been set."""

    speed = 1.0

    def __init__(self, utc_s: float) -> None:
        self._utc_s = utc_s

    def now_s(self) -> float:
        return 0.0

    def utc_s(self) -> float:
        return self._utc_s


def restarted(*, clock_set_by_s: float = 0.0, **changes: object) -> tuple[Sky, FakeVehicle]:
    """Return what a station hears that starts ``GAP_S`` after the former one ended, and the vehicle that it flew."""
    before = Sky()
    before.take_off()
    before.fly(2.0, {HOME: before.vehicle, STRANGER: twin()})  # its board is asked for: somebody else has its id
    proven = before.session.records[1].state(before.now_s).proven
    former = FormerLinks(1000.0, {1: tuple(replace(proof, **changes) for proof in proven)})  # type: ignore[arg-type]
    before.vehicle.boot_ms += round(1e3 * GAP_S)
    clock = StoppedClock(1000.0 + GAP_S + clock_set_by_s)
    owners = former_owners(former, clock)  # type: ignore[arg-type] - it is asked for nothing else
    return Sky(MavlinkSession(254, 5.0, former=owners)), before.vehicle


def test_a_stranger_who_is_heard_first_is_not_taken_for_the_vehicle() -> None:
    sky, vehicle = restarted()
    sky.fly(4.0, {STRANGER: twin()})
    assert not sky.session.records
    assert "heard at 10.0.0.66:2, but it flew at 10.0.0.1:1" in sky.told[0].text
    sky.fly(4.0, {STRANGER: twin(), HOME: vehicle})
    record = sky.session.records[1]
    assert record.route.address == HOME
    assert record.state(sky.now_s).armed
    assert not record.state(sky.now_s).is_ambiguous
    assert "another sender, at 10.0.0.66:2" in sky.criticals()[0]


def test_a_vehicle_that_has_moved_meanwhile_is_known_by_its_board_and_boot() -> None:
    sky, vehicle = restarted()
    sky.fly(4.0, {STRANGER: twin(), NEW_PORT: vehicle})
    assert sky.session.records[1].route.address == NEW_PORT
    assert {PeerAddress.parse(proof.address) for proof in sky.session.records[1].state(sky.now_s).proven} == {
        HOME,
        NEW_PORT,
    }


@pytest.mark.parametrize(
    ("changes", "heard_as"),
    [({"uid": 1001}, STRANGER), ({"uid": 0}, STRANGER), ({"uid": 4711}, None)],
    ids=["all simulated PX4 have one board", "board not known", "other board"],
)
def test_what_cannot_prove_to_be_the_vehicle_waits_for_the_silence_of_its_address(
    changes: dict[str, int], heard_as: PeerAddress | None
) -> None:
    sky, _vehicle = restarted()
    stranger = twin()
    stranger.uid = changes["uid"]
    sky.fly(9.0, {STRANGER: stranger})
    assert not sky.session.records
    sky.fly(3.0, {STRANGER: stranger})
    record = sky.session.records.get(1)
    assert (None if record is None else record.route.address) == heard_as


@pytest.mark.parametrize("clock_set_by_s", [-3600.0, 3600.0])
def test_a_time_of_day_that_was_set_costs_the_proof_elsewhere_and_nothing_at_the_former_address(
    clock_set_by_s: float,
) -> None:
    sky, vehicle = restarted(clock_set_by_s=clock_set_by_s)
    sky.fly(4.0, {HOME: vehicle})
    assert sky.session.records[1].state(sky.now_s).armed
    assert "has restarted" not in [notice.text for notice in sky.told]
    sky, vehicle = restarted(clock_set_by_s=clock_set_by_s)
    sky.fly(9.0, {NEW_PORT: vehicle})
    assert not sky.session.records
    sky.fly(3.0, {NEW_PORT: vehicle})
    assert sky.session.records[1].state(sky.now_s).armed


def test_one_that_has_landed_meanwhile_owns_its_id_no_longer() -> None:
    sky, vehicle = restarted()
    vehicle.armed, vehicle.landed = False, mavlink.MAV_LANDED_STATE_ON_GROUND
    sky.fly(8.0, {HOME: vehicle, STRANGER: twin()})
    assert sky.session.records[1].state(sky.now_s).is_ambiguous


def test_signatures_are_expected_only_where_they_are_checked() -> None:
    sky, vehicle = restarted(is_signed=True)
    sky.fly(2.0, {HOME: vehicle})
    assert sky.session.records[1].state(sky.now_s).armed


@pytest.mark.parametrize("address", ["", "0 10.0.0.1", "x 10.0.0.1 1", "0 10.0.0.1 -1", "0 10.0.0.1 1 2"])
def test_a_damaged_record_protects_nothing_and_stops_nothing(address: str) -> None:
    sky, vehicle = restarted(address=address)
    vehicle.custom_mode = COPTER_GUIDED
    sky.fly(2.0, {NEW_PORT: vehicle})
    assert sky.session.records[1].state(sky.now_s).armed
