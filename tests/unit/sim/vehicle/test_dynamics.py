"""Properties of the flight dynamics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aos_sim.clock import TICK_S
from aos_sim.errors.wind import Wind
from aos_sim.vehicle.dynamics import AirframeLimits, Guidance, SwarmState, approach_speed, step

LIMITS = AirframeLimits()
SPEED_MPS, CLIMB_MPS, DESCENT_MPS = 10.0, 2.5, 1.5

LOW_ENU_M, HIGH_ENU_M = (-60.0, -60.0, 5.0), (60.0, 60.0, 60.0)
VEHICLES = 60


def places(seed):
    """Draw places all over the volume, among them many on its bounds, and so above each other or in one plane."""
    rng = np.random.default_rng(seed)
    drawn = rng.uniform(LOW_ENU_M, HIGH_ENU_M, (VEHICLES, 3))
    bounds = np.where(rng.random((VEHICLES, 3)) < 0.5, LOW_ENU_M, HIGH_ENU_M)
    return np.where(rng.random((VEHICLES, 3)) < 0.3, bounds, drawn)


def hovering(position_enu_m):
    positions = np.atleast_2d(np.asarray(position_enu_m, float))
    state = SwarmState.at_rest(positions, np.zeros(len(positions)))
    return replace(state, on_ground=np.zeros(len(positions), bool))


def towards(target_enu_m, heading_rad=0.0, lifting=True):
    targets = np.atleast_2d(np.asarray(target_enu_m, float))
    count = len(targets)
    return Guidance(
        lifting=np.full(count, lifting),
        target_enu_m=targets,
        speed_mps=np.full(count, SPEED_MPS),
        climb_mps=np.full(count, CLIMB_MPS),
        descent_mps=np.full(count, DESCENT_MPS),
        heading_rad=np.full(count, heading_rad),
    )


def fly(state, guidance, seconds, wind=None):
    rng = np.random.default_rng(3)
    states = [state]
    for _ in range(round(seconds / TICK_S)):
        states.append(step(states[-1], guidance, TICK_S, limits=LIMITS, wind=wind or Wind(), rng=rng))
    return states


def stacked(states, name):
    """Return one quantity over time, shape (T, N, 3)."""
    return np.stack([getattr(state, name) for state in states])


def assert_accelerations_within_limits(states):
    acceleration = np.diff(stacked(states, "velocity_enu_mps"), axis=0) / TICK_S
    assert np.linalg.norm(acceleration[..., :2], axis=-1).max() <= LIMITS.horizontal_acceleration_mps2 + 1e-6
    assert np.abs(acceleration[..., 2]).max() <= LIMITS.vertical_acceleration_mps2 + 1e-6


def test_move_is_straight_arrives_and_does_not_overshoot():
    start, goal = places(1), places(2)
    states = fly(hovering(start), towards(goal), 50.0)
    assert_accelerations_within_limits(states)
    velocity = stacked(states, "velocity_enu_mps")
    assert np.linalg.norm(velocity[..., :2], axis=-1).max() <= SPEED_MPS + 1e-6
    assert velocity[..., 2].min() >= -DESCENT_MPS - 1e-6
    assert velocity[..., 2].max() <= CLIMB_MPS + 1e-6
    line = goal - start
    length = np.linalg.norm(line, axis=1)
    direction = line / np.maximum(length, 1e-12)[:, None]
    relative = stacked(states, "position_enu_m") - start
    along = np.sum(relative * direction, axis=-1)
    assert np.all(along <= length + 0.01)
    assert np.all(np.diff(along, axis=0) >= -1e-6)
    assert np.linalg.norm(relative - along[..., None] * direction, axis=-1).max() < 0.01
    assert np.linalg.norm(relative[-1] - line, axis=-1).max() < 0.02


def test_change_of_target_in_flight_stays_within_acceleration_and_arrives():
    first, second = places(3), places(4)
    states = fly(hovering(np.tile([0.0, 0.0, 30.0], (VEHICLES, 1))), towards(first), 3.0)
    states += fly(states[-1], towards(second), 60.0)[1:]
    assert_accelerations_within_limits(states)
    assert np.linalg.norm(states[-1].position_enu_m - second, axis=1).max() < 0.05


def test_approach_speed_is_continuous_and_can_be_braked():
    distance_m = np.linspace(0.0, 40.0, 4001)
    speed = approach_speed(distance_m, np.full(distance_m.shape, 2.0))
    assert np.abs(np.diff(speed)).max() < 0.03
    assert np.all(speed**2 <= 2.0 * 2.0 * distance_m + 1e-9)


def test_tilt_and_heading_follow_the_motion():
    states = fly(hovering((0.0, 0.0, 30.0)), towards((0.0, 50.0, 30.0), heading_rad=1.5), 1.0)
    assert states[-1].attitude_rad[0, 1] < -0.1, "nose down when accelerating forwards"
    turn = np.diff(stacked(states, "attitude_rad")[:, 0, 2]) / TICK_S
    assert turn.max() <= LIMITS.yaw_rate_radps + 1e-9
    assert states[-1].attitude_rad[0, 2] == pytest.approx(1.0472, abs=1e-3)


def test_turn_takes_the_short_way_through_north():
    states = fly(hovering((0.0, 0.0, 30.0)), towards((0.0, 0.0, 30.0), heading_rad=6.0), 1.0)
    assert states[-1].attitude_rad[0, 2] == pytest.approx(6.0, abs=1e-6)


def test_without_lift_it_falls_and_rests_on_the_ground():
    states = fly(hovering((1.0, 2.0, 10.0)), towards((0.0, 0.0, 10.0), lifting=False), 3.0)
    assert states[40].velocity_enu_mps[0, 2] == pytest.approx(-9.81 * 0.8, rel=0.01)
    assert states[-1].on_ground[0]
    assert states[-1].position_enu_m[0] == pytest.approx([1.0, 2.0, 0.0])


def test_gusts_move_a_hovering_vehicle_a_little_and_repeat_by_seed():
    wind = Wind(10.0)
    guidance = towards((0.0, 0.0, 30.0))
    positions = stacked(fly(hovering((0.0, 0.0, 30.0)), guidance, 20.0, wind), "position_enu_m")
    away = np.linalg.norm(positions - [0.0, 0.0, 30.0], axis=-1)
    assert 0.02 < away.max() < 1.0
    again = stacked(fly(hovering((0.0, 0.0, 30.0)), guidance, 20.0, wind), "position_enu_m")
    np.testing.assert_array_equal(positions, again)


def test_vehicle_sent_sideways_while_climbing_stays_in_its_layer():
    climbing = fly(hovering((0.0, 0.0, 10.0)), towards((0.0, 0.0, 40.0)), 12.3)[-1]
    layer_m = climbing.position_enu_m[0, 2] + 0.3
    positions = stacked(fly(climbing, towards((50.0, 0.0, layer_m)), 12.0), "position_enu_m")
    assert climbing.velocity_enu_mps[0, 2] > 0.5
    assert positions[..., 2].max() < layer_m + 0.15
