"""Scan legs: the straight sweeps of the swarm's line that cover a search area."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.polygon import as_polygon
from aos_gcs.errors import ConfigurationError
from aos_gcs.swarm.line import in_projection_order, line_axis, line_places, unit_vector

FloatArray = NDArray[np.float64]


PASSES_APART_M: Final = 2.0
"""Distance of a pass over the legs from the one before: as much as makes a view independent, with what poses err by."""


@dataclass(frozen=True, slots=True)
class ScanLeg:
    """One straight sweep of the swarm's line, described by the path of its centre."""

    start_enu_m: tuple[float, float]
    direction_enu: tuple[float, float]
    """Unit vector."""
    length_m: float

    @property
    def end_enu_m(self) -> tuple[float, float]:
        """Place of the line's centre at the end of the leg."""
        (east_m, north_m), (east, north) = self.start_enu_m, self.direction_enu
        return (east_m + self.length_m * east, north_m + self.length_m * north)

    @property
    def reversed(self) -> ScanLeg:
        """The same leg, flown from its end to its start."""
        east, north = self.direction_enu
        return ScanLeg(self.end_enu_m, (-east, -north), self.length_m)

    def beside(self, right_m: float) -> ScanLeg:
        """Return the leg displaced to the right of its direction."""
        (east_m, north_m), (east, north) = self.start_enu_m, self.direction_enu
        return ScanLeg((east_m + right_m * north, north_m - right_m * east), self.direction_enu, self.length_m)

    def after(self, flown_m: float) -> ScanLeg:
        """Return what is left of the leg once its first ``flown_m`` metres are flown."""
        (east_m, north_m), (east, north) = self.start_enu_m, self.direction_enu
        start_enu_m = (east_m + flown_m * east, north_m + flown_m * north)
        return ScanLeg(start_enu_m, self.direction_enu, max(0.0, self.length_m - flown_m))


def scan_legs(
    area_enu_m: Sequence[Sequence[float]],
    start_enu_m: FloatArray,
    direction_enu: FloatArray,
    *,
    n: int,
    spacing_m: float,
    footprint_m: float,
    leg_spacing_m: float | None = None,
) -> tuple[ScanLeg, ...]:
    """Return parallel legs, to and fro, on which the swarm's line sweeps the whole area.

    The line covers a swath of n - 1 spacings plus one footprint. The area is cut into the fewest strips of equal width
    that a swath covers, or narrower ones, each with a leg along its middle and as long as the area is there. The first
    leg begins at the corner of the pattern that is nearest to the start, and heads into the area.

    Args:
        area_enu_m: simple polygon, shape (m, 2), metres.
        start_enu_m: place that the swarm comes from, shape (2,), metres.
        direction_enu: axis of the legs, shape (2,); legs run in both directions along it.
        n: number of vehicles.
        spacing_m: distance of the vehicles in the line, metres.
        footprint_m: width on the ground that one camera sees, metres.
        leg_spacing_m: greatest width of a strip, metres; None: a swath.

    Raises:
        ConfigurationError: the area is no simple polygon, or a number is out of its range.
    """
    vertices_m = as_polygon(area_enu_m, "area_enu_m")
    if n < 1:
        raise ConfigurationError(f"n must be 1 or more vehicles, but is {n}.")
    _require_positive("spacing_m", spacing_m)
    _require_positive("footprint_m", footprint_m)
    swath_m = (n - 1) * spacing_m + footprint_m
    if leg_spacing_m is not None:
        _require_positive("leg_spacing_m", leg_spacing_m)
        swath_m = min(swath_m, leg_spacing_m)
    try:
        along = unit_vector(np.asarray(direction_enu, dtype=np.float64))
    except ValueError as error:
        raise ConfigurationError(f"direction_enu must have a length above 0: {error}.") from error
    axes = np.column_stack([along, line_axis(along)])
    spans_m = _strip_spans(vertices_m @ axes, leg_count(vertices_m, along, swath_m))
    return _to_and_fro(spans_m, np.asarray(start_enu_m, dtype=np.float64) @ axes, axes)


def in_passes(legs: Sequence[ScanLeg], passes: int) -> tuple[ScanLeg, ...]:
    """Return legs flown several times: every other time from the last one's end back to the first one's start.

    Passes lie beside each other, so that each sees through other gaps than the one before.

    Args:
        legs: legs in the order in which they are flown first.
        passes: number of times.
    """
    back = [leg.reversed for leg in reversed(legs)]
    return tuple(
        leg.beside(number * PASSES_APART_M) for number in range(passes) for leg in (back if number % 2 else legs)
    )


