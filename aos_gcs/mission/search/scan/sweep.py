"""A sweep: the flight along a leg without stops, how far its waypoints lie ahead, and how its line stays together.

Waypoints lie on one front across the leg, as far ahead as all paths to it are free; it moves on long before any vehicle
brakes for it. Where none is far enough, no vehicle sweeps: the search stops for each frame, as it can around zones.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.stopping import StoppingDistance
from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.mission.journal import Announcer
from aos_gcs.mission.model.decisions import Situation
from aos_gcs.planning.legs import ScanLeg, leg_formation
from aos_gcs.planning.settings import FlightSettings
from aos_gcs.ports import Severity

FloatArray = NDArray[np.float64]

HORIZON_M = 100.0
"""Greatest distance of a waypoint: as far as vehicles fly on by themselves when the station falls silent."""
EXTENSION_M = 40.0
"""Distance by which the front moves on at once."""
SLOWED_FROM_M = 4.0
"""Lead over the last vehicle of the line from which a vehicle flies at half the speed."""
RELEASED_AT_M = 1.0
"""Lead at which it flies at full speed again."""
LEFT_BEHIND_M = 15.0
"""Distance behind the middle of the line from which a vehicle is named and no longer waited for."""
STUCK_S = 8.0
"""Time without ground gained after which a sweep is over."""
_HALVINGS = 4
"""Number of times that the way to a front is halved in search of one that all vehicles can reach."""
_LONGEST_GAP_STEPS = 4.0
"""Greatest distance between two places of exposures, over that at full speed and rate: a footprint is several times as
long, so that frames from both sides show the ground between."""
_ROUNDS = 4
"""Number of latest intervals between rounds of frames whose mean sets the speed."""
_FEWEST_TIMES = 3
_SLACK = 1.25
"""Interval between rounds, over that of the rate, up to which the speed stays."""
_CHANGE = 0.15
"""Share by which the speed must change to be commanded."""

Vet = Callable[[FloatArray], tuple[WaypointRecord, ...]]
"""Returns what becomes of the horizontal places, shape (n, 2), of the swarm's vehicles."""


