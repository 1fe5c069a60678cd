"""Proposal of a search for a wanted probability of detection: spacing of line and legs, and speed.

The area is cut into m strips of equal width, each with a leg. The vehicles of the line are spread evenly over a strip,
so that every place gets about as many views; they are not closer than the strategy's spacing: from there on legs
overlap, and a place is passed several times. For each m the speed is the greatest with which the legs reach the wanted
probability, by the views that they will give (:mod:`aos_gcs.planning.expected_views`). Of all m the one with the
shortest flight is proposed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count
from typing import Final

import numpy as np

from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.aperture import footprint_m
from aos_gcs.planning.estimate import estimate_flights, planned_legs
from aos_gcs.planning.expected_views import PLACES, predicted_detection, spread_places
from aos_gcs.planning.legs import in_passes
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.search_settings import SearchMode
from aos_gcs.planning.viewed_ground import LEVEL_GROUND, ViewedGround
from aos_gcs.swarm.line import line_axis
from aos_gcs.swarm.registry import make_strategy

FASTEST_MPS: Final = 10.0
"""Greatest speed that is proposed: an exposure known to 30 ms is known to 0.3 m there, and images are not blurred."""
SLOWEST_MPS: Final = 1.0
_PLACES: Final = 600
"""Places at which views are counted while patterns are compared."""
_MARGIN: Final = 0.005
"""Probability by which a proposal exceeds what is wanted, as views are counted at few places."""
_WORSE: Final = 3
"""Patterns in a row, each of a leg more than the one before, that are no better, after which no more are tried."""
_MOST_LEGS: Final = 100
_STEPS: Final = 7
"""Halvings of the range of speeds."""
_LEAST_HEIGHT_M: Final = 1.0
"""Height above the ground that widths of view are computed for at least."""
_WIDEST_VIEW: Final = 0.95
"""Greatest spacing of vehicles, over the width that the lowest camera sees: beyond it strips are left out."""


@dataclass(frozen=True, slots=True)
class SearchPattern:
    """Flight along legs for a wanted probability of detection."""

    line_spacing_m: float
    leg_spacing_m: float
    search_speed_mps: float
    legs: int
    detection: float
    """Predicted probability of detection of a standing person, a mean over the area."""
    flight_s: float
    """Time from the first take-off to the last landing, where nothing is found."""

    def applied_to(self, plan: MissionPlan) -> MissionPlan:
        """Return a plan that flies this pattern."""
        return replace(
            plan,
            line_spacing_m=self.line_spacing_m,
            leg_spacing_m=self.leg_spacing_m,
            search_speed_mps=self.search_speed_mps,
        )


def propose_pattern(
    plan: MissionPlan, plane_height_m: float, ground: ViewedGround = LEVEL_GROUND
) -> SearchPattern | None:
    """Return the fastest search that reaches a plan's wanted probability of detection.

    Args:
        plan: plan that can be flown; the spacings and the search speed that it has make no difference.
        plane_height_m: height of the focal plane above the ground.
        ground: ground of the area, below the layers.

    Returns:
        None where no probability is wanted, the forest is not described, the swarm stops for each frame, or no pattern
        reaches it.

    Raises:
        ConfigurationError: the plan cannot be flown.
    """
    if plan.pod is None or plan.forest is None or plan.search_mode is not SearchMode.CONTINUOUS:
        return None
    best: SearchPattern | None = None
    worse = 0
    for pattern in _patterns(plan, plane_height_m, plan.pod, ground):
        if best is None or pattern.flight_s < best.flight_s:
            best, worse = pattern, 0
        else:
            worse += 1
        if worse >= _WORSE:
            break
    return best


def _patterns(plan: MissionPlan, plane_height_m: float, pod: float, ground: ViewedGround) -> Iterator[SearchPattern]:
    """Yield the pattern of each number of legs with which the wanted probability can be reached."""
    direction = np.array([math.sin(plan.scan_heading_rad), math.cos(plan.scan_heading_rad)])
    across_m = np.array(plan.area_enu_m) @ line_axis(direction)
    width_m = float(across_m.max() - across_m.min())
    height_m = plan.lowest_layer_m - plane_height_m - _highest_rise_m(plan, ground)
    view_m = footprint_m(max(_LEAST_HEIGHT_M, height_m), plan.camera_fov_rad)
    least_m = min(make_strategy(plan.strategy, plan.parameters).spacing_m, view_m)
    fastest_mps = min(FASTEST_MPS, plan.cruise_speed_mps)
    fewest = max(1, math.ceil(width_m / (plan.vehicles * _WIDEST_VIEW * view_m)))
    for legs in count(fewest):
        if legs > _MOST_LEGS:
            return
        # Rounded up: rounded down it would take a leg more.
        leg_m = math.ceil(10.0 * width_m / legs) / 10.0
        line_m = max(least_m, round(leg_m / plan.vehicles, 1))
        one = replace(plan, line_spacing_m=line_m, leg_spacing_m=leg_m, search_speed_mps=fastest_mps)
        fitted = _at_greatest_speed(one, plane_height_m, min(pod + _MARGIN, 1.0), fastest_mps, ground)
        if fitted is not None:
            yield fitted


def _highest_rise_m(plan: MissionPlan, ground: ViewedGround) -> float:
    """Return by how much the place of the area that is nearest to the layers is nearer than level ground would be."""
    if ground.is_level:
        return 0.0
    rises_m = ground.rises_m(spread_places(plan.area_enu_m, PLACES))
    return float(rises_m[np.isfinite(rises_m)].max(initial=0.0))


def _at_greatest_speed(
    plan: MissionPlan, plane_height_m: float, pod: float, fastest_mps: float, ground: ViewedGround
) -> SearchPattern | None:
    legs = in_passes(planned_legs(plan, plane_height_m), plan.passes)

    def detection(speed_mps: float) -> float:
        flown = replace(plan, search_speed_mps=speed_mps)
        figures = predicted_detection(flown, legs, plane_height_m, _PLACES, ground)
        return 0.0 if figures is None else figures.standing

    if detection(fastest_mps) >= pod:
        speed_mps = fastest_mps
    elif detection(min(SLOWEST_MPS, fastest_mps)) < pod:
        return None
    else:
        low_mps, high_mps = SLOWEST_MPS, fastest_mps
        for _ in range(_STEPS):
            middle_mps = math.sqrt(low_mps * high_mps)
            low_mps, high_mps = (middle_mps, high_mps) if detection(middle_mps) >= pod else (low_mps, middle_mps)
        speed_mps = max(SLOWEST_MPS, math.floor(10.0 * low_mps) / 10.0)
    flown = replace(plan, search_speed_mps=speed_mps)
    (flight,) = estimate_flights(flown, [legs])
    if plan.line_spacing_m is None or plan.leg_spacing_m is None:
        raise ConfigurationError("A pattern needs the spacings of line and legs.")
    return SearchPattern(
        line_spacing_m=plan.line_spacing_m,
        leg_spacing_m=plan.leg_spacing_m,
        search_speed_mps=speed_mps,
        legs=len(legs),
        detection=detection(speed_mps),
        flight_s=flight.duration_s,
    )
