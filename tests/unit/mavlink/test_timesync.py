from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.links.framing import FrameParser
from aos_drivers.mavlink.session import MavlinkSession
from aos_drivers.vehicle.timesync import ClockEstimator
from tests.fakes.mavlink_vehicle import FakeVehicle

A = PeerAddress(0, "10.0.0.1", 5001)


def answer(sent_ns: int, vehicle_s: float) -> mavlink.MAVLink_timesync_message:
    return mavlink.MAVLink_timesync_message(round(vehicle_s * 1e9), sent_ns)


def exchange(
    estimator: ClockEstimator, now_s: float, there_s: float, back_s: float, *, offset_s: float, drift: float = 0.0
) -> None:
    """One request and its answer; the vehicle's clock reads ``(1 + drift) t + offset_s``."""
    sent_ns = estimator.poll(now_s)
    assert sent_ns is not None
    seen_s = now_s + there_s
    estimator.on_message(answer(sent_ns, seen_s * (1 + drift) + offset_s), seen_s + back_s)


def test_equal_delays_give_the_offset_and_the_round_trip() -> None:
    estimator = ClockEstimator()
    exchange(estimator, 100.0, 0.04, 0.04, offset_s=-70.0)
    assert estimator.offset_s == pytest.approx(-70.0, abs=1e-6)
    assert estimator.round_trip_s == pytest.approx(0.08, abs=1e-6)
    assert estimator.drift is None


@settings(max_examples=60, deadline=None)
@given(
    st.floats(-1e6, 1e6),
    st.lists(st.tuples(st.floats(0.0, 2.0), st.floats(0.0, 2.0)), min_size=1, max_size=25),
)
def test_the_offset_errs_by_at_most_half_of_the_shortest_round_trip(
    offset_s: float, delays_s: list[tuple[float, float]]
) -> None:
    estimator = ClockEstimator()
    for number, (there_s, back_s) in enumerate(delays_s):
        exchange(estimator, 1e6 + 2.0 * number, there_s, back_s, offset_s=offset_s)
    assert estimator.offset_s is not None
    assert abs(estimator.offset_s - offset_s) <= min(there + back for there, back in delays_s) / 2 + 1e-6


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32), st.floats(-100e-6, 100e-6), st.floats(0.0, 0.03))
def test_drift_is_found_under_jitter_and_asymmetric_delays(seed: int, drift: float, asymmetry_s: float) -> None:
    rng = np.random.default_rng(seed)
    estimator = ClockEstimator()
    for number in range(120):
        there_s, back_s = 0.01 + asymmetry_s + rng.exponential(0.02), 0.01 + rng.exponential(0.02)
        exchange(estimator, 2.0 * number, there_s, back_s, offset_s=5.0, drift=drift)
    last_s = 238.0
    assert estimator.drift == pytest.approx(drift, abs=100e-6)
    assert estimator.offset_s == pytest.approx(5.0 + drift * last_s, abs=asymmetry_s / 2 + 0.015)


def test_the_best_quarter_beats_the_mean_of_all() -> None:
    rng = np.random.default_rng(1)
    errors_s, means_s = [], []
    for _ in range(8):
        estimator, midpoints_s = ClockEstimator(), []
        for number in range(120):
            there_s, back_s = 0.01 + rng.exponential(0.1), 0.01 + rng.exponential(0.02)
            exchange(estimator, 2.0 * number, there_s, back_s, offset_s=5.0)
            midpoints_s.append((there_s - back_s) / 2)
        assert estimator.offset_s is not None
        errors_s.append(abs(estimator.offset_s - 5.0))
        means_s.append(abs(float(np.mean(midpoints_s))))
    assert np.mean(errors_s) < 0.5 * np.mean(means_s)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("stalls_at_s", [(40.0,), (30.0, 55.0), (70.0, 71.0, 130.0)])
def test_a_computer_that_stands_still_for_tenths_of_a_second_is_no_drift(
    seed: int, stalls_at_s: tuple[float, ...]
) -> None:
    rng = np.random.default_rng(seed)
    estimator, drifts = ClockEstimator(), []
    for number in range(120):
        at_s = 2.0 * number
        lost_s = 0.3 * sum(stall_s <= at_s for stall_s in stalls_at_s)
        there_s, back_s = 0.001 + rng.exponential(0.02), 0.001 + rng.exponential(0.02)
        exchange(estimator, at_s, there_s, back_s, offset_s=5.0 - lost_s)
        drifts.append(estimator.drift)
    assert len([drift for drift in drifts if drift is not None]) > 50
    assert max(abs(drift) for drift in drifts if drift is not None) < 0.7e-3


