"""Positions that are repeated to the bit while the vehicle moves keep their age."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.telemetry import Telemetry


def report(
    telemetry: Telemetry,
    now_s: float,
    velocity_cmps: tuple[int, int, int] = (0, 0, 0),
    north: int = 0,
    *,
    up_mm: int = 0,
    boot_s: float | None = None,
) -> None:
    boot_ms = round(1000 * (now_s if boot_s is None else boot_s))
    message = mavlink.MAVLink_global_position_int_message(
        boot_ms, 480000000 + north, 140000000, 334_800 + up_mm, 34_800 + up_mm, *velocity_cmps, 9000
    )
    telemetry.update(message, now_s)


def press(telemetry: Telemetry, hpa: float, now_s: float) -> None:
    telemetry.update(mavlink.MAVLink_scaled_pressure_message(0, hpa, 0.0, 2000), now_s)


@pytest.mark.parametrize("velocity_cmps", [(100, 0, 0), (0, 0, 150)])
def test_a_position_that_stands_still_while_the_vehicle_moves_gets_old(velocity_cmps: tuple[int, int, int]) -> None:
    telemetry = Telemetry()
    for step in range(20):
        report(telemetry, 1.0 + 0.2 * step, velocity_cmps)
    assert telemetry.position_at_s == pytest.approx(1.4, abs=0.11)
    report(telemetry, 5.2, velocity_cmps, north=1)
    assert telemetry.position_at_s == 5.2


@pytest.mark.parametrize(("velocity_cmps", "north", "up_mm"), [((0, 300, 0), 0, 7), ((300, 0, 80), 270, 0)])
def test_a_place_or_an_altitude_alone_that_stands_still_while_the_vehicle_moves_gets_old(
    velocity_cmps: tuple[int, int, int], north: int, up_mm: int
) -> None:
    telemetry = Telemetry()
    for step in range(20):
        report(telemetry, 1.0 + 0.2 * step, velocity_cmps, north * step, up_mm=up_mm * step)
    assert telemetry.position_at_s == pytest.approx(1.4, abs=0.11)


def test_a_report_that_is_repeated_with_its_time_gets_old_in_a_hover_too() -> None:
    telemetry = Telemetry()
    for step in range(60):
        report(telemetry, 1.0 + 0.2 * step, boot_s=1.0)
    assert telemetry.position_at_s == pytest.approx(2.0, abs=0.1)
    report(telemetry, 13.2, boot_s=13.2)
    assert telemetry.position_at_s == 13.2


def test_a_position_that_stands_still_while_the_pressure_rises_gets_old() -> None:
    telemetry = Telemetry()
    for second in range(10):
        press(telemetry, 980.0 + 0.2 * second, float(second))
        report(telemetry, second + 0.1)
    assert telemetry.position_at_s == 0.1


def test_a_still_hover_is_fresh() -> None:
    telemetry = Telemetry()
    for second in range(100):
        press(telemetry, 980.0 + 0.05 * (second % 3), float(second))
        report(telemetry, second + 0.1, (20, 10, 5))
    assert telemetry.position_at_s == 99.1


def test_the_weather_moves_no_vehicle() -> None:
    telemetry = Telemetry()
    for second in range(0, 600, 2):
        press(telemetry, 980.0 + 0.002 * second, float(second))
        report(telemetry, second + 0.1)
    assert telemetry.position_at_s == 598.1
