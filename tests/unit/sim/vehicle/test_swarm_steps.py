"""Steps of several ticks: fewer calculations, the same flight."""

from __future__ import annotations

import numpy as np
import pytest

from aos_gcs.errors import ConfigurationError
from aos_sim.clock import TICK_S, Pacer, fast_utc_us
from aos_sim.swarm import SimulatedSwarm, SwarmOptions
from tests.fakes.air_flight import WarmSpot


def climbed(step_ticks: int, ticks: int = 400) -> SimulatedSwarm:
    """Return a vehicle that has climbed for eight seconds and hovered since."""
    swarm = SimulatedSwarm(SwarmOptions(vehicles=1, step_ticks=step_ticks, cameras=False), WarmSpot())
    vehicle, kinematics = swarm.vehicles[0], swarm.kinematics(1)
    vehicle.autopilot.flight.arm(kinematics, 0.0)
    vehicle.autopilot.flight.take_off(10.0, kinematics, 0.0)
    for _ in range(ticks // step_ticks):
        swarm._tick()
    return swarm


def test_a_flight_in_larger_steps_ends_at_the_same_place_and_time() -> None:
    fine, coarse = climbed(1), climbed(5)
    assert fine.now.tick == coarse.now.tick
    np.testing.assert_allclose(coarse.state.position_enu_m, fine.state.position_enu_m, atol=0.05)


def test_a_battery_drains_by_time_and_not_by_steps() -> None:
    fine, coarse = (climbed(ticks).vehicles[0].autopilot.battery.consumed_mah for ticks in (1, 5))
    assert coarse == pytest.approx(fine, rel=0.01)


def test_the_pacer_counts_steps() -> None:
    pacer = Pacer(1.0, tick_s=5 * TICK_S)
    assert [pacer.due_ticks(real_s) for real_s in (0.0, 0.11, 0.19, 0.31)] == [0, 1, 0, 2]


def test_steps_that_fence_checks_do_not_divide_into_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="step_ticks"):
        SwarmOptions(step_ticks=3)


@pytest.mark.parametrize(("speed", "ticks"), [(0.5, 1), (1.0, 1), (2.0, 2), (4.0, 2), (5.0, 5), (20.0, 5)])
def test_a_fast_flight_is_calculated_in_longer_steps(speed: float, ticks: int) -> None:
    assert SwarmOptions(speed=speed).ticks_per_step() == ticks
    assert SwarmOptions(speed=speed, step_ticks=1).ticks_per_step() == 1


def test_the_clock_agrees_with_that_of_a_station_that_runs_as_fast() -> None:
    assert fast_utc_us(1_010_000_000, 1.0, 1000.0) == 1_010_000_000
    assert fast_utc_us(1_010_000_000, 4.0, 1000.0) == 1_040_000_000
