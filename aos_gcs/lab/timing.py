"""Time models of a step."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from aos_gcs.lab.scenario import Scenario, TimeModel

BRAKING_SHARE = 0.8
"""Share of the acceleration that an autopilot plans for braking."""


def step_duration_s(moves_m: NDArray[np.float64], scenario: Scenario) -> float:
    """Return the time from one exposure to the next.

    Args:
        moves_m: displacement of each drone, shape (n, 2).
        scenario: its time model and limits.
    """
    longest_m = float(np.linalg.norm(moves_m, axis=1).max())
    if scenario.time_model is TimeModel.PAPER:
        return max(longest_m / scenario.speed_mps, scenario.min_step_s)
    flight_s = rest_to_rest_s(longest_m, scenario.speed_mps, scenario.acceleration_mps2)
    return max(flight_s + scenario.processing_s, scenario.min_step_s)


def rest_to_rest_s(distance_m: float, speed_mps: float, acceleration_mps2: float) -> float:
    """Return the time of a straight flight from hover to hover: accelerate, cruise where there is room, brake."""
    braking_mps2 = BRAKING_SHARE * acceleration_mps2
    per_square = 0.5 / acceleration_mps2 + 0.5 / braking_mps2
    peak_mps = min(speed_mps, math.sqrt(distance_m / per_square))
    cruise_m = max(0.0, distance_m - per_square * peak_mps**2)
    return peak_mps / acceleration_mps2 + peak_mps / braking_mps2 + cruise_m / speed_mps