@pytest.mark.parametrize("drift", [-5e-3, 2e-3])
def test_a_clock_that_drifts_for_long_is_still_seen(drift: float) -> None:
    rng = np.random.default_rng(2)
    estimator = ClockEstimator()
    for number in range(60):
        exchange(estimator, 2.0 * number, *(0.01 + rng.exponential(0.02, 2)), offset_s=5.0, drift=drift)
    assert estimator.drift == pytest.approx(drift, rel=0.4)


@pytest.mark.parametrize("lost_s", [0.8, 0.3, 0.1, -0.3])
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("stalled_at", [20, 110])
def test_the_offset_is_right_a_few_answers_after_a_stall(lost_s: float, seed: int, stalled_at: int) -> None:
    rng = np.random.default_rng(seed)
    estimator = ClockEstimator()
    for number in range(stalled_at + 40):
        offset_s = 5.0 if number < stalled_at else 5.0 - lost_s
        there_s, back_s = rng.uniform(0.005, 0.02, 2)
        exchange(estimator, 2.0 * number, there_s, back_s, offset_s=offset_s)
        if number != stalled_at:
            assert estimator.offset_s == pytest.approx(offset_s, abs=0.01), number


def test_an_answer_that_contradicts_all_others_changes_nothing() -> None:
    estimator = ClockEstimator()
    for number in range(90):
        exchange(estimator, 2.0 * number, 0.01, 0.01, offset_s=4.7 if number in {30, 50, 80} else 5.0)
        assert estimator.offset_s == pytest.approx(5.0, abs=1e-6)


def test_what_was_not_asked_for_is_no_sample() -> None:
    estimator = ClockEstimator()
    sent_ns = estimator.poll(10.0)
    assert sent_ns is not None
    estimator.on_message(answer(sent_ns + 1, 3.0), 10.1)
    estimator.on_message(mavlink.MAVLink_timesync_message(0, sent_ns), 10.1)
    assert estimator.offset_s is None
    estimator.on_message(answer(sent_ns, 3.0), 10.1)
    first = estimator.offset_s
    estimator.on_message(answer(sent_ns, 300.0), 10.1)
    assert estimator.offset_s == first, "a repeated answer counts once"


def test_a_clock_that_jumps_starts_anew() -> None:
    estimator = ClockEstimator()
    for number in range(50):
        exchange(estimator, 2.0 * number, 0.01, 0.01, offset_s=5.0)
    exchange(estimator, 100.0, 0.3, 0.3, offset_s=-95.0)
    assert estimator.offset_s == pytest.approx(-95.0, abs=1e-6)
    assert estimator.drift is None


def test_the_session_asks_and_the_state_tells() -> None:
    session = MavlinkSession(254, 5.0)
    vehicle = FakeVehicle(1)
    session.feed(vehicle.heartbeat(), A, 50.0)
    session.poll(50.0)
    (request,) = [
        message
        for outgoing in session.take_outgoing()
        for message in FrameParser().feed(outgoing.packet)
        if message.get_type() == "TIMESYNC"
    ]
    assert request.tc1 == 0
    session.feed(vehicle.encoder.pack(answer(request.ts1, 1050.03)), A, 50.06)
    link = session.records[1].state(50.1).link
    assert link is not None
    assert link.round_trip_s == pytest.approx(0.06)
    assert link.clock_offset_s == pytest.approx(1000.0)
    assert (link.address, link.living_addresses, link.clock_drift) == ("10.0.0.1:5001", 1, None)
    vehicle.boot_ms = 10_000
    session.feed(vehicle.position(), A, 51.0)
    for boot_ms in (10, 210, 410):
        vehicle.boot_ms = boot_ms
        session.feed(vehicle.position(), A, 51.0 + boot_ms / 1000)
    link = session.records[1].state(51.5).link
    assert link is not None
    assert link.clock_offset_s is None, "a reboot starts another clock"
