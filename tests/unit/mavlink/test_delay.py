"""Telemetry that comes late: the driver without sockets, a vehicle behind a queue."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.links.framing import FrameParser
from aos_drivers.mavlink.session import Event, MavlinkSession
from aos_gcs.ports import Notice
from tests.fakes.mavlink_vehicle import FakeVehicle

A = PeerAddress(0, "10.0.0.1", 5001)
TICK_S = 0.1


class QueuedVehicle:
    """A vehicle whose packets wait for ``delay_s`` in a queue; what it is sent arrives at once."""

    def __init__(self, rate: float = 1.0, answers: bool = True) -> None:
        self.session, self.vehicle = MavlinkSession(254, 5.0), FakeVehicle()
        self.now_s, self.delay_s = 1000.0, 0.0
        self.rate = rate
        self.answers = answers
        self.told: list[str] = []
        self._boot_s = 50.0
        self._queue: deque[tuple[float, bytes]] = deque()

    def run(self, duration_s: float, delay_at: Callable[[float], float] = lambda _elapsed_s: 0.0) -> None:
        start_s = self.now_s
        while self.now_s < start_s + duration_s:
            self.now_s += TICK_S
            self._boot_s += TICK_S * self.rate
            self.delay_s = delay_at(self.now_s - start_s)
            self.vehicle.boot_ms = round(self._boot_s * 1000)
            self._put(self.vehicle.heartbeat() + self.vehicle.position() + self.vehicle.extended_state())
            while self._queue and self._queue[0][0] <= self.now_s - self.delay_s:
                self._tell(self.session.feed(self._queue.popleft()[1], A, self.now_s))
            self._tell(self.session.poll(self.now_s))
            for outgoing in self.session.take_outgoing():
                for message in FrameParser().feed(outgoing.packet):
                    if message.get_type() == "TIMESYNC" and self.answers:
                        answer = mavlink.MAVLink_timesync_message(round(self._boot_s * 1e9), message.ts1)
                        self._put(self.vehicle.encoder.pack(answer))

    def ages_s(self) -> tuple[float, float, float]:
        """Return the ages of position, link and landed state."""
        state = self.session.records[1].state(self.now_s)
        assert state.position_at_s is not None
        assert state.heard_at_s is not None
        assert state.landed_at_s is not None
        return self.now_s - state.position_at_s, self.now_s - state.heard_at_s, self.now_s - state.landed_at_s

    def _put(self, data: bytes) -> None:
        self._queue.append((self.now_s, data))

    def _tell(self, events: list[Event]) -> None:
        self.told += [event.text for event in events if isinstance(event, Notice)]


def test_queued_telemetry_is_as_old_as_the_vehicle_says() -> None:
    sky = QueuedVehicle()
    sky.run(20.0)
    assert sky.ages_s() == pytest.approx((0.0, 0.0, 0.0))
    sky.run(60.0, lambda elapsed_s: 0.5 * elapsed_s)
    assert sky.ages_s() == pytest.approx((30.0, 30.0, 30.0), abs=1.0)
    assert [text for text in sky.told if "overloaded" in text] == [
        (
            "telemetry is 2 s old when it is read: this station or its link is overloaded. "
            "Close other programs on this computer, and check the link"
        )
    ]
    sky.run(10.0)
    assert sky.ages_s() == pytest.approx((0.0, 0.0, 0.0))
    assert sky.told[-1] == "telemetry arrives in time again"


def test_another_stations_target_shows_in_telemetry_that_comes_late() -> None:
    sky = QueuedVehicle()
    sky.vehicle.armed, sky.vehicle.custom_mode = True, mavlink.COPTER_MODE_GUIDED
    sky.run(20.0)
    record = sky.session.records[1]
    record.control.begin(frozenset({"GUIDED"}), None)
    record.control.confirm(None, sky.now_s, has_target=True)
    sky.run(20.0, lambda elapsed_s: min(1.0, 0.5 * elapsed_s))
    for latitude_e7 in (480_000_000, 480_010_000, 480_010_000):
        sky.run(1.0, lambda _elapsed_s: 1.0)
        sky.vehicle.target = latitude_e7, 140_000_000, 330.0
        sky.session.feed(sky.vehicle.target_echo(), A, sky.now_s)
    assert record.state(sky.now_s).taken_over == "it flies to a target of another station or pilot"


def test_the_clock_of_a_slow_simulation_is_no_delay() -> None:
    sky = QueuedVehicle(rate=0.8)
    sky.run(120.0)
    assert sky.ages_s() == pytest.approx((0.0, 0.0, 0.0))
    assert not [text for text in sky.told if "overloaded" in text]


def test_without_answers_to_timesync_the_time_of_arrival_counts() -> None:
    sky = QueuedVehicle(answers=False)
    sky.run(20.0)
    sky.run(20.0, lambda elapsed_s: 0.5 * elapsed_s)
    assert sky.ages_s() == pytest.approx((0.0, 0.0, 0.0), abs=0.2)


def test_an_older_position_does_not_replace_a_newer_one() -> None:
    session, vehicle = MavlinkSession(254, 5.0), FakeVehicle()
    session.feed(vehicle.telemetry(), A, 0.0)
    vehicle.height_m = 1.0
    late = vehicle.position()
    vehicle.height_m, vehicle.boot_ms = 2.0, vehicle.boot_ms + 200
    session.feed(vehicle.position(), A, 0.2)
    session.feed(late, A, 0.3)
    assert session.records[1].state(0.4).height_above_home_m == 2.0


def test_the_stock_streams_of_px4_are_slowed_down_in_one_go() -> None:
    session, vehicle = MavlinkSession(254, 5.0), FakeVehicle(autopilot=mavlink.MAV_AUTOPILOT_PX4)
    session.feed(vehicle.heartbeat(), A, 0.0)
    session.poll(0.0)
    asked = [
        int(message.param1)
        for outgoing in session.take_outgoing()
        for message in FrameParser().feed(outgoing.packet)
        if getattr(message, "command", 0) == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
    ]
    assert set(session.records[1].autopilot.stock_stream_ids) <= set(asked)
    assert len(asked) > 5
