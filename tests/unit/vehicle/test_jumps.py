"""Jumps of reported positions, and what is none."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.telemetry import Telemetry


def report(telemetry: Telemetry, boot_s: float, north_m: float, speed_mps: float = 0.0, late_s: float = 0.0) -> None:
    message = mavlink.MAVLink_global_position_int_message(
        round(1000 * boot_s),
        480000000 + round(north_m * 10_000_000 / 111_320),
        140000000,
        334_800,
        34_800,
        round(100 * speed_mps),
        0,
        0,
        9000,
    )
    telemetry.update(message, boot_s + late_s)


def test_a_jump_and_its_way_back_add_up_to_nothing() -> None:
    telemetry = Telemetry()
    for step in range(40):
        jump_m = 12.0 if 10 <= step < 30 else 0.0
        report(telemetry, 0.2 * step, 5.0 * 0.2 * step + jump_m, 5.0)
        if step == 20:
            assert telemetry.jumps.total_m == pytest.approx((0.0, 12.0), abs=0.1)
    assert telemetry.jumps.total_m == pytest.approx((0.0, 0.0), abs=0.1)


@pytest.mark.parametrize("interval_s", [0.1, 0.25, 1.0, 2.5])
def test_a_hard_stop_is_no_jump_at_any_rate(interval_s: float) -> None:
    telemetry = Telemetry()
    north_m, speed_mps, boot_s = 0.0, 10.0, 0.0
    while speed_mps > 0.0:
        report(telemetry, boot_s, north_m, speed_mps)
        next_mps = max(0.0, speed_mps - 4.0 * interval_s) if boot_s > 3.0 else speed_mps
        north_m, speed_mps, boot_s = north_m + interval_s * (speed_mps + next_mps) / 2.0, next_mps, boot_s + interval_s
    report(telemetry, boot_s, north_m)
    assert telemetry.jumps.total_m == (0.0, 0.0)


def test_reports_that_arrive_all_at_once_after_a_stall_are_no_jump() -> None:
    telemetry = Telemetry()
    for step in range(100):
        boot_s = 0.2 * step
        report(telemetry, boot_s, 10.0 * boot_s, 10.0, late_s=max(0.0, 15.0 - boot_s) if step > 20 else 0.0)
    assert telemetry.jumps.total_m == (0.0, 0.0)


def test_a_gap_and_a_restart_are_no_jump() -> None:
    telemetry = Telemetry()
    report(telemetry, 1.0, 0.0, 10.0)
    report(telemetry, 5.0, 90.0, 0.0)
    assert telemetry.jumps.total_m == (0.0, 0.0)
    telemetry = telemetry.after_restart()
    report(telemetry, 0.5, 130.0)
    report(telemetry, 0.7, 130.0)
    assert telemetry.jumps.total_m == (0.0, 0.0)
