"""Legs for what a search has left: the stretches that gain most probability of success per second.

Candidates are stretches of strips across the search area, along its legs and displaced by half a spacing of the
vehicles, so that views come from new directions. The gain of a stretch is what its expected views add to the
probability of detection of the places in it, weighted by the prior where there is one; the cost is the flight to it,
the forming of the line and the flight along it. The best stretch is taken, its views count as made, and so on:
greedily, as places that are well seen gain little.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.groundmap.detection import DETECTABILITY, Posture, detection_by_views
from aos_gcs.groundmap.figures import ViewRaster, view_raster
from aos_gcs.groundmap.tile import MAX_VIEWS, VIEW_CELL_M
from aos_gcs.groundmap.work import GroundSource, SearchedArea, opened_map
from aos_gcs.planning.estimate import planned_legs
from aos_gcs.planning.leg_order import FORMING_S, strip_width_m, views_of_a_pass
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.terrain.viewed_ground import LEVEL_GROUND, ViewedGround
from aos_gcs.prior.model import AreaPrior
from aos_gcs.swarm.line import line_axis

FloatArray = NDArray[np.float64]

_STRIDE: Final = 3
"""Every third cell of the map on each axis is looked at."""
_BIN_M: Final = 10.0
"""Stretches begin and end at multiples of it."""
_SHORTEST_BINS: Final = 2
_LEAST_GAIN_PER_S: Final = 2e-6
"""Gain per second below which a stretch is not worth a flight: a ten thousandth in a minute."""
_LEAST_HEIGHT_M: Final = 1.0
"""Height above the ground that views are counted for at least."""
_RISES: Final = 5
"""Heights of the ground for which the views of a pass are counted; between them they are interpolated."""
_MOST_LEGS: Final = 50


@dataclass(frozen=True, slots=True)
class GapLegs:
    """Stretches that are worth flying, in the order in which they are flown."""

    legs: tuple[ScanLeg, ...]
    detection_before: float
    """Mean probability of detection of a standing person over the search area."""
    detection_after: float
    """The same when all these legs are flown."""
    takes_s: float


def legs_for_gaps(
    source: GroundSource,
    area: SearchedArea,
    plan: MissionPlan,
    plane_height_m: float,
    *,
    from_m: tuple[float, float],
    within_s: float,
    pod: float,
    ground: ViewedGround = LEVEL_GROUND,
    since_s: float | None = None,
) -> GapLegs | None:
    """Return the legs that gain most; for a worker that has the map open.

    Args:
        source: map of the searched ground.
        area: search area, with its prior.
        plan: plan of the mission; its vehicles are those that fly.
        plane_height_m: height of the focal plane above the ground.
        from_m: place that the swarm comes from.
        within_s: time that the legs may take.
        pod: probability of detection at which no more are needed.
        ground: ground of the area, below the layers.
        since_s: UTC time from which on views count; None: all count.

    Returns:
        None where the forest is not described.

    Raises:
        InputDataError: the map cannot be read.
    """
    raster = view_raster(opened_map(source).views_since(since_s), area.area_enu_m)
    return find_gap_legs(
        raster, plan, plane_height_m, from_m=from_m, within_s=within_s, pod=pod, ground=ground, prior=area.prior
    )


def find_gap_legs(
    raster: ViewRaster,
    plan: MissionPlan,
    plane_height_m: float,
    *,
    from_m: tuple[float, float],
    within_s: float,
    pod: float,
    ground: ViewedGround = LEVEL_GROUND,
    prior: AreaPrior | None = None,
) -> GapLegs | None:
    """Return the legs that gain most for views that are known; arguments and result as of :func:`legs_for_gaps`.

    ``prior`` says where the person is likely to be, which orders what is flown; None: everywhere alike.
    """
    if plan.forest is None or not plan.area_enu_m:
        return None
    law = detection_by_views(plan.forest.occlusion, DETECTABILITY[Posture.STANDING])
    places_m, views = _places(raster, plan)
    if not len(places_m):
        return None
    strips = _strips(plan, plane_height_m, places_m)
    added = _views_of_passes(plan, plane_height_m, ground.rises_m(places_m))
    before = float(law[views].mean())
    weights = np.full(len(views), 1.0 / len(views)) if prior is None else prior.weights(places_m)
    legs: list[ScanLeg] = []
    here_m, takes_s, detection = from_m, 0.0, before
    while detection < pod and len(legs) < _MOST_LEGS:
        gains = (law[np.minimum(views + added, MAX_VIEWS)] - law[views]) * weights
        found = [one for strip in strips if (one := strip.best(gains, here_m, plan)) is not None]
        best = max(found, key=lambda one: one.rate, default=None)
        if best is None or best.rate < _LEAST_GAIN_PER_S or takes_s + best.seconds > within_s:
            break
        views[best.cells] = np.minimum(views[best.cells] + added[best.cells], MAX_VIEWS)
        legs.append(best.leg)
        here_m, takes_s, detection = best.leg.end_enu_m, takes_s + best.seconds, float(law[views].mean())
    return GapLegs(tuple(legs), before, detection, takes_s)


@dataclass(frozen=True, slots=True, eq=False)
class _Stretch:
    """A stretch of a strip, and what it gains."""

    leg: ScanLeg
    cells: NDArray[np.intp]
    seconds: float
    rate: float
    """Gain of probability of success per second."""


@dataclass(frozen=True, slots=True, eq=False)
class _Strip:
    """A strip across the area, and the places in it."""

    leg: ScanLeg
    cells: NDArray[np.intp]
    bins: NDArray[np.intp]
    """Number of the stretch of ``_BIN_M`` along the leg in which each place lies."""

    def best(self, gains: FloatArray, here_m: tuple[float, float], plan: MissionPlan) -> _Stretch | None:
        """Return the stretch with the greatest gain per second."""
        count = math.ceil(self.leg.length_m / _BIN_M)
        if count < 1 or not len(self.cells):
            return None
        sums = np.concatenate(([0.0], np.cumsum(np.bincount(self.bins, gains[self.cells], count))))
        first, end = np.triu_indices(count + 1, min(_SHORTEST_BINS, count))
        length_m = np.minimum(end * _BIN_M, self.leg.length_m) - first * _BIN_M
        along, start_m = np.array(self.leg.direction_enu), np.array(self.leg.start_enu_m)
        near_m = float((np.array(here_m) - start_m) @ along)
        aside_m = abs(float((np.array(here_m) - start_m) @ line_axis(along)))
        to_first_m = np.hypot(near_m - first * _BIN_M, aside_m)
        to_end_m = np.hypot(near_m - first * _BIN_M - length_m, aside_m)
        way_m = np.minimum(to_first_m, to_end_m)
        seconds = FORMING_S + way_m / plan.cruise_speed_mps + length_m / plan.leg_speed_mps
        rates = (sums[end] - sums[first]) / seconds
        at = int(rates.argmax())
        low, high = int(first[at]), int(end[at])
        stretch = ScanLeg(self.leg.after(low * _BIN_M).start_enu_m, self.leg.direction_enu, float(length_m[at]))
        if to_end_m[at] < to_first_m[at]:
            east, north = self.leg.direction_enu
            stretch = ScanLeg(stretch.end_enu_m, (-east, -north), stretch.length_m)
        cells = self.cells[(self.bins >= low) & (self.bins < high)]
        return _Stretch(stretch, cells, float(seconds[at]), float(rates[at]))


def _places(raster: ViewRaster, plan: MissionPlan) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return places of the search area outside of no-go zones, shape (k, 2), and their numbers of views."""
    inside = raster.inside(plan.area_enu_m)
    for zone_enu_m in plan.no_go_enu_m:
        inside &= ~raster.inside(zone_enu_m)
    rows, columns = np.nonzero(inside[::_STRIDE, ::_STRIDE])
    views = raster.views[::_STRIDE, ::_STRIDE][rows, columns].astype(np.int64)
    east_m = raster.west_m + (columns * _STRIDE + 0.5) * VIEW_CELL_M
    north_m = raster.north_m - (rows * _STRIDE + 0.5) * VIEW_CELL_M
    return np.column_stack((east_m, north_m)), views


