"""Proposal of a search for a wanted probability of detection: spacing of line and legs, and speed.

The area is cut into m strips of equal width, each with a leg. The vehicles of the line are spread evenly over a strip,
so that every place gets about as many views; they are not closer than the strategy's spacing: from there on legs
overlap, and a place is passed several times. For each m the speed is the greatest with which the legs reach the wanted
probability, by the views that they will give (:mod:`aos_gcs.planning.detection.expected_views`). Of all m the one
with the shortest flight is proposed.

More legs see more, so that nothing is proposed where the most do not reach what is wanted at the least speed, and the
fewest that do are found by halving. What is counted for a proposal has an end, as anybody may ask for one.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.aperture import footprint_m
from aos_gcs.planning.detection.expected_views import (
    PLACES,
    exposures_of_places,
    predicted_detection,
    spread_places,
)
from aos_gcs.planning.estimate import estimate_flights, planned_legs
from aos_gcs.planning.legs import ScanLeg, in_passes
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.search_settings import SearchMode
from aos_gcs.planning.terrain.viewed_ground import LEVEL_GROUND, ViewedGround
from aos_gcs.swarm.line import line_axis
from aos_gcs.swarm.registry import make_strategy

FASTEST_MPS: Final = 10.0
"""Greatest speed that is proposed: an exposure known to 30 ms is known to 0.3 m there, and images are not blurred."""
SLOWEST_MPS: Final = 1.0
_PLACES: Final = 600
"""Places at which views are counted while patterns are compared."""
_MARGIN: Final = 0.005
"""Probability by which a proposal exceeds what is wanted, as views are counted at few places."""
_KNOWN_TO: Final = 0.03
"""Share of itself to which the worth of a view is known: by so much more coverage is planned."""
_WORSE: Final = 3
"""Patterns in a row, each of a leg more than the one before, that are no better, after which no more are tried."""
_MOST_LEGS: Final = 100
_MOST_COUNTED: Final = 60_000_000
"""Exposures of places that are counted for one proposal at most; what has been found by then is proposed."""
_MOST_OF_A_PATTERN: Final = 10_000_000
"""Exposures of places of a pattern with more of which it is not tried."""
_PER_MPS: Final = 10
"""Speeds per metre per second that are compared: more are nothing that operators would set."""
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
    pod = min(1.0 - (1.0 - plan.pod) ** (1.0 + _KNOWN_TO) + _MARGIN, 1.0)
    for pattern in _patterns(plan, _Predictions(plane_height_m, ground), pod):
        if best is None or pattern.flight_s < best.flight_s:
            best, worse = pattern, 0
        else:
            worse += 1
        if worse >= _WORSE:
            break
    return best


@dataclass(slots=True)
class _Predictions:
    """Predicted probabilities of detection, and how many exposures may still be counted for them."""

    plane_height_m: float
    ground: ViewedGround
    left: float = _MOST_COUNTED

    def legs_of(self, plan: MissionPlan) -> tuple[ScanLeg, ...]:
        """Return the legs of all passes of a plan."""
        return in_passes(planned_legs(plan, self.plane_height_m), plan.passes)

    def detection(self, plan: MissionPlan, legs: Sequence[ScanLeg]) -> float:
        """Return the probability of detection that legs reach."""
        self.left -= exposures_of_places(plan, self.plane_height_m, len(legs), _PLACES)
        figures = predicted_detection(plan, legs, self.plane_height_m, _PLACES, self.ground)
        return 0.0 if figures is None else figures.standing

    def are_few(self, plan: MissionPlan, legs: int) -> bool:
        """Return whether so many legs of each pass can be counted at once."""
        counted = exposures_of_places(plan, self.plane_height_m, plan.passes * legs, _PLACES)
        return counted <= min(_MOST_OF_A_PATTERN, self.left)


def _patterns(plan: MissionPlan, predictions: _Predictions, pod: float) -> Iterator[SearchPattern]:
    """Yield the pattern of each number of legs with which the wanted probability can be reached."""
    direction = np.array([math.sin(plan.scan_heading_rad), math.cos(plan.scan_heading_rad)])
    across_m = np.array(plan.area_enu_m) @ line_axis(direction)
    width_m = float(across_m.max() - across_m.min())
    height_m = plan.lowest_layer_m - predictions.plane_height_m - _highest_rise_m(plan, predictions.ground)
    view_m = footprint_m(max(_LEAST_HEIGHT_M, height_m), plan.camera_fov_rad)
    least_m = min(make_strategy(plan.strategy, plan.parameters).spacing_m, view_m)
    fastest_mps = min(FASTEST_MPS, plan.cruise_speed_mps)
    slowest_mps = min(SLOWEST_MPS, fastest_mps)
    fewest = max(1, math.ceil(width_m / (plan.vehicles * _WIDEST_VIEW * view_m)))

    def flown(legs: int, speed_mps: float) -> MissionPlan:
        # Rounded up: rounded down it would take a leg more.
        leg_m = math.ceil(10.0 * width_m / legs) / 10.0
        line_m = max(least_m, round(leg_m / plan.vehicles, 1))
        return replace(plan, line_spacing_m=line_m, leg_spacing_m=leg_m, search_speed_mps=speed_mps)

    def reaches(legs: int) -> bool:
        slow = flown(legs, slowest_mps)
        return predictions.detection(slow, predictions.legs_of(slow)) >= pod

    counted = [legs for legs in range(fewest, _MOST_LEGS + 1) if predictions.are_few(flown(legs, slowest_mps), legs)]
    for legs in counted[_first_that(reaches, counted) :]:
        if not predictions.are_few(flown(legs, slowest_mps), legs):
            return
        fitted = _at_greatest_speed(flown(legs, fastest_mps), predictions, pod, fastest_mps)
        if fitted is not None:
            yield fitted


def _first_that(reaches: Callable[[int], bool], counted: Sequence[int]) -> int:
    """Return the index of the least number of legs that reaches what is wanted; that of the end if none does."""
    if not counted or reaches(counted[0]):
        return 0
    if len(counted) == 1 or not reaches(counted[-1]):
        return len(counted)
    # In growing steps, as few legs are counted sooner than many.
    low, high = 0, 1
    while high < len(counted) - 1 and not reaches(counted[high]):
        low, high = high, min(2 * high, len(counted) - 1)
    return bisect_left(counted, True, low + 1, high, key=reaches)


def _highest_rise_m(plan: MissionPlan, ground: ViewedGround) -> float:
    """Return by how much the place of the area that is nearest to the layers is nearer than level ground would be."""
    if ground.is_level:
        return 0.0
    rises_m = ground.rises_m(spread_places(plan.area_enu_m, PLACES))
    return float(rises_m[np.isfinite(rises_m)].max(initial=0.0))


def _at_greatest_speed(
    plan: MissionPlan, predictions: _Predictions, pod: float, fastest_mps: float
) -> SearchPattern | None:
    legs = predictions.legs_of(plan)

    def detection(speed_mps: float) -> float:
        return predictions.detection(replace(plan, search_speed_mps=speed_mps), legs)

    if detection(fastest_mps) >= pod:
        speed_mps = fastest_mps
    else:
        slowest_mps = min(SLOWEST_MPS, fastest_mps)
        tenths = range(math.floor(_PER_MPS * slowest_mps) + 1, math.ceil(_PER_MPS * fastest_mps))
        slower_mps = [slowest_mps, *(tenth / _PER_MPS for tenth in tenths)]
        enough = bisect_left(slower_mps, True, key=lambda mps: detection(mps) < pod)
        if not enough:
            return None
        speed_mps = slower_mps[enough - 1]
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
