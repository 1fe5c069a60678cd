"""Progress of the scan: the legs, how far the present one has been flown, and what was left out."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum, auto
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.mission.search.scan.stalls import StallWatch
from aos_gcs.planning.legs import ScanLeg

_ON_LEGS = frozenset({Phase.LINE, Phase.SCAN})
_PACE_M = 10.0
"""Length of legs flown from which the pace counts as known."""


def time_on_legs_s(steps: Sequence[StepRecord]) -> float:
    """Return the time between steps that was spent on the legs: close looks do not tell how long the rest takes."""
    return sum(after.elapsed_s - before.elapsed_s for before, after in pairwise(steps) if after.phase in _ON_LEGS)


class Advance(Enum):
    """Result of a step of the scan."""

    ON_LEG = auto()
    END_OF_LEG = auto()
    STUCK = auto()
    """The scan gains no ground, because waypoints are shortened or held."""
    GAP = auto()
    """Ground ahead of the place reached was flown over without frames."""


class ScanProgress:
    """Legs of a scan and the place reached on them.

    Args:
        least_gain_m: smallest advance of a step that counts as progress.
    """

    def __init__(self, least_gain_m: float) -> None:
        self._least_gain_m = least_gain_m
        self._stalls = StallWatch(least_gain_m)
        self._along_m = 0.0
        self._first_leg = 0
        """Index of the leg that this mission has begun with."""
        self.legs: tuple[ScanLeg, ...] = ()
        """Empty before they are planned."""
        self._planned = 0
        self.leg = 0
        """Index of the leg being flown; beyond the last one when the scan is over."""
        self.barred: tuple[WaypointRecord, ...] = ()
        """Waypoints of the latest step that something on their paths kept from being sent as planned."""
        self.left_out_m = 0.0
        """Length of all stretches of the legs that were not flown."""

    @property
    def along_m(self) -> float:
        """Distance flown on the present leg, stretches left out included."""
        return self._along_m

    @property
    def present_leg(self) -> ScanLeg:
        """The whole leg being flown."""
        return self.legs[self.leg]

    @property
    def remaining_leg(self) -> ScanLeg:
        """The rest of the leg being flown."""
        return self.present_leg.after(self._along_m)

    def time_left_s(self, scanned_s: float) -> float | None:
        """Return how long the rest of the legs takes at the pace so far; None before the pace is known.

        Args:
            scanned_s: time spent on the legs, see :func:`time_on_legs_s`.
        """
        flown_m = sum(leg.length_m for leg in self.legs[self._first_leg : self.leg])
        left_m = sum(leg.length_m for leg in self.legs[self.leg :])
        if self.leg < len(self.legs):
            along_m = min(self._along_m, self.present_leg.length_m)
            flown_m, left_m = flown_m + along_m, left_m - along_m
        return None if flown_m < _PACE_M else scanned_s * left_m / flown_m

    def plan(self, legs: Sequence[ScanLeg]) -> None:
        """Set the legs of the scan."""
        self.legs, self._planned = tuple(legs), len(legs)

    @property
    def is_over(self) -> bool:
        """Whether all legs have been flown to their ends."""
        return bool(self.legs) and self.leg >= len(self.legs)

    @property
    def planned_legs(self) -> tuple[ScanLeg, ...]:
        """Legs without those that are flown again for gaps."""
        return self.legs[: self._planned]

    @property
    def here_enu_m(self) -> tuple[float, float]:
        """Horizontal place of the line's middle that has been reached on the legs."""
        return self.legs[-1].end_enu_m if self.is_over else self.remaining_leg.start_enu_m

    def leave_for(self, leg: ScanLeg) -> None:
        """Go on with another leg, behind all legs; what is left of these is not flown."""
        if not self.is_over:
            self.left_out_m += self.remaining_leg.length_m + sum(one.length_m for one in self.legs[self.leg + 1 :])
        self.leg, self._along_m = len(self.legs), 0.0
        self.extend((leg,))

    def extend(self, legs: Sequence[ScanLeg]) -> None:
        """Add stretches that are flown again, behind all legs."""
        self.legs += tuple(legs)

    def take_up(self, legs: Sequence[ScanLeg], leg: int) -> None:
        """Go on with a scan at the beginning of a leg; without legs they are still to be planned."""
        self.legs, self._planned = tuple(legs), len(legs)
        self.leg = self._first_leg = min(leg, max(0, len(self.legs) - 1))

    def form_line(self) -> None:
        """Note that the line has been formed anew: earlier steps without progress no longer count."""
        self._stalls.restart()

    def note_waypoints(self, waypoints: Sequence[WaypointRecord]) -> None:
        """Note what became of the waypoints of a step."""
        self.barred = tuple(waypoint for waypoint in waypoints if waypoint.is_barred)

    def advance(self, middle_m: NDArray[np.float64]) -> Advance:
        """Note where the middle of the swarm is after a step, horizontally, shape (2,)."""
        leg = self.present_leg
        along_m = float((middle_m - np.array(leg.start_enu_m)) @ np.array(leg.direction_enu))
        self._along_m = max(self._along_m, along_m)
        if self._along_m >= leg.length_m:
            return Advance.END_OF_LEG
        is_stuck = self._stalls.is_stuck(along_m, barred=bool(self.barred))
        return Advance.STUCK if is_stuck else Advance.ON_LEG

    def advance_in_flight(self, along_m: float, longest_gap_m: float) -> Advance:
        """Note where frames were exposed along the present leg by a swarm that flies on.

        Args:
            along_m: place along the leg.
            longest_gap_m: greatest distance between places of exposures that leaves no ground out.
        """
        if along_m - self._along_m > longest_gap_m:
            return Advance.GAP
        self._along_m = max(self._along_m, along_m)
        # They hover at its very end: what their positions err by must not keep them there.
        is_over = self._along_m >= self.present_leg.length_m - self._least_gain_m
        return Advance.END_OF_LEG if is_over else Advance.ON_LEG

    def go_back(self, along_m: float) -> None:
        """Note that the present leg is flown again from a place on."""
        self._along_m = min(self._along_m, along_m)

    def take_back(self, leg: int) -> None:
        """Return to the end of a leg, where the next one was begun too early; nothing changes on that leg itself."""
        if self.leg != leg:
            self.leg, self._along_m = leg, self.legs[leg].length_m

    def leave_out(self, length_m: float) -> None:
        """Leave out the next stretch of the present leg."""
        self.left_out_m += length_m
        self._along_m += length_m

    def begin_next_leg(self) -> bool:
        """Go to the next leg; return whether there is one."""
        self.leg, self._along_m = self.leg + 1, 0.0
        return self.leg < len(self.legs)
