"""Senders that use the id of an armed vehicle: the driver without sockets."""

from __future__ import annotations

import asyncio

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.mavlink.session import MavlinkSession
from aos_drivers.mavlink.signing.signer import LinkSigner, SigningClock
from aos_drivers.vehicle.commands import CommandRunner
from aos_drivers.vehicle.waiting import Changes
from aos_gcs.clock import LoopClock
from aos_gcs.errors import CommandError
from aos_gcs.ports import Arm, Command, FlightMode, Hold, Land, LandedState, Notice, ReturnToLaunch, Severity
from tests.fakes.mavlink_vehicle import COPTER_GUIDED, FakeVehicle

HOME, STRANGER, NEW_PORT = PeerAddress(0, "10.0.0.1", 1), PeerAddress(0, "10.0.0.66", 2), PeerAddress(0, "10.0.0.1", 3)
KEY = bytes(range(32))


class Sky:
    """One armed vehicle in the air, and time."""

    def __init__(self, session: MavlinkSession | None = None) -> None:
        self.session = session or MavlinkSession(254, 5.0)
        self.vehicle = FakeVehicle()
        self.vehicle.custom_mode = COPTER_GUIDED
        self.now_s = 0.0
        self.told: list[Notice] = []

    def take_off(self, at: PeerAddress = HOME) -> None:
        self.fly(1.0, {at: self.vehicle})
        self.vehicle.armed, self.vehicle.landed = True, mavlink.MAV_LANDED_STATE_IN_AIR
        self.fly(2.0, {at: self.vehicle})

    def fly(self, duration_s: float, senders: dict[PeerAddress, FakeVehicle]) -> None:
        """Hear the senders five times a second, and answer what they are asked for."""
        for _ in range(round(duration_s * 5)):
            for peer, sender in senders.items():
                sender.boot_ms += 200
                packets = sender.heartbeat() + sender.position() + sender.extended_state()
                self.told += [event for event in self.session.feed(packets, peer, self.now_s) if is_notice(event)]
            self.told += [event for event in self.session.poll(self.now_s) if is_notice(event)]
            for outgoing in self.session.take_outgoing():
                if outgoing.peer in senders:
                    sender = senders[outgoing.peer]
                    answer = sender.hear(outgoing.packet)
                    if sender.commands and sender.commands[-1].param1 == mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION:
                        answer += sender.version()
                    self.session.feed(answer, outgoing.peer, self.now_s)
            self.now_s += 0.2

    def criticals(self) -> list[str]:
        return [notice.text for notice in self.told if notice.severity is Severity.CRITICAL]


def is_notice(event: object) -> bool:
    return isinstance(event, Notice)


def twin() -> FakeVehicle:
    """Another vehicle with the same id: disarmed on the ground."""
    stranger = FakeVehicle()
    stranger.uid, stranger.boot_ms, stranger.height_m = 4711, 900_000, 0.0
    return stranger


def test_a_second_sender_neither_freezes_nor_moves_an_armed_vehicle() -> None:
    sky = Sky()
    sky.take_off()
    sky.fly(10.0, {HOME: sky.vehicle, STRANGER: twin()})
    state = sky.session.records[1].state(sky.now_s)
    assert (state.mode, state.armed, state.landed) == (FlightMode.GUIDED, True, LandedState.IN_AIR)
    assert not state.is_ambiguous
    assert sky.session.records[1].route.address == HOME
    assert sky.criticals() == ["another sender, at 10.0.0.66:2, uses its system id: ignored. Commands go to 10.0.0.1:1"]


def test_a_second_sender_cannot_take_the_place_of_a_vehicle_whose_link_fails() -> None:
    sky = Sky()
    sky.take_off()
    sky.fly(8.0, {STRANGER: twin()})
    record = sky.session.records[1]
    assert record.route.address == HOME
    assert sky.now_s - record.heard_at_s > 7.0
    sky.fly(20.0, {STRANGER: twin()})
    assert record.route.address == HOME  # another board, which it will never be


def test_a_vehicle_that_moves_to_another_port_in_flight_is_known_by_its_board() -> None:
    sky = Sky()
    sky.take_off()
    sky.fly(4.0, {NEW_PORT: sky.vehicle})
    record = sky.session.records[1]
    assert record.route.address == NEW_PORT
    assert sky.now_s - record.heard_at_s < 1.0
    sky.fly(10.0, {NEW_PORT: sky.vehicle, STRANGER: twin()})
    assert record.state(sky.now_s).armed


def test_a_vehicle_without_a_board_identity_is_heard_at_another_port_once_it_has_been_silent() -> None:
    sky = Sky()
    sky.vehicle.uid = 0
    sky.take_off()
    sky.fly(5.0, {NEW_PORT: sky.vehicle})
    assert sky.session.records[1].route.address == HOME
    sky.fly(8.0, {NEW_PORT: sky.vehicle})
    assert sky.session.records[1].route.address == NEW_PORT