class Sweep:
    """Waypoints of the line that flies along a leg.

    Args:
        flight: speeds and arrival.
        rate_hz: frames per second of each camera.
        spacing_m: distance of the vehicles in the line, c4.
        journal: told what slows the line down.
    """

    def __init__(self, flight: FlightSettings, rate_hz: float, spacing_m: float, journal: Announcer) -> None:
        self._full_mps = flight.leg_speed_mps
        self._beyond_m = flight.arrival_radius_m
        self._period_s = 1.0 / rate_hz
        self._least_m = StoppingDistance(self._full_mps).total_m
        self._spacing_m = spacing_m
        self._journal = journal
        self.end()

    @property
    def is_under_way(self) -> bool:
        """Whether the line flies along the leg."""
        return self._front_m is not None

    @property
    def longest_gap_m(self) -> float:
        """Greatest distance between two places of exposures that leaves no ground out."""
        return _LONGEST_GAP_STEPS * self._full_mps * self._period_s

    def end(self) -> None:
        """Note that the vehicles are sent elsewhere."""
        self._front_m: float | None = None
        """Distance of the waypoints from the start of the leg; None while there is no sweep."""
        self._pace_mps = self._full_mps
        self._slowed: frozenset[int] = frozenset()
        self._behind: frozenset[int] = frozenset()
        self._times_s: deque[float] = deque(maxlen=_ROUNDS + 1)
        self._furthest_m, self._gained_at_s = -math.inf, math.inf

    def exposed_at_m(self, leg: ScanLeg, situation: Situation, framed_ids: Sequence[int]) -> float:
        """Return where along the leg the line was when the frames of a round were exposed.

        Args:
            leg: the whole leg.
            situation: state of the flight, with the places of the exposures.
            framed_ids: vehicles whose frames were analysed.
        """
        places = {one.vehicle_id: np.array(one.position_enu_m) for one in situation.swarm}
        framed = {vehicle_id: places[vehicle_id] for vehicle_id in framed_ids if vehicle_id in places}
        along_m = _along_m(leg, framed or places)
        # Frames that come late say where their vehicle was, not that the line flies back.
        last_m = max(along_m.values()) - self.longest_gap_m
        return self._line_m({vehicle_id: place_m for vehicle_id, place_m in along_m.items() if place_m >= last_m})

    def fly_on(self, leg: ScanLeg, reached_m: float, situation: Situation, vet: Vet) -> tuple[WaypointRecord, ...]:
        """Return the vehicles' waypoints, with their speeds; none where the line cannot sweep on.

        Args:
            leg: the whole leg.
            reached_m: distance along it that has been looked at.
            situation: state of the flight.
            vet: checks places in this situation.
        """
        along_m = _along_m(leg, {one.vehicle_id: one.position_enu_m for one in situation.traffic.movable})
        if not along_m or self._is_stuck(reached_m, situation.now_s):
            return ()
        self._keep_together(along_m)
        self._keep_pace(situation.now_s)

        def reach(front_m: float) -> tuple[WaypointRecord, ...]:
            """Return the waypoints on a front; none where something bars one of them."""
            records = vet(leg_formation(leg.after(front_m), situation.positions_enu_m[:, :2], self._spacing_m))
            return () if any(record.is_barred for record in records) else records

        waypoints = self._move_front(self._line_m(along_m), leg.length_m + self._beyond_m, reach)
        return tuple(replace(one, speed_mps=self._speed_mps(one.vehicle_id)) for one in waypoints)

    def _move_front(
        self, line_m: float, end_m: float, reach: Callable[[float], tuple[WaypointRecord, ...]]
    ) -> tuple[WaypointRecord, ...]:
        """Move the front on, or back where it cannot be reached any more; return the waypoints on it, if any.

        Args:
            line_m: where the line is along the leg.
            end_m: farthest place of the front.
            reach: see :meth:`fly_on`.
        """
        limit_m, front_m = min(end_m, line_m + HORIZON_M), self._front_m
        waypoints = () if front_m is None else reach(front_m)
        if front_m is not None and waypoints:
            is_near = front_m - line_m < 2.0 * self._least_m
            if limit_m - front_m < EXTENSION_M and not (is_near and limit_m > front_m):
                return waypoints
            base_m, least_m = front_m, 0.0
        else:
            base_m, least_m = line_m, self._least_m
        for halving in range(_HALVINGS):
            ahead_m = base_m + (limit_m - base_m) / 2**halving
            # What nothing bars may be as short as it is; before an obstacle there is nothing to speed up for.
            if halving and ahead_m - base_m < least_m:
                break
            if further := reach(ahead_m):
                self._front_m = ahead_m
                return further
        return waypoints

    def _speed_mps(self, vehicle_id: int) -> float:
        return self._pace_mps / 2.0 if vehicle_id in self._slowed else self._pace_mps

    def _line_m(self, along_m: Mapping[int, float]) -> float:
        """Return where the line is along the leg, without those that it has left behind."""
        followed = [place_m for vehicle_id, place_m in along_m.items() if vehicle_id not in self._behind]
        return float(np.mean(followed or list(along_m.values())))

    def _is_stuck(self, reached_m: float, now_s: float) -> bool:
        """Return whether a sweep has gained no ground for long."""
        if not self.is_under_way or reached_m >= self._furthest_m + self._beyond_m:
            self._furthest_m, self._gained_at_s = reached_m, now_s
        return now_s - self._gained_at_s > STUCK_S

    def _keep_together(self, along_m: Mapping[int, float]) -> None:
        """Slow down vehicles ahead of the last one, and leave behind those that are far behind the others."""
        middle_m = float(np.median(list(along_m.values())))
        for vehicle_id, place_m in along_m.items():
            behind_m = middle_m - place_m
            if vehicle_id in self._behind and behind_m < SLOWED_FROM_M:
                self._behind -= {vehicle_id}
            elif vehicle_id not in self._behind and behind_m > LEFT_BEHIND_M:
                self._behind |= {vehicle_id}
                text = f"is {behind_m:.0f} m behind the line: the others no longer wait for it"
                self._journal.notice(Severity.WARNING, text, vehicle_id)
        last_m = min((along_m[one] for one in along_m if one not in self._behind), default=middle_m)
        leads_m = {vehicle_id: place_m - last_m for vehicle_id, place_m in along_m.items()}
        self._slowed = frozenset(
            vehicle_id
            for vehicle_id, lead_m in leads_m.items()
            if lead_m > (RELEASED_AT_M if vehicle_id in self._slowed else SLOWED_FROM_M)
        )

    def _keep_pace(self, now_s: float) -> None:
        """Fly as fast as frames come, so that their places stay as close together as at the rate that is set."""
        if self.is_under_way:
            self._times_s.append(now_s)
        if len(self._times_s) < _FEWEST_TIMES:
            return
        interval_s = (self._times_s[-1] - self._times_s[0]) / (len(self._times_s) - 1)
        pace_mps = self._full_mps * min(1.0, _SLACK * self._period_s / interval_s)
        if abs(pace_mps - self._pace_mps) <= _CHANGE * self._pace_mps and pace_mps < self._full_mps:
            return
        if pace_mps < self._pace_mps == self._full_mps:
            self._journal.notice(
                Severity.WARNING,
                f"Frames come every {interval_s:.1f} s instead of every {self._period_s:.1f} s: the line flies at "
                f"{pace_mps:.1f} m/s, so that no ground is left out",
            )
        self._pace_mps = pace_mps


def _along_m(leg: ScanLeg, places_enu_m: Mapping[int, FloatArray]) -> dict[int, float]:
    """Return how far along a leg places, at least two coordinates each, lie, by the same keys."""
    start_m, direction = np.array(leg.start_enu_m), np.array(leg.direction_enu)
    return {key: float((place_m[:2] - start_m) @ direction) for key, place_m in places_enu_m.items()}
