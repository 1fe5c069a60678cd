"""Launch and return points of a plan: whether they can be used, and whether paths lead to the area and back."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.ground import Ground, Obstruction
from aos_gcs.airspace.limits import UNLIMITED, SafetyLimits
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.plan import MissionPlan, PlanProblem
from aos_gcs.planning.proposal import FREE_GROUND_M, fence_margin_m, no_go_margin_m, propose_fence

FloatArray = NDArray[np.float64]
Homes = Mapping[int, tuple[float, float]]
"""Launch points of vehicles by id, horizontal ENU metres."""

_GREATEST_MARGIN_M = 5000.0
_Check = Callable[[FloatArray], Obstruction | None]


def planned_ground(plan: MissionPlan, homes_enu_m: Homes, slack_m: float) -> Ground:
    """Return the ground of a plan with valid shapes, within the geofence that is proposed if it has none."""
    return Ground(planned_boundaries(plan, homes_enu_m), slack_m)


def planned_boundaries(plan: MissionPlan, homes_enu_m: Homes) -> SafetyLimits:
    """Return limits with the geofence and the no-go zones of a plan with valid shapes, and without any other."""
    margin_m = fence_margin_m(plan.fence_margin_m, plan.cruise_speed_mps)
    margin_m = margin_m if 0.0 <= margin_m <= _GREATEST_MARGIN_M else 0.0  # else another check refuses the plan
    fence_enu_m = plan.fence_enu_m
    if fence_enu_m is None:
        points = [plan.launch_enu_m, plan.return_enu_m, *homes_enu_m.values()]
        grounds_m = [point for point in points if point is not None]
        fence_enu_m = propose_fence(plan.area_enu_m, grounds_m, FREE_GROUND_M + margin_m)
    return replace(
        UNLIMITED,
        fence_enu_m=fence_enu_m,
        no_go_enu_m=plan.no_go_enu_m,
        margin_m=margin_m,
        no_go_margin_m=no_go_margin_m(plan.fence_margin_m),
    )


def check_points(plan: MissionPlan, ground: Ground, homes_enu_m: Homes) -> Iterator[PlanProblem]:
    """Yield problems of the launch and return points.

    Problems of where vehicles stand are advice: they can still be moved, and preflight checks them again.
    """
    yield from _problems(plan, homes_enu_m, ground.at, ground.at)


def check_paths(
    plan: MissionPlan, ground: Ground, homes_enu_m: Homes, legs: Sequence[ScanLeg]
) -> Iterator[PlanProblem]:
    """Yield what blocks the paths to the first leg and from the last one, as :func:`check_points` does."""
    first_m, last_m = np.array(legs[0].start_enu_m), np.array(legs[-1].end_enu_m)
    yield from _problems(
        plan,
        homes_enu_m,
        lambda place_m: None if ground.at(place_m) else ground.between(place_m, first_m),
        lambda place_m: None if ground.at(place_m) else ground.between(last_m, place_m),
    )


def _problems(plan: MissionPlan, homes_enu_m: Homes, barred_start: _Check, barred_end: _Check) -> Iterator[PlanProblem]:
    for field, name, point, barred in (
        ("launch_enu_m", "launch", plan.launch_enu_m, barred_start),
        ("return_enu_m", "return", plan.return_enu_m, barred_end),
    ):
        if point is not None and (obstruction := barred(np.array(point))) is not None:
            yield PlanProblem(field, f"The {name} point is {obstruction.text}; {obstruction.remedy}.")
    standing: dict[Obstruction, list[int]] = defaultdict(list)
    for vehicle_id, place in sorted(homes_enu_m.items()):
        if (obstruction := barred_start(np.array(place))) is not None:
            standing[obstruction].append(vehicle_id)
    for obstruction, ids in standing.items():
        subject = f"Vehicle {ids[0]} is" if len(ids) == 1 else f"Vehicles {', '.join(map(str, ids))} are"
        yield PlanProblem("launch_enu_m", f"{subject} {obstruction.text}; {obstruction.remedy}.", blocking=False)
