"""Chosen views as missions can fly them: the line as a whole flies legs that are chosen one after the other.

As in :mod:`aos_gcs.lab.search.chosen`, the next stretch is the one whose frames gain most probability of detection per
second. Here all vehicles fly it in one front, from rest to rest, as missions fly their legs, so that all that keeps
vehicles apart on legs does so here; forming the line anew costs what it costs between planned legs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.lab.search.chosen import LONGEST_S, SPEEDS_MPS, ViewedCells, targets
from aos_gcs.lab.search.paths import SearchFlight, ordered
from aos_gcs.planning.detection.expected_views import LineOfCameras, line_of
from aos_gcs.planning.estimate import ACCELERATION_MPS2, CLIMB_MPS, SINK_MPS, STILL_S, move_s
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.swarm.line import line_axis

FloatArray = NDArray[np.float64]

_LENGTHS_M: Final = (30.0, 60.0, 120.0, 200.0)
"""Longer than those of single vehicles: each leg costs a stop."""


@dataclass(frozen=True, slots=True)
class ChosenLegs:
    """Legs in the order in which they were chosen, each from the end of the one before."""

    legs: tuple[ScanLeg, ...]
    speed_mps: float
    """Speed along them."""


def choose_legs(plan: MissionPlan, pod: float, beyond_m: float = math.inf) -> ChosenLegs | None:
    """Return the chosen legs of a line, at the speed out of some with which the flight is shortest.

    Arguments as of :func:`choose_legs_at`.

    Returns:
        None where that takes hours, or the plan has no forest or no launch point.
    """
    speeds_mps = sorted({plan.leg_speed_mps, *SPEEDS_MPS})
    chosen = [ChosenLegs(legs, mps) for mps in speeds_mps if (legs := choose_legs_at(plan, pod, mps, beyond_m))]
    return min(chosen, key=lambda one: fly_along(plan, one).duration_s, default=None)


def choose_legs_at(plan: MissionPlan, pod: float, mps: float, beyond_m: float = math.inf) -> tuple[ScanLeg, ...] | None:
    """Return legs that a line chooses, until the expected probability of detection is reached; None as above.

    Args:
        plan: plan with a forest, spacings and a launch point, of a square area about the origin. The first leg begins
            at the launch point.
        pod: wanted mean over the area.
        mps: speed along the legs.
        beyond_m: greatest distance from the area, along each of its sides, that vehicles of the line may have.
    """
    if plan.forest is None or plan.launch_enu_m is None:
        return None
    half_m = plan.area_enu_m[2][0]
    cells, line = ViewedCells.of(half_m, plan.forest), line_of(plan, 0.0)
    here_m = np.array(plan.launch_enu_m)
    now_s, legs = plan.highest_layer_m / CLIMB_MPS, list[ScanLeg]()
    while float(cells.detection.mean()) < pod:
        if now_s > LONGEST_S:
            return None
        before = legs[-1] if legs else None
        best_rate, best = -1.0, None
        for target_m in targets(cells, here_m, half_m, _LENGTHS_M):
            if (length_m := math.dist(here_m, target_m)) < mps / plan.rate_hz:
                continue  # nothing is exposed on the way
            east, north = (target_m - here_m) / length_m
            leg = ScanLeg((float(here_m[0]), float(here_m[1])), (float(east), float(north)), length_m)
            if _reach_m(line, leg) > half_m + beyond_m:
                continue
            frames_m, takes_s = _cameras(line, leg, mps / plan.rate_hz), _takes_s(plan, line, before, leg, mps)
            new, _ = cells.shown(frames_m, line.half_view)
            if (rate := cells.gain(new) / takes_s) > best_rate:
                best_rate, best = rate, (target_m, leg, frames_m, takes_s)
        if best is None:
            return None
        here_m, leg, frames_m, takes_s = best
        cells.add(*cells.shown(frames_m, line.half_view))
        legs.append(leg)
        now_s += takes_s
    return tuple(legs)


def fly_chosen_legs(plan: MissionPlan, pod: float) -> SearchFlight | None:
    """Return the flight of a line that chooses its legs; arguments and result as of :func:`choose_legs`."""
    chosen = choose_legs(plan, pod)
    return None if chosen is None else fly_along(plan, chosen)


def fly_along(plan: MissionPlan, chosen: ChosenLegs) -> SearchFlight:
    """Return the flight of a line along chosen legs.

    Args:
        plan: plan by which they were chosen.
        chosen: at least one leg.
    """
    line, mps = line_of(plan, 0.0), chosen.speed_mps
    now_s, times_s, cameras_m, path_m = plan.highest_layer_m / CLIMB_MPS, [], [], 0.0
    before: ScanLeg | None = None
    for leg in chosen.legs:
        begins_s = now_s + _forming_s(plan, line, before, leg) + _still_s(mps)
        frames_m = _cameras(line, leg, mps / plan.rate_hz)
        times_s.append(np.repeat(begins_s + _along_m(leg, mps / plan.rate_hz) / mps, plan.vehicles))
        cameras_m.append(frames_m)
        path_m += leg.length_m * plan.vehicles
        now_s += _takes_s(plan, line, before, leg, mps)
        before = leg
    home_m = math.dist(chosen.legs[-1].end_enu_m, plan.launch_enu_m or (0.0, 0.0))
    now_s += move_s(home_m, plan.cruise_speed_mps) + plan.highest_layer_m / SINK_MPS
    return ordered(np.concatenate(times_s), np.concatenate(cameras_m), now_s, path_m + home_m * plan.vehicles)


def _takes_s(plan: MissionPlan, line: LineOfCameras, before: ScanLeg | None, leg: ScanLeg, mps: float) -> float:
    """Return the time of a leg, with forming the line for it."""
    return _forming_s(plan, line, before, leg) + leg.length_m / mps + 2.0 * _still_s(mps) - STILL_S


def _still_s(mps: float) -> float:
    """Return the time at rest at one end of a leg, with that in which vehicles come up to the speed or slow down."""
    return STILL_S + mps / (2.0 * ACCELERATION_MPS2)


def _forming_s(plan: MissionPlan, line: LineOfCameras, before: ScanLeg | None, leg: ScanLeg) -> float:
    """Return the time in which the line turns about its middle; its vehicles may exchange their sides."""
    widest_m = float(np.abs(line.aside_m).max())
    if before is None:
        return move_s(widest_m, plan.cruise_speed_mps)
    (east, north), (following_east, following_north) = before.direction_enu, leg.direction_enu
    turn_rad = math.asin(min(1.0, abs(east * following_north - north * following_east)))
    return move_s(2.0 * widest_m * math.sin(turn_rad / 2.0), plan.cruise_speed_mps)


def _along_m(leg: ScanLeg, interval_m: float) -> FloatArray:
    """Return the distances of the exposures along a leg."""
    return np.arange(0.0, leg.length_m + 1e-6, interval_m)


def _cameras(line: LineOfCameras, leg: ScanLeg, interval_m: float) -> FloatArray:
    """Return the places of all cameras at each exposure, shape (k n, 3), those of one exposure together."""
    along, along_m = np.array(leg.direction_enu), _along_m(leg, interval_m)
    middles_m = np.array(leg.start_enu_m) + along_m[:, np.newaxis] * along
    cameras_m = np.empty((len(along_m), len(line.aside_m), 3))
    cameras_m[..., :2] = middles_m[:, np.newaxis] + line.aside_m[:, np.newaxis] * line_axis(along)
    cameras_m[..., 2] = line.heights_m
    return cameras_m.reshape(-1, 3)


def _reach_m(line: LineOfCameras, leg: ScanLeg) -> float:
    """Return the greatest distance, along an axis, of a vehicle on a leg from the origin."""
    aside_m = np.abs(line.aside_m).max() * np.abs(line_axis(np.array(leg.direction_enu)))
    return float((np.maximum(np.abs(leg.start_enu_m), np.abs(leg.end_enu_m)) + aside_m).max())
