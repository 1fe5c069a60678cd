"""Airborne vehicles, where they may be, and how far a segment keeps its distance to them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.accuracy import CONFIDENCE, EXACT, Accuracy, Clearance, clearances, joint_errors_m
from aos_gcs.airspace.separation import TOLERANCE_M, admissible_fraction, point_segment_distance, segment_distance

FloatArray = NDArray[np.float64]

MIN_MOVE_M = 0.1
"""Shortened segments below this length are not worth a command."""
TURN_SPACING_M = 0.5
"""Distance of two places from which a vehicle without contact may fly home, or above which one that lands may be."""
MAX_TURNS = 400
"""Greatest number of such places on one way: on longer ones than 200 m they are farther apart."""
_WORTH_TELLING_M = 0.1
"""Difference of horizontal and vertical limit from which both are told."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class WaypointRequest:
    """A vehicle's state, and the waypoint that it is to be sent to."""

    vehicle_id: int
    position_enu_m: FloatArray
    """Shape (3,)."""
    requested_enu_m: FloatArray
    """Shape (3,)."""
    link_age_s: float | None
    """Seconds since its last message; None if never heard."""
    position_age_s: float | None
    """Seconds since its last position; None if it never reported one."""
    battery_fraction: float | None
    """None skips the check: for a vehicle that flies home, which a low battery must not keep in the air. Preflight
    checks that a vehicle reports its battery at all."""
    home_enu_m: FloatArray | None = None
    """Shape (3,); needed when the energy to return is limited."""
    battery_per_m: float | None = None
    """Battery fraction that a metre of its flight costs, as measured; None leaves it to the limits."""
    accuracy: Accuracy = EXACT
    waypoint_enu_m: FloatArray | None = None
    """Waypoint that it flies to now, shape (3,): the segment to it is occupied until the vehicle is sent elsewhere. One
    that is held flies on there."""
    stop_enu_m: FloatArray | None = None
    """Place where it would come to rest if it were commanded to stop now, shape (3,): occupied whatever follows."""

    def segments(self) -> FloatArray:
        """Return the segments on which the vehicle may be while it is not sent elsewhere, shape (3, 2, 3)."""
        ends = [self.position_enu_m, self.stop_enu_m, self.waypoint_enu_m]
        return np.array([[self.position_enu_m, self.position_enu_m if end is None else end] for end in ends])