def test_a_vehicle_that_restarts_at_another_port_in_flight_is_reported() -> None:
    sky = Sky()
    sky.take_off()
    sky.vehicle.boot_ms = 0
    sky.fly(4.0, {NEW_PORT: sky.vehicle})
    assert "has restarted" in [notice.text for notice in sky.told]
    assert sky.session.records[1].route.address == NEW_PORT


def test_many_senders_do_not_make_the_vehicle_be_forgotten() -> None:
    sky = Sky()
    sky.take_off()
    crowd = {PeerAddress(0, "10.0.0.66", port): twin() for port in range(1, 40)}
    sky.fly(4.0, {HOME: sky.vehicle, **crowd})
    assert sky.session.records[1].state(sky.now_s).armed
    sky.fly(4.0, {NEW_PORT: sky.vehicle})
    assert sky.session.records[1].route.address == NEW_PORT


def test_on_the_ground_again_the_id_is_anybodys() -> None:
    sky = Sky()
    sky.take_off()
    sky.vehicle.armed, sky.vehicle.landed = False, mavlink.MAV_LANDED_STATE_ON_GROUND
    sky.fly(8.0, {HOME: sky.vehicle, STRANGER: twin()})
    assert sky.session.records[1].state(sky.now_s).is_ambiguous


def test_nothing_unsigned_speaks_for_a_vehicle_that_signs() -> None:
    """Not even from its own address, on a link that accepts unsigned packets."""
    clock_s = 1_800_000_000.0
    signer = LinkSigner(0, KEY, SigningClock(lambda: clock_s, 0), accepts_unsigned=True)
    sky = Sky(MavlinkSession(254, 5.0, {0: signer}))
    sky.vehicle.encoder.sign(KEY, clock_s)
    sky.take_off()
    forger = twin()
    sky.fly(1.0, {HOME: forger})
    record = sky.session.records[1]
    assert record.state(sky.now_s).armed
    sky.fly(20.0, {STRANGER: forger})
    assert record.route.address == HOME


@pytest.mark.looptime
@pytest.mark.parametrize("command", [Hold(), ReturnToLaunch(), Land()])
async def test_stop_return_and_land_are_sent_even_while_two_vehicles_use_the_id(command: Command) -> None:
    sky = Sky()
    sky.fly(8.0, {HOME: sky.vehicle, STRANGER: twin()})
    record = sky.session.records[1]
    clock = LoopClock()
    record.is_ambiguous = lambda _now_s: True  # type: ignore[method-assign]
    sent: list[mavlink.MAVLink_message] = []
    runner = CommandRunner(record, lambda _system, _component, message: sent.append(message), Changes(clock), clock)
    with pytest.raises(CommandError):
        await runner.run(command, clock.now_s() + 2.0)
    assert sent


@pytest.mark.looptime
@pytest.mark.parametrize(("silent_s", "is_sent"), [(4.0, True), (6.0, False)])
async def test_silence_is_counted_in_seconds_of_the_link_however_fast_the_clock(silent_s: float, is_sent: bool) -> None:
    sky = Sky()
    sky.fly(8.0, {HOME: sky.vehicle})
    record, clock = sky.session.records[1], LoopClock(speed=10.0)
    record.heard_at_s = clock.now_s()
    await asyncio.sleep(silent_s)
    sent: list[mavlink.MAVLink_message] = []
    runner = CommandRunner(record, lambda _system, _component, message: sent.append(message), Changes(clock), clock)
    with pytest.raises(CommandError) as raised:
        await runner.run(Arm(), clock.now_s() + 5.0)
    assert ("has been silent for 6 s" in str(raised.value), bool(sent)) == (not is_sent, is_sent)


def test_an_address_that_may_be_a_new_one_of_a_vehicle_in_flight_hears_our_heartbeats() -> None:
    sky = Sky()
    sky.vehicle.uid = 0  # it has no identity: its proof is that nothing else is heard for ten seconds
    sky.take_off()
    sky.vehicle.boot_ms += 200
    sky.session.feed(sky.vehicle.heartbeat() + sky.vehicle.position(), NEW_PORT, sky.now_s)
    sky.session.take_outgoing()
    sky.session.send_heartbeat(sky.now_s)
    assert [one.peer for one in sky.session.take_outgoing()] == [HOME, NEW_PORT]


def test_a_vehicle_in_flight_is_followed_to_any_number_of_ports_one_after_the_other() -> None:
    # As over a mobile network, or a TCP link that breaks: each connection has another port.
    sky = Sky()
    sky.take_off()
    for port in range(10, 20):
        sky.fly(4.0, {PeerAddress(0, "10.0.0.1", port): sky.vehicle})
        record = sky.session.records[1]
        state = record.state(sky.now_s)
        assert record.route.address == PeerAddress(0, "10.0.0.1", port)
        assert state.position_at_s is not None
        assert sky.now_s - state.position_at_s < 0.5
    assert not record.failures.count
    assert PeerAddress(0, "10.0.0.1", 19).record in [link.address for link in state.proven]
