"""Chosen views as a mission could fly them: the line as a whole flies legs that are chosen one after the other.

As in :mod:`aos_gcs.lab.search.chosen`, the next stretch is the one whose frames gain most probability of detection per
second. Here all vehicles fly it in one front, from rest to rest, as missions fly their legs, so that all that keeps
vehicles apart on legs does so here; forming the line anew costs what it costs between planned legs.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.lab.search.chosen import LONGEST_S, SPEEDS_MPS, ViewedCells, targets
from aos_gcs.lab.search.paths import SearchFlight, ordered
from aos_gcs.planning.estimate import ACCELERATION_MPS2, CLIMB_MPS, SINK_MPS, STILL_S, move_s
from aos_gcs.planning.expected_views import LineOfCameras, line_of
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.swarm.line import line_axis

FloatArray = NDArray[np.float64]

_LENGTHS_M: Final = (30.0, 60.0, 120.0, 200.0)
"""Longer than those of single vehicles: each leg costs a stop."""


def fly_chosen_legs(plan: MissionPlan, pod: float) -> SearchFlight | None:
    """Return the flight of a line that chooses its legs, at the best of some speeds; see :func:`fly_chosen_legs_at`."""
    speeds_mps = {plan.leg_speed_mps, *SPEEDS_MPS}
    flights = [fly_chosen_legs_at(plan, pod, speed_mps) for speed_mps in sorted(speeds_mps)]
    return min((one for one in flights if one is not None), key=lambda one: one.duration_s, default=None)


def fly_chosen_legs_at(plan: MissionPlan, pod: float, mps: float) -> SearchFlight | None:
    """Return the flight of a line that chooses its legs, until the expected probability of detection is reached.

    Args:
        plan: plan with a forest, spacings and a launch point, of a square area about the origin.
        pod: wanted mean over the area.
        mps: speed along the legs.

    Returns:
        None where that takes hours.
    """
    if plan.forest is None or plan.launch_enu_m is None:
        return None
    half_m = plan.area_enu_m[2][0]
    cells, line = ViewedCells.of(half_m, plan.forest), line_of(plan, 0.0)
    still_s = STILL_S + mps / (2.0 * ACCELERATION_MPS2)
    launch_m = np.array(plan.launch_enu_m)
    here_m, course = launch_m, None
    now_s, times_s, cameras_m, path_m = plan.highest_layer_m / CLIMB_MPS, [], [], 0.0
    while float(cells.detection.mean()) < pod:
        if now_s > LONGEST_S:
            return None
        best_rate, best = -1.0, None
        for target_m in targets(cells, here_m, half_m, _LENGTHS_M):
            if (length_m := math.dist(here_m, target_m)) < mps / plan.rate_hz:
                continue  # nothing is exposed on the way
            along = (target_m - here_m) / length_m
            form_s = _forming_s(line, course, along, plan.cruise_speed_mps)
            along_m = np.arange(0.0, length_m + 1e-6, mps / plan.rate_hz)
            frames_m = _cameras(line, here_m, along, along_m)
            new, _ = cells.shown(frames_m, line.half_view)
            takes_s = form_s + length_m / mps + 2.0 * still_s - STILL_S
            if (rate := cells.gain(new) / takes_s) > best_rate:
                best_rate, best = rate, (target_m, along, form_s, along_m, frames_m, takes_s)
        if best is None:
            return None
        target_m, along, form_s, along_m, frames_m, takes_s = best
        cells.add(*cells.shown(frames_m, line.half_view))
        times_s.append(np.repeat(now_s + form_s + still_s + along_m / mps, plan.vehicles))
        cameras_m.append(frames_m)
        path_m += math.dist(here_m, target_m) * plan.vehicles
        here_m, course, now_s = target_m, along, now_s + takes_s
    home_m = math.dist(here_m, launch_m)
    now_s += move_s(home_m, plan.cruise_speed_mps) + plan.highest_layer_m / SINK_MPS
    return ordered(np.concatenate(times_s), np.concatenate(cameras_m), now_s, path_m + home_m * plan.vehicles)


def _forming_s(line: LineOfCameras, before: FloatArray | None, after: FloatArray, cruise_mps: float) -> float:
    """Return the time in which the line turns about its middle; its vehicles may exchange their sides."""
    if before is None:
        return move_s(float(np.abs(line.aside_m).max()), cruise_mps)
    sine = abs(float(before[0] * after[1] - before[1] * after[0]))
    turn_rad = math.asin(min(1.0, sine))
    return move_s(2.0 * float(np.abs(line.aside_m).max()) * math.sin(turn_rad / 2.0), cruise_mps)


def _cameras(line: LineOfCameras, start_m: FloatArray, along: FloatArray, along_m: FloatArray) -> FloatArray:
    """Return the places of all cameras at each exposure, shape (k n, 3), those of one exposure together."""
    middles_m = start_m + along_m[:, np.newaxis] * along
    cameras_m = np.empty((len(along_m), len(line.aside_m), 3))
    cameras_m[..., :2] = middles_m[:, np.newaxis] + line.aside_m[:, np.newaxis] * line_axis(along)
    cameras_m[..., 2] = line.heights_m
    return cameras_m.reshape(-1, 3)
