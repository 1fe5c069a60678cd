"""Order of the legs of a search: the sooner the person is likely to be noticed, the better.

Legs to and fro are the shortest flight, and stay where all places gain alike. Where one part of the area is likelier
than another, or was seen already, the legs that gain most probability of success per second are flown first: what a leg
gains is, summed over its places, the prior times what the views of one pass add to the probability of detection. What
it costs is the flight to it, the forming of the line and the flight along it. A leg may be cut, so that the likely part
of a long one is flown first.

Such orders are greedy, and may fly far for little. So the orders to and fro, those of whole legs and of cut ones are
compared by the mean time until the person is noticed (who is not noticed counts with the end of the flight), and the
legs stay to and fro unless another order is clearly better.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.groundmap.detection import DETECTABILITY, Posture, detection_by_views
from aos_gcs.groundmap.figures import ViewRaster, view_raster
from aos_gcs.groundmap.tile import MAX_VIEWS
from aos_gcs.groundmap.work import GroundSource, SearchedArea, opened_map
from aos_gcs.planning.detection.expected_views import expected_views, forest_directions, line_of, spread_places
from aos_gcs.planning.estimate import STILL_S, move_s, scan_step_m
from aos_gcs.planning.legs import ScanLeg, in_passes
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.search_settings import SearchMode
from aos_gcs.prior.model import AreaPrior
from aos_gcs.prior.shapes import inside_ring
from aos_gcs.swarm.line import line_axis

FloatArray = NDArray[np.float64]

FORMING_S: Final = 15.0
"""Time in which the line is formed, and the vehicles come to rest behind it."""
WORTH_IT: Final = 0.97
"""Share of the mean time to and fro below which another order is flown."""
_BIN_M: Final = 20.0
_MOST_BINS: Final = 60
"""Bins of the longest leg at most: pairs of them are compared."""
_SHORTEST_M: Final = (120.0, 300.0)
"""Shortest parts that legs are cut into, each tried."""
_MOST_LEGS: Final = 100
_PLACES: Final = 3000
_PLACES_ACROSS: Final = 40
"""Places across a line at which the views of a pass are counted."""
_PASS_M: Final = 400.0
"""Length of that pass."""
_UNKNOWN_DETECTION: Final = 0.8
"""Probability of detection of one pass where the forest is not described."""


@dataclass(frozen=True, slots=True, eq=False)
class Chances:
    """Places of a search area, and the probability of success that one pass over each gains."""

    places_m: FloatArray
    """Shape (k, 2)."""
    gains: FloatArray
    """Shape (k,); together at most 1."""
    are_alike: bool = False
    """Whether all places of the area gain alike."""


def ordered_on_map(
    source: GroundSource,
    area: SearchedArea,
    plan: MissionPlan,
    plane_height_m: float,
    *,
    legs: Sequence[ScanLeg],
    from_m: tuple[float, float],
    since_s: float | None = None,
) -> tuple[ScanLeg, ...]:
    """Return legs in the order for what a map says was searched; for a worker that has the map open.

    Args:
        source: map of the searched ground.
        area: search area, with its prior.
        plan: plan of the mission; its vehicles are those that fly.
        plane_height_m: height of the focal plane above the origin.
        legs: legs to and fro.
        from_m: place that the swarm comes from.
        since_s: UTC time from which on views count; None: all count.

    Raises:
        InputDataError: the map cannot be read.
    """
    raster = view_raster(opened_map(source).views_since(since_s), area.area_enu_m)
    return order_legs(legs, plan, chances_of(plan, plane_height_m, area.prior, raster), from_m)


def chances_of(
    plan: MissionPlan, plane_height_m: float, prior: AreaPrior | None, raster: ViewRaster | None = None
) -> Chances:
    """Return what one pass gains at the places of a plan's area.

    Args:
        plan: its area is not empty.
        plane_height_m: height of the focal plane above the origin.
        prior: where the person is likely to be; None: everywhere alike.
        raster: views that the places have already; None: none.
    """
    places_m = spread_places(plan.area_enu_m, _PLACES) if prior is None else _cells(prior)
    for zone_enu_m in plan.no_go_enu_m:
        places_m = places_m[~inside_ring(places_m, np.array(zone_enu_m, dtype=np.float64))]
    weights = np.full(len(places_m), 1.0 / max(1, len(places_m))) if prior is None else prior.weights(places_m)
    if plan.forest is None:
        return Chances(places_m, weights * _UNKNOWN_DETECTION, are_alike=prior is None)
    law = detection_by_views(plan.forest.occlusion, DETECTABILITY[Posture.STANDING])
    views = np.zeros(len(places_m), dtype=np.int64) if raster is None else raster.at(places_m)
    after = np.minimum(views + views_of_a_pass(plan, plane_height_m), MAX_VIEWS)
    # Places that a prior says nothing of are not among these.
    are_alike = prior is None and len(np.unique(views)) <= 1
    return Chances(places_m, weights * (law[after] - law[views]), are_alike=are_alike)


def order_legs(
    legs: Sequence[ScanLeg], plan: MissionPlan, chances: Chances, from_m: tuple[float, float]
) -> tuple[ScanLeg, ...]:
    """Return legs of all passes, whole or cut, in the order in which the person is likely to be noticed soonest.

    Those of a pass together cover the same ground, and the second pass flies the first one's back. Equal arguments give
    equal results.

    Args:
        legs: legs of one pass to and fro, neighbours following each other.
        plan: plan that they are part of, with the vehicles that fly.
        chances: what a pass gains.
        from_m: place that the swarm comes from.
    """
    if not legs or not len(chances.places_m) or chances.are_alike:
        return in_passes(legs, plan.passes)
    bin_m = max(_BIN_M, max(leg.length_m for leg in legs) / _MOST_BINS)
    strips = [_strip(leg, strip_width_m(plan, legs), chances, bin_m) for leg in legs]
    pace = _Pace(plan.cruise_speed_mps, _leg_mps(plan), bin_m)
    to_and_fro = [
        [_Part(number, 0, strip.bins, is_back) for number, strip, is_back in order] for order in _snakes(strips)
    ]
    shortest = [math.ceil(length_m / bin_m) for length_m in _SHORTEST_M]
    greedy = [_greedy(strips, from_m, pace, least) for least in (_MOST_BINS + 1, *shortest)]
    plain, *others = [order for order in (*to_and_fro, *greedy) if len(order) <= max(len(legs), _MOST_LEGS)]
    plain_s = _mean_time_s(plain, strips, from_m, pace)
    best_s, best = min(
        ((_mean_time_s(order, strips, from_m, pace), number) for number, order in enumerate(others)),
        default=(math.inf, -1),
    )
    order = others[best] if best_s < WORTH_IT * plain_s else plain
    return in_passes([strips[part.strip].part(part, bin_m) for part in order], plan.passes)


def strip_width_m(plan: MissionPlan, legs: Sequence[ScanLeg]) -> float:
    """Return the distance of neighbouring legs; that of an only one is what the line is wide."""
    if len(legs) < 2:
        return plan.vehicles * plan.on_legs_m
    across = line_axis(np.array(legs[0].direction_enu))
    return abs(float((np.array(legs[1].start_enu_m) - np.array(legs[0].start_enu_m)) @ across))


def views_of_a_pass(plan: MissionPlan, plane_height_m: float) -> int:
    """Return how many independent views a place below the line gets from one pass, on average across it."""
    if plan.forest is None:
        return 0
    leg = ScanLeg((0.0, 0.0), (0.0, 1.0), _PASS_M)
    line = line_of(plan, plane_height_m)
    half_m = max(float(line.aside_m[-1]), 5.0)
    across_m = np.linspace(-half_m, half_m, _PLACES_ACROSS)
    places_m = np.column_stack((across_m, np.linspace(197.0, 203.0, _PLACES_ACROSS)))
    return max(1, round(float(expected_views(places_m, [leg], line, forest_directions(plan.forest)).mean())))


def exposures_of_a_pass(plan: MissionPlan, plane_height_m: float) -> float:
    """Return how many exposures ``views_of_a_pass`` counts at most."""
    if plan.forest is None:
        return 0.0
    line = line_of(plan, plane_height_m)
    views_m = np.minimum(2.0 * line.heights_m * line.half_view, _PASS_M)
    return float(_PLACES_ACROSS * (views_m / line.interval_m + 1.0).sum())


@dataclass(frozen=True, slots=True)
class _Pace:
    """Speeds of a flight."""

    cruise_mps: float
    leg_mps: float
    bin_m: float


@dataclass(frozen=True, slots=True)
class _Part:
    """A part of a strip, from one bin to another, and whether it is flown against the direction of the leg."""

    strip: int
    first: int
    end: int
    is_back: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Strip:
    """A leg, and the gains of the places in its strip by bins along it."""

    leg: ScanLeg
    gains: FloatArray
    """Shape (bins,)."""
    sums: FloatArray
    """Gains of all bins before each, shape (bins + 1,)."""
    ends_m: FloatArray
    """Places of the borders of bins, shape (bins + 1, 2)."""

    @property
    def bins(self) -> int:
        return len(self.gains)

    def part(self, part: _Part, bin_m: float) -> ScanLeg:
        """Return a part as a leg."""
        leg, (east, north) = self.leg, self.leg.direction_enu
        begin_m, end_m = part.first * bin_m, min(part.end * bin_m, leg.length_m)
        if part.is_back:
            whole = ScanLeg(leg.end_enu_m, (-east, -north), leg.length_m)
            start_enu_m = whole.after(leg.length_m - end_m).start_enu_m
            return ScanLeg(start_enu_m, whole.direction_enu, end_m - begin_m)
        return leg if (begin_m, end_m) == (0.0, leg.length_m) else ScanLeg(
            leg.after(begin_m).start_enu_m, leg.direction_enu, end_m - begin_m
        )  # fmt: skip


def _strip(leg: ScanLeg, width_m: float, chances: Chances, bin_m: float) -> _Strip:
    along = np.array(leg.direction_enu)
    offset_m = chances.places_m - np.array(leg.start_enu_m)
    along_m, across_m = offset_m @ along, offset_m @ line_axis(along)
    inside = (np.abs(across_m) <= width_m / 2.0) & (along_m >= 0.0) & (along_m < leg.length_m)
    count = max(1, math.ceil(leg.length_m / bin_m - 1e-9))
    bins = np.minimum((along_m[inside] / bin_m).astype(np.int64), count - 1)
    gains = np.asarray(np.bincount(bins, chances.gains[inside], count), dtype=np.float64)
    ends_along_m = np.minimum(np.arange(count + 1) * bin_m, leg.length_m)
    ends_m = np.array(leg.start_enu_m) + ends_along_m[:, np.newaxis] * along
    return _Strip(leg, gains, np.concatenate(([0.0], np.cumsum(gains))), ends_m)


def _snakes(strips: Sequence[_Strip]) -> list[list[tuple[int, _Strip, bool]]]:
    """Return the orders to and fro: as given, and from the other three corners."""
    given = list(enumerate(strips))
    return [
        [(number, strip, back) for number, strip in order] for order in (given, given[::-1]) for back in (False, True)
    ]


def _greedy(strips: Sequence[_Strip], from_m: tuple[float, float], pace: _Pace, least: int) -> list[_Part]:
    """Return all strips in parts of at least so many bins, each time the one that gains most per second."""
    free = [(number, 0, strip.bins) for number, strip in enumerate(strips)]
    here_m, order = np.array(from_m), list[_Part]()
    while free and len(order) <= _MOST_LEGS:
        found = [_best(strips[stretch[0]], stretch, here_m, pace, least) for stretch in free]
        at = max(range(len(found)), key=lambda index: (found[index][0], -index))
        number, low, high = free.pop(at)
        part = found[at][1]
        free += [(number, *rest) for rest in ((low, part.first), (part.end, high)) if rest[0] < rest[1]]
        free.sort()
        order.append(part)
        here_m = strips[number].ends_m[part.first if part.is_back else part.end]
    return order


def _best(
    strip: _Strip, stretch: tuple[int, int, int], here_m: FloatArray, pace: _Pace, least: int
) -> tuple[float, _Part]:
    """Return the greatest gain per second of a part within a stretch that is not flown yet, and the part."""
    number, low, high = stretch
    first, end = np.triu_indices(high - low + 1, min(least, high - low))
    first, end = first + low, end + low
    # What is left on both sides must be worth a line, too.
    fits = ((first == low) | (first - low >= least)) & ((end == high) | (high - end >= least))
    first, end = first[fits], end[fits]
    length_m = np.linalg.norm(strip.ends_m[end] - strip.ends_m[first], axis=1)
    to_first_m, to_end_m = (np.linalg.norm(strip.ends_m[one] - here_m, axis=1) for one in (first, end))
    seconds = FORMING_S + np.minimum(to_first_m, to_end_m) / pace.cruise_mps + length_m / pace.leg_mps
    # Where nothing is to be gained, what is near is flown first.
    rates = (strip.sums[end] - strip.sums[first] + 1e-9) / seconds
    at = int(rates.argmax())
    return float(rates[at]), _Part(number, int(first[at]), int(end[at]), bool(to_end_m[at] < to_first_m[at]))


def _mean_time_s(order: Sequence[_Part], strips: Sequence[_Strip], from_m: tuple[float, float], pace: _Pace) -> float:
    here_m, now_s, noticed, weighted_s = np.array(from_m), 0.0, 0.0, 0.0
    for part in order:
        strip = strips[part.strip]
        start, end = (np.array(place) for place in _ends(strip.part(part, pace.bin_m)))
        now_s += FORMING_S + move_s(float(np.linalg.norm(start - here_m)), pace.cruise_mps)
        gains = strip.gains[part.first : part.end]
        gains = gains[::-1] if part.is_back else gains
        flown_s = float(np.linalg.norm(end - start)) / pace.leg_mps
        weighted_s += float(gains @ (now_s + (np.arange(len(gains)) + 0.5) / len(gains) * flown_s))
        noticed += float(gains.sum())
        here_m, now_s = end, now_s + flown_s
    return weighted_s + (1.0 - noticed) * now_s


def _ends(leg: ScanLeg) -> tuple[tuple[float, float], tuple[float, float]]:
    return leg.start_enu_m, leg.end_enu_m


def _leg_mps(plan: MissionPlan) -> float:
    if plan.search_mode is SearchMode.CONTINUOUS:
        return plan.leg_speed_mps
    step_m = scan_step_m(plan)
    return step_m / (move_s(step_m, plan.cruise_speed_mps) + STILL_S)


def _cells(prior: AreaPrior) -> FloatArray:
    """Return the middles of the cells that have any probability, shape (k, 2)."""
    rows, columns = np.nonzero(prior.mass)
    east_m = prior.west_m + (columns + 0.5) * prior.cell_m
    return np.column_stack((east_m, prior.north_m - (rows + 0.5) * prior.cell_m))
