"""Flight dynamics of all vehicles at once: pure functions on arrays, ENU metres and radians.

A vehicle is a point that follows velocity commands within limits of speed and acceleration; its attitude follows from
the acceleration, as it does for a multicopter. That is what a ground station can observe of a well-tuned autopilot.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_sim.errors.sizes import drifted
from aos_sim.errors.wind import Wind
from aos_sim.world.relief import Relief, ground_below

GRAVITY_MPS2 = 9.81

POSITION_GAIN_PER_S = 2.0
"""Close to the target the speed is this gain times the distance, which approaches without overshooting."""

BRAKING_SHARE = 0.8
"""Share of the acceleration limit that is planned for braking; the rest absorbs the finite step."""

ATTITUDE_TIME_CONSTANT_S = 0.15

DRAG_PER_S = 0.08
"""Air drag per unit of mass and air speed: makes a vehicle lean into the wind."""

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class SwarmState:
    """True state of N vehicles."""

    position_enu_m: FloatArray
    """Shape (N, 3)."""
    commanded_velocity_enu_mps: FloatArray
    """Velocity that the controller has reached, without what gusts add, shape (N, 3)."""
    velocity_enu_mps: FloatArray
    """Shape (N, 3)."""
    attitude_rad: FloatArray
    """Roll, pitch and heading (clockwise from north), shape (N, 3)."""
    attitude_rates_radps: FloatArray
    """Time derivative of ``attitude_rad``, shape (N, 3)."""
    gust_enu_mps: FloatArray
    """Deviation of the wind from its mean at each vehicle, shape (N, 3)."""
    on_ground: NDArray[np.bool_]
    """Shape (N,)."""

    @classmethod
    def at_rest(cls, position_enu_m: FloatArray, heading_rad: FloatArray) -> SwarmState:
        """Return vehicles that stand on the ground at ``position_enu_m`` (N, 3), facing ``heading_rad`` (N,)."""
        count = len(position_enu_m)
        zeros = np.zeros((count, 3))
        attitude_rad = np.column_stack([np.zeros(count), np.zeros(count), heading_rad])
        return cls(position_enu_m.astype(np.float64), zeros, zeros, attitude_rad, zeros, zeros, np.ones(count, bool))


@dataclass(frozen=True, slots=True, eq=False)
class Guidance:
    """Set-points of the N flight controllers."""

    lifting: NDArray[np.bool_]
    """Shape (N,): the rotors carry the vehicle. Without, it stands on the ground or falls."""
    target_enu_m: FloatArray
    """Positions to fly to and hover at, shape (N, 3). Below the ground: land."""
    speed_mps: FloatArray
    """Greatest horizontal speed, shape (N,)."""
    climb_mps: FloatArray
    """Greatest speed upwards, shape (N,)."""
    descent_mps: FloatArray
    """Greatest speed downwards, shape (N,)."""
    heading_rad: FloatArray
    """Wanted heading, shape (N,)."""


@dataclass(frozen=True, slots=True)
class AirframeLimits:
    """Limits of every vehicle of the swarm."""

    horizontal_acceleration_mps2: float = 3.5
    vertical_acceleration_mps2: float = 2.5
    yaw_rate_radps: float = np.pi / 3


def step(
    state: SwarmState,
    guidance: Guidance,
    dt_s: float,
    *,
    limits: AirframeLimits,
    wind: Wind,
    rng: np.random.Generator,
    relief: Relief | None = None,
) -> SwarmState:
    """Return the state ``dt_s`` later.

    Lifting vehicles fly a straight line to their target: they accelerate and brake within ``limits`` and never exceed
    the speeds in ``guidance`` by more than what gusts add. They stand on ``relief``, or on the plane z = 0.
    """
    gust = _next_gust(state.gust_enu_mps, wind, dt_s, rng)
    if not guidance.lifting.any() and _stands_still(state, relief):
        return replace(state, gust_enu_mps=gust)
    lifting = guidance.lifting[:, np.newaxis]
    commanded = np.where(
        lifting,
        _follow_target(state, guidance, dt_s, limits),
        state.commanded_velocity_enu_mps + np.array([0.0, 0.0, -GRAVITY_MPS2 * dt_s]),
    )
    velocity = commanded + np.where(lifting, wind.response * gust, 0.0)
    position = state.position_enu_m + velocity * dt_s
    acceleration = (commanded - state.commanded_velocity_enu_mps) / dt_s
    ground_up_m = ground_below(position, relief)
    touching = position[:, 2] <= ground_up_m
    # A vehicle that leaves the ground touches it in the first step; only one that does not climb has landed.
    landed = touching & (commanded[:, 2] <= 0.0)
    position[touching, 2] = ground_up_m[touching]
    for moving in (commanded, velocity, acceleration):
        moving[landed] = 0.0
    attitude, rates = _next_attitude(
        state, guidance, acceleration=acceleration, wind=wind, landed=landed, dt_s=dt_s, limits=limits
    )
    return replace(
        state,
        position_enu_m=position,
        commanded_velocity_enu_mps=commanded,
        velocity_enu_mps=velocity,
        attitude_rad=attitude,
        attitude_rates_radps=rates,
        gust_enu_mps=gust,
        on_ground=landed,
    )


def _stands_still(state: SwarmState, relief: Relief | None) -> bool:
    """Return whether all vehicles are level and at rest on the ground, where only lifting changes anything."""
    at_rest = (state.commanded_velocity_enu_mps, state.velocity_enu_mps, state.attitude_rates_radps)
    return bool(
        state.on_ground.all()
        and (state.position_enu_m[:, 2] == ground_below(state.position_enu_m, relief)).all()
        and not state.attitude_rad[:, :2].any()
        and not any(values.any() for values in at_rest)
    )


def _follow_target(state: SwarmState, guidance: Guidance, dt_s: float, limits: AirframeLimits) -> FloatArray:
    """Return the velocity commanded next, shape (N, 3)."""
    error = guidance.target_enu_m - state.position_enu_m
    distance = np.sqrt(np.einsum("ij,ij->i", error, error))
    direction = error / np.maximum(distance, 1e-9)[:, np.newaxis]
    horizontal, vertical = _sizes(direction).T
    vertical_limit = np.where(direction[:, 2] > 0.0, guidance.climb_mps, guidance.descent_mps)
    speed_limit = np.minimum(
        guidance.speed_mps / np.maximum(horizontal, 1e-9), vertical_limit / np.maximum(vertical, 1e-9)
    )
    braking = BRAKING_SHARE * np.minimum(
        limits.horizontal_acceleration_mps2 / np.maximum(horizontal, 1e-9),
        limits.vertical_acceleration_mps2 / np.maximum(vertical, 1e-9),
    )
    speed = np.minimum(speed_limit, approach_speed(distance, braking))
    current = state.commanded_velocity_enu_mps
    along = np.einsum("ij,ij->i", current, direction)[:, np.newaxis] * direction
    budget = dt_s * np.array([limits.horizontal_acceleration_mps2, limits.vertical_acceleration_mps2])
    # Motion across the line is stopped first: a vehicle still climbing must not leave its layer when sent sideways.
    stopped = _within_budget(along - current, budget)
    hurried = _within_budget(direction * speed[:, np.newaxis] - along, budget - _sizes(stopped))
    return np.asarray(current + stopped + hurried)


def approach_speed(distance_m: FloatArray, braking_mps2: FloatArray) -> FloatArray:
    """Return the speed from which a vehicle can still stop within ``distance_m``; all shapes (N,).

    Far out it is the constant-deceleration parabola, close in it is linear in the distance; both meet smoothly.
    """
    linear_m = braking_mps2 / POSITION_GAIN_PER_S**2
    parabola = np.sqrt(2.0 * braking_mps2 * np.maximum(distance_m - linear_m / 2.0, 0.0))
    return np.where(distance_m > linear_m, parabola, POSITION_GAIN_PER_S * distance_m)


def _sizes(vectors: FloatArray) -> FloatArray:
    """Return the horizontal and the vertical size of vectors (N, 3), shape (N, 2)."""
    sizes = np.empty((len(vectors), 2))
    np.hypot(vectors[:, 0], vectors[:, 1], out=sizes[:, 0])
    np.abs(vectors[:, 2], out=sizes[:, 1])
    return sizes


def _within_budget(change: FloatArray, budget: FloatArray) -> FloatArray:
    """Shorten changes of velocity (N, 3) to budgets, horizontal and vertical, (N, 2) or (2,), in their direction."""
    share = np.min(np.maximum(budget, 0.0) / np.maximum(_sizes(change), 1e-12), axis=1)
    return np.asarray(change * np.minimum(1.0, share)[:, np.newaxis])


def _next_gust(gust: FloatArray, wind: Wind, dt_s: float, rng: np.random.Generator) -> FloatArray:
    """Return the gusts one step later, shape (N, 3); in still air nothing is drawn."""
    if wind.gust_sigma_mps == 0.0:
        return gust
    return drifted(rng, gust, wind.gust_sigma_mps, dt_s, wind.gust_s)


def _next_attitude(
    state: SwarmState,
    guidance: Guidance,
    *,
    acceleration: FloatArray,
    wind: Wind,
    landed: NDArray[np.bool_],
    dt_s: float,
    limits: AirframeLimits,
) -> tuple[FloatArray, FloatArray]:
    """Return attitude and its rates, both (N, 3): tilt gives the horizontal thrust, the heading turns at its rate."""
    heading = state.attitude_rad[:, 2]
    thrust = acceleration[:, :2] + DRAG_PER_S * (state.velocity_enu_mps - np.array(wind.mean_enu_mps))[:, :2]
    forward = thrust[:, 0] * np.sin(heading) + thrust[:, 1] * np.cos(heading)
    right = thrust[:, 0] * np.cos(heading) - thrust[:, 1] * np.sin(heading)
    wanted_tilt = np.column_stack([np.arctan2(right, GRAVITY_MPS2), np.arctan2(-forward, GRAVITY_MPS2)])
    flying = guidance.lifting & ~landed
    wanted_tilt[~flying] = 0.0
    tilt = state.attitude_rad[:, :2]
    tilt = tilt + (wanted_tilt - tilt) * min(1.0, dt_s / ATTITUDE_TIME_CONSTANT_S)
    turn = (guidance.heading_rad - heading + np.pi) % (2.0 * np.pi) - np.pi
    turn = np.clip(turn, -limits.yaw_rate_radps * dt_s, limits.yaw_rate_radps * dt_s)
    turn[~flying] = 0.0
    attitude = np.column_stack([tilt, (heading + turn) % (2.0 * np.pi)])
    rates = np.column_stack([(tilt - state.attitude_rad[:, :2]) / dt_s, turn / dt_s])
    return attitude, rates