def leg_count(area_enu_m: Sequence[Sequence[float]] | FloatArray, direction_enu: FloatArray, swath_m: float) -> int:
    """Return how many legs :func:`scan_legs` has for a swath, shape of the area (m, 2), without making them."""
    across_m = np.asarray(area_enu_m, dtype=np.float64) @ line_axis(unit_vector(direction_enu))
    return max(1, math.ceil((float(across_m.max()) - float(across_m.min())) / swath_m - 1e-9))


def leg_formation(leg: ScanLeg, positions_enu_m: FloatArray, spacing_m: float) -> FloatArray:
    """Return each vehicle's place in the line at the start of a leg, shape (n, 2), in the order of the rows.

    Places are taken in the order of the vehicles' projections on the line, so that no paths cross.
    """
    direction_enu = np.array(leg.direction_enu)
    places_m = line_places(np.array(leg.start_enu_m), direction_enu, len(positions_enu_m), spacing_m)
    return in_projection_order(positions_enu_m, places_m)


def line_on(leg: ScanLeg, places_enu_m: FloatArray, spacing_m: float) -> FloatArray:
    """Return the places of a line across a leg as far along it as the middle of some places is, shape (n, 2)."""
    along_m = float((places_enu_m.mean(axis=0) - np.array(leg.start_enu_m)) @ np.array(leg.direction_enu))
    return leg_formation(leg.after(along_m), places_enu_m, spacing_m)


def _strip_spans(vertices_m: FloatArray, count: int) -> FloatArray:
    """Return per strip its middle across, and the first and last place along of the area in it, shape (k, 3).

    Args:
        vertices_m: polygon in the axes (along, across), shape (m, 2).
        count: number of strips of equal width.
    """
    low_m, high_m = float(vertices_m[:, 1].min()), float(vertices_m[:, 1].max())
    borders_m = np.linspace(low_m, high_m, count + 1)
    spans = []
    for lower_m, upper_m in pairwise(borders_m.tolist()):
        along_m = _along_within(vertices_m, lower_m, upper_m)
        spans.append(((lower_m + upper_m) / 2.0, along_m.min(), along_m.max()))
    return np.array(spans)


def _along_within(vertices_m: FloatArray, lower_m: float, upper_m: float) -> FloatArray:
    """Return the places along at which the outline lies in or enters a strip; their extremes bound the area in it."""
    ends_m = np.roll(vertices_m, -1, axis=0)
    inside = (vertices_m[:, 1] >= lower_m) & (vertices_m[:, 1] <= upper_m)
    places = [vertices_m[inside, 0]]
    for border_m in (lower_m, upper_m):
        crosses = (vertices_m[:, 1] < border_m) != (ends_m[:, 1] < border_m)
        start, end = vertices_m[crosses], ends_m[crosses]
        places.append(start[:, 0] + (border_m - start[:, 1]) / (end[:, 1] - start[:, 1]) * (end[:, 0] - start[:, 0]))
    return np.concatenate(places)


def _to_and_fro(spans_m: FloatArray, start_m: FloatArray, axes: FloatArray) -> tuple[ScanLeg, ...]:
    """Return the legs of the strips, in the order and direction that begin nearest to ``start_m`` (along, across)."""
    candidates = []
    for ordered_m in (spans_m, spans_m[::-1]):
        across_m, first_m, last_m = ordered_m[0]
        candidates.append((math.hypot(first_m - start_m[0], across_m - start_m[1]), ordered_m, 1.0))
        candidates.append((math.hypot(last_m - start_m[0], across_m - start_m[1]), ordered_m, -1.0))
    _, ordered_m, sign = min(candidates, key=lambda candidate: candidate[0])
    legs = []
    for across_m, first_m, last_m in ordered_m:
        begin_m = first_m if sign > 0.0 else last_m
        start = axes @ np.array([begin_m, across_m])
        direction = sign * axes[:, 0]
        legs.append(ScanLeg(_pair(start), _pair(direction), float(last_m - first_m)))
        sign = -sign
    return tuple(legs)


def _pair(vector: FloatArray) -> tuple[float, float]:
    return (float(vector[0]), float(vector[1]))


def _require_positive(field: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise ConfigurationError(f"{field} must be a finite number above 0, but is {value}.")
