"""Batteries empty at the rate that is measured, and jumps are no discharge."""

import numpy as np
import pytest

from aos_gcs.mission.fleet.energy import MANOEUVRES_S, BatteryMeter, time_home_s


def test_whole_percents_still_give_the_rate() -> None:
    meter = BatteryMeter()
    for now_s in range(120):
        meter.take(float(now_s), round(0.9 - 0.001 * now_s, 2))
    assert meter.per_s == pytest.approx(0.001, rel=0.1)


def test_nothing_is_known_before_half_a_minute_or_on_the_ground() -> None:
    meter = BatteryMeter()
    for now_s in range(29):
        meter.take(float(now_s), 0.9 - 0.001 * now_s)
    assert meter.per_s is None
    meter.take(40.0, 0.86)
    assert meter.per_s is not None
    meter.reset()
    assert meter.per_s is None


def test_one_report_that_jumps_is_no_discharge() -> None:
    meter = BatteryMeter()
    for now_s in range(60):
        meter.take(float(now_s), 0.3 if now_s == 50 else 0.9)
    assert meter.per_s == 0.0


def test_home_is_level_flight_and_a_slow_descent() -> None:
    here_m, home_m = np.array([30.0, 40.0, 35.0]), np.array([0.0, 0.0, 5.0])
    assert time_home_s(here_m, home_m, 10.0) == pytest.approx(MANOEUVRES_S + 35.0)


def test_a_climb_to_the_layer_and_the_wind_make_the_way_home_longer() -> None:
    here_m, home_m = np.array([30.0, 40.0, 35.0]), np.array([0.0, 0.0, 5.0])
    # 10 m up at 2 m/s, 50 m at 10 m/s, 40 m down at 1 m/s.
    assert time_home_s(here_m, home_m, 10.0, layer_up_m=45.0) == pytest.approx(MANOEUVRES_S + 50.0)
    assert time_home_s(here_m, home_m, 10.0, layer_up_m=20.0) == pytest.approx(MANOEUVRES_S + 35.0)
    assert time_home_s(here_m, home_m, 10.0, wind_mps=5.0) == pytest.approx(MANOEUVRES_S + 40.0)
    assert time_home_s(here_m, home_m, 10.0, wind_mps=30.0) == pytest.approx(MANOEUVRES_S + 50.0)