@dataclass(frozen=True, slots=True, eq=False)
class Obstacle:
    """Another airborne vehicle."""

    vehicle_id: int
    position_enu_m: FloatArray
    """Shape (3,)."""
    waypoint_enu_m: FloatArray | None = None
    """Waypoint that it was sent to, shape (3,): the segment to it is occupied, too."""
    column: bool = False
    """Whether it returns, lands or climbs: everything between ``bottom_m`` and ``top_m`` is occupied."""
    top_m: float | None = None
    """Height above the origin that a climbing vehicle will reach; None: its present height."""
    bottom_m: float = 0.0
    """Height above the origin down to which it may descend."""
    home_enu_m: FloatArray | None = None
    """Launch point, shape (3,), that its autopilot returns to: the path there and the column above it are occupied,
    too."""
    turn_enu_m: FloatArray | None = None
    """Place at which it may turn for home at the latest, shape (3,): it may turn anywhere up to there, and the paths
    home from all of that way are occupied, too."""
    return_up_m: float | None = None
    """Height above the origin to which its autopilot climbs before it returns; None: it returns at its present one."""
    accuracy: Accuracy = EXACT
    stop_enu_m: FloatArray | None = None
    """Place where it would come to a stop if it were told to now, shape (3,): the segment to it is occupied, too."""
    drift_m: float = 0.0
    """Distance beside its segments that is occupied, too: a vehicle with a pilot does not stay where it is."""
    lands: bool = False
    """Whether it lands, also while it still moves: all below the way to its stop is occupied, too."""
    left_alone: str = ""
    """What keeps it from being asked to make way, such as "which has a pilot": others below it move out of its column,
    and fly around it while it hovers. Empty for a vehicle that can be asked, or is on its way."""

    @property
    def reckoned(self) -> Accuracy:
        """Accuracy of its position that paths of others take into account, the drift included."""
        return Accuracy(self.accuracy.horizontal_m + self.drift_m / CONFIDENCE, self.accuracy.vertical_m)

    def segments(self) -> FloatArray:
        """Return the segments on which the vehicle may be, shape (k, 2, 3)."""
        here = np.array(self.position_enu_m, dtype=np.float64)
        segments = [self._column(here) if self.column else np.array([here, here])]
        segments += [np.array([here, end]) for end in (self.waypoint_enu_m, self.stop_enu_m) if end is not None]
        if self.lands and self.stop_enu_m is not None:
            segments += [self._column(place_enu_m) for place_enu_m in _places(here, self.stop_enu_m)]
        if self.home_enu_m is not None:
            turns = self._turns(here)
            if self.return_up_m is not None:
                turns[:, 2] = np.maximum(turns[:, 2], self.return_up_m)
            above_home = turns.copy()
            above_home[:, :2] = self.home_enu_m[:2]
            segments += list(np.stack([turns, above_home], axis=1))
            segments.append(self._column(above_home[above_home[:, 2].argmax()]))
        return np.array(segments)

    def _turns(self, here_enu_m: FloatArray) -> FloatArray:
        """Return places from where it may fly home, shape (k, 3), close together."""
        return _places(here_enu_m, here_enu_m if self.turn_enu_m is None else self.turn_enu_m)

    def _column(self, position_enu_m: FloatArray) -> FloatArray:
        """Return all that it occupies above and below a place on its way."""
        low, high = position_enu_m.copy(), position_enu_m.copy()
        low[2] = min(self.bottom_m, low[2])
        high[2] = max(height_m for height_m in (high[2], self.top_m, self.return_up_m) if height_m is not None)
        return np.array([low, high])

    def is_near(self, start_enu_m: FloatArray, end_enu_m: FloatArray, accuracy: Accuracy, separation_m: float) -> bool:
        """Return whether another vehicle on any of some straight paths may come within the separation.

        Args:
            start_enu_m: start of the path, shape (3,), or of each path, (n, 3).
            end_enu_m: end of the path, the same shape.
            accuracy: accuracy of the other vehicle's position.
            separation_m: smallest true distance.
        """
        segments, errors_m = self.segments(), joint_errors_m(accuracy, self.reckoned)
        return all(
            segment_distance(
                *(scale * end_m[..., None, :] for end_m in (start_enu_m, end_enu_m)),
                *(scale * end_m for end_m in (segments[:, 0], segments[:, 1])),
            ).min()
            < wide_m
            for one in clearances(separation_m, *np.atleast_2d(errors_m).T)
            for scale, wide_m in zip(one.scale(), one.wide_m, strict=True)
        )


def _places(start_enu_m: FloatArray, end_enu_m: FloatArray) -> FloatArray:
    """Return places on a way, shape (k, 3), close together, its ends included."""
    gaps = math.ceil(float(np.linalg.norm(end_enu_m - start_enu_m)) / TURN_SPACING_M)
    return np.linspace(start_enu_m, end_enu_m, min(gaps, MAX_TURNS) + 1)


@dataclass(frozen=True, slots=True)
class Admission:
    """The part of a segment that one limit admits, and why not more."""

    fraction: float
    reason: str


ALL_ADMITTED = Admission(1.0, "")