def _strips(plan: MissionPlan, plane_height_m: float, places_m: FloatArray) -> list[_Strip]:
    """Return the strips of a plan, along its legs and across them, displaced by half a spacing."""
    strips = []
    for heading_rad in (plan.scan_heading_rad, plan.scan_heading_rad + math.pi / 2.0):
        legs = planned_legs(plan, plane_height_m, heading_rad)
        width_m = strip_width_m(plan, legs)
        for leg in legs:
            along = np.array(leg.direction_enu)
            aside_m = line_axis(along) * plan.on_legs_m / 2.0 if plan.vehicles > 1 else np.zeros(2)
            start_m = np.array(leg.start_enu_m) + aside_m
            displaced = ScanLeg((float(start_m[0]), float(start_m[1])), leg.direction_enu, leg.length_m)
            along_m, across_m = (places_m - start_m) @ along, np.abs((places_m - start_m) @ line_axis(along))
            (cells,) = np.nonzero((across_m <= width_m / 2.0) & (along_m >= 0.0) & (along_m < leg.length_m))
            strips.append(_Strip(displaced, cells, (along_m[cells] / _BIN_M).astype(np.intp)))
    return strips


def _views_of_passes(plan: MissionPlan, plane_height_m: float, rises_m: FloatArray) -> NDArray[np.int64]:
    """Return how many independent views places below the line get from one pass each, on average across it, shape (k,).

    Args:
        plan: plan of the mission.
        plane_height_m: height of the focal plane above the ground.
        rises_m: by how much each place is nearer to the layers than level ground would be; NaN where it is not known.
    """
    known = np.isfinite(rises_m)
    if not known.any():
        return np.zeros(len(rises_m), dtype=np.int64)
    highest_m = plan.lowest_layer_m - plane_height_m - _LEAST_HEIGHT_M
    low_m, high_m = np.minimum((rises_m[known].min(), rises_m[known].max()), highest_m)
    levels_m = np.unique(np.linspace(low_m, high_m, _RISES))
    views = [views_of_a_pass(plan, plane_height_m + level_m) for level_m in levels_m.tolist()]
    at_places = np.interp(np.where(known, rises_m, low_m), levels_m, views)
    return np.where(known, np.rint(at_places), 0).astype(np.int64)
