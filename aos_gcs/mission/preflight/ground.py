"""Checks of launch and return points, and of the paths from there to the search area and back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.ground import Ground
from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.preflight import checks
from aos_gcs.planning.estimate import planned_legs
from aos_gcs.planning.plan import plan_of
from aos_gcs.planning.settings import MissionSettings


def check_ground(
    homes_enu_m: Mapping[int, NDArray[np.float64]], limits: SafetyLimits, settings: MissionSettings
) -> tuple[PreflightCheck, ...]:
    """Return a check of every vehicle's launch point, and a failed one of the mission if its return point is barred.

    Args:
        homes_enu_m: launch points by vehicle, shape (3,) each.
        limits: limits of this flight.
        settings: settings of the mission.
    """
    ground = Ground(limits, settings.flight.arrival_radius_m)
    middle_m = np.mean([home_enu_m[:2] for home_enu_m in homes_enu_m.values()], axis=0)
    plan = replace(plan_of(settings), launch_enu_m=(float(middle_m[0]), float(middle_m[1])))
    legs = planned_legs(plan, settings.imaging.plane_height_m)
    start_m, end_m = np.array(legs[0].start_enu_m), np.array(legs[-1].end_enu_m)
    found = [
        _check_launch_point(ground, vehicle_id, home_enu_m[:2], start_m)
        for vehicle_id, home_enu_m in homes_enu_m.items()
    ]
    if settings.return_enu_m is not None:
        found += _check_return_point(ground, np.array(settings.return_enu_m), end_m)
    return tuple(found)


def check_descents(vehicle_ids: Sequence[int], met: Sequence[tuple[int, int]]) -> tuple[PreflightCheck, ...]:
    """Return for every vehicle whether it descends at home clear of those that return by their autopilots below it.

    Args:
        vehicle_ids: the vehicles.
        met: rows of a vehicle whose path home leads past the launch point of the other one, below its layer.
    """
    found = []
    for row, vehicle_id in enumerate(vehicle_ids):
        others = ", ".join(str(vehicle_ids[one]) for one, other in met if other == row)
        if others:
            text = f"through the layers of vehicles that may pass above its launch point: {others}"
            remedy = "place them side by side as seen from the search area, or farther apart"
            found.append(checks.warned(vehicle_id, checks.DESCENT, text, remedy))
        else:
            found.append(checks.passed(vehicle_id, checks.DESCENT, "clear of the other paths home"))
    return tuple(found)


def _check_launch_point(
    ground: Ground, vehicle_id: int, home_m: NDArray[np.float64], area_m: NDArray[np.float64]
) -> PreflightCheck:
    obstruction = ground.at(home_m) or ground.between(home_m, area_m)
    if obstruction is not None:
        return checks.failed(vehicle_id, checks.PATH, f"it is {obstruction.text}", obstruction.remedy)
    return checks.passed(vehicle_id, checks.PATH, "open")


def _check_return_point(
    ground: Ground, return_m: NDArray[np.float64], area_m: NDArray[np.float64]
) -> list[PreflightCheck]:
    obstruction = ground.at(return_m) or ground.between(area_m, return_m)
    if obstruction is None:
        return []
    text = f"the return point is {obstruction.text}"
    return [checks.failed(checks.MISSION, checks.PATH, text, obstruction.remedy)]