class Traffic:
    """The segments on which airborne vehicles may be: points of those that stay, segments of those that move.

    Args:
        requests: vehicles that are to be sent somewhere; each goes on as it does until :meth:`admit` is called for it.
        obstacles: all other airborne vehicles.
        separation_m: smallest true 3-D distance between two vehicles; reported ones keep more, by their accuracies.

    Raises:
        ValueError: an id occurs twice, or a position is not finite.
    """

    def __init__(self, requests: Sequence[WaypointRequest], obstacles: Sequence[Obstacle], separation_m: float) -> None:
        segments = {request.vehicle_id: request.segments() for request in requests}
        segments |= {obstacle.vehicle_id: obstacle.segments() for obstacle in obstacles}
        if len(segments) < len(requests) + len(obstacles):
            raise ValueError("each vehicle may occur once, as a request or as an obstacle")
        self._ids = np.array([vehicle_id for vehicle_id in sorted(segments) for _ in segments[vehicle_id]], dtype=int)
        ordered = [segments[vehicle_id] for vehicle_id in sorted(segments)]
        ends = np.concatenate(ordered, dtype=np.float64) if ordered else np.empty((0, 2, 3))
        if not np.isfinite(ends).all():
            raise ValueError("present positions must be finite; leave out a vehicle whose position is unknown")
        self._starts, self._ends = ends[:, 0].copy(), ends[:, 1].copy()
        self._separation_m = separation_m
        accuracies = {request.vehicle_id: request.accuracy for request in requests}
        accuracies |= {obstacle.vehicle_id: obstacle.reckoned for obstacle in obstacles}
        rows = [(accuracies[each].horizontal_m, accuracies[each].vertical_m) for each in self._ids.tolist()]
        self._set_clearances(np.array(rows).reshape(-1, 2))

    def _set_clearances(self, accuracies_m: FloatArray) -> None:
        """Compute the clearances between all kinds of accuracies at once, from those of the rows, shape (n, 2)."""
        kinds_m, self._kinds = np.unique(accuracies_m, axis=0, return_inverse=True)
        self._kinds = self._kinds.reshape(-1)
        errors_m = CONFIDENCE * np.hypot(kinds_m[:, None], kinds_m[None]).reshape(-1, 2)
        shape = (len(kinds_m), len(kinds_m))
        self._low, self._narrow = (
            Clearance(one.wide_m.reshape(shape), one.high_m.reshape(shape))
            for one in clearances(self._separation_m, errors_m[:, 0], errors_m[:, 1])
        )

    def _of_rows(self, between_kinds: Clearance, own_row: int) -> Clearance:
        """Return the clearances of a vehicle from all rows, shape (n,)."""
        pairs = (self._kinds[own_row], self._kinds)
        return Clearance(between_kinds.wide_m[pairs], between_kinds.high_m[pairs])

    def _near(self, start: FloatArray, end: FloatArray, low: Clearance, narrow: Clearance) -> NDArray[np.bool_]:
        """Return which rows a segment may come too near to; all others are outside of the boxes of the ellipsoids."""
        lowest, highest = np.minimum(self._starts, self._ends), np.maximum(self._starts, self._ends)
        gaps_m = np.maximum(lowest - np.maximum(start, end), np.minimum(start, end) - highest)
        return np.asarray((gaps_m[:, :2].max(axis=1) < narrow.wide_m) & (gaps_m[:, 2] < low.high_m))

    def far(self, ids: Sequence[int], starts: FloatArray, ends: FloatArray) -> NDArray[np.bool_]:
        """Return which segments of vehicles come near to no other vehicle, whatever part of all of them is admitted.

        Args:
            ids: vehicles that are to be sent, each once.
            starts: their positions, shape (n, 3).
            ends: where they are to be sent, shape (n, 3).
        """
        own_rows = np.searchsorted(self._ids, ids)
        lowest, highest = np.minimum(self._starts, self._ends), np.maximum(self._starts, self._ends)
        # The part that is admitted takes the place of the first of a vehicle's segments.
        lowest[own_rows] = np.minimum(lowest[own_rows], ends)
        highest[own_rows] = np.maximum(highest[own_rows], ends)
        # One coordinate at a time: maxima along a very short axis take ten times as long.
        east_m, north_m, up_m = (
            np.maximum(low - own_high[:, None], own_low[:, None] - high)
            for low, high, own_low, own_high in zip(
                lowest.T, highest.T, np.minimum(starts, ends).T, np.maximum(starts, ends).T, strict=True
            )
        )
        kinds = (self._kinds[own_rows][:, None], self._kinds)
        near = (np.maximum(east_m, north_m) < self._narrow.wide_m[kinds]) & (up_m < self._low.high_m[kinds])
        near[self._ids == np.array(ids)[:, None]] = False
        return np.asarray(~near.any(axis=1))

    def admit(self, vehicle_id: int, end: FloatArray) -> None:
        """Occupy the segment to ``end``, shape (3,), for a vehicle that is sent there, in place of the one before."""
        first = np.searchsorted(self._ids, vehicle_id)
        self._ends[first], self._ends[first + 2] = end, self._starts[first + 2]

    def admissible(self, vehicle_id: int, start: FloatArray, end: FloatArray) -> Admission:
        """Return how much of a vehicle's segment, ends of shape (3,), keeps the distance to all others."""
        own_row = int(np.flatnonzero(self._ids == vehicle_id)[0])
        length_m = float(np.linalg.norm(end - start))
        low, narrow = self._of_rows(self._low, own_row), self._of_rows(self._narrow, own_row)
        near = self._near(start, end, low, narrow)
        near[self._ids == vehicle_id] = False
        rows = np.flatnonzero(near)
        if len(rows) == 0 or length_m == 0.0:
            return ALL_ADMITTED
        # A path that is outside of either ellipsoid keeps the separation. From inside of both it recedes from both.
        low_fractions, is_in_low = self._fractions(rows, low, start, end)
        met = is_in_low | (low_fractions < 1.0)
        if not met.any():
            return ALL_ADMITTED
        rows, low_fractions, is_in_low = rows[met], low_fractions[met], is_in_low[met]
        narrow_fractions, is_in_narrow = self._fractions(rows, narrow, start, end)
        fractions = np.select(
            [is_in_low & is_in_narrow, is_in_low, is_in_narrow],
            [np.minimum(low_fractions, narrow_fractions), narrow_fractions, low_fractions],
            np.maximum(low_fractions, narrow_fractions),
        )
        worst = int(fractions.argmin())
        if fractions[worst] == 1.0:
            return ALL_ADMITTED
        row = rows[worst]
        passing_m = float(segment_distance(start, end, self._starts[row], self._ends[row]))
        beside_m, above_m = float(narrow.wide_m[row]), float(low.high_m[row])
        limit = f"limit {beside_m:.1f} m"
        if abs(beside_m - above_m) >= _WORTH_TELLING_M:
            limit += f" beside, {above_m:.1f} m above or below"
        return Admission(
            float(fractions[worst]), f"it would pass vehicle {int(self._ids[row])} at {passing_m:.1f} m, {limit}"
        )

    def _fractions(
        self, rows: NDArray[np.intp], clearance: Clearance, start: FloatArray, end: FloatArray
    ) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Return how much of a segment stays outside of the ellipsoids about these rows, and which it starts inside."""
        # With heights scaled, the ellipsoids are spheres.
        scale, wide_m = clearance.scale()[rows], clearance.wide_m[rows]
        starts, ends = scale * self._starts[rows], scale * self._ends[rows]
        own_starts, own_ends = scale * start, scale * end
        now_m = point_segment_distance(own_starts, starts, ends)[0]
        fractions = admissible_fraction(own_starts, own_ends, starts, ends, np.minimum(wide_m, now_m))
        too_close = now_m < wide_m - 2.0 * TOLERANCE_M
        if not too_close.any():
            return fractions, too_close
        # The distance is convex along the segment, so where it grows at first it grows to the end.
        share = min(1.0, MIN_MOVE_M / float(np.linalg.norm(end - start)))
        after_first_move = own_starts + share * (own_ends - own_starts)
        receding = point_segment_distance(after_first_move, starts, ends)[0] > now_m + TOLERANCE_M
        fractions[too_close & ~receding] = 0.0
        return fractions, too_close
