"""Monitors how high vehicles fly above the ground of the elevation model, which vetting keeps only our waypoints to."""

from __future__ import annotations

from typing import Final

import numpy as np

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.terrain import GroundRaster
from aos_gcs.geometry.heights import AboveGroundM
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.fleet.watches.debounce import Debounce
from aos_gcs.mission.journal import Journal
from aos_gcs.ports import Clock, FlightMode, Land, ReturnToLaunch, Severity

_LASTING_S: Final = 1.0
"""Time for which a vehicle is below its floor before that counts."""
_TOLERANCE_M: Final = 1.0
"""Depth below the floor that does not count: vehicles hover, and positions are known, to a few decimetres."""


class GroundWatch:
    """Measures heights above ground, and reports vehicles that come below the floor above ground, once each time."""

    def __init__(self, roster: Roster, clock: Clock, journal: Journal) -> None:
        self._roster = roster
        self._clock = clock
        self._journal = journal
        self._too_low = Debounce(_LASTING_S)
        self._cleared: set[int] = set()
        """Ids of vehicles that have climbed above the floor, and are not on their way down."""

    def look(self, limits: SafetyLimits | None, ground: GroundRaster | None) -> None:
        """Measure all heights, and raise alarms; without ground, or limits above it, none is known."""
        located = [(m, p) for m in self._roster.members() if (p := self._roster.position_enu_m(m)) is not None]
        for member in self._roster.members():
            member.height_above_ground_m = None
        if ground is None or not located:
            return
        positions_enu_m = np.array([position_enu_m for _, position_enu_m in located])
        heights_m = positions_enu_m[:, 2] - ground.bounds_at(positions_enu_m[:, :2])[1]
        for (member, _), height_m in zip(located, heights_m.tolist(), strict=True):
            if np.isfinite(height_m):
                member.height_above_ground_m = AboveGroundM(height_m)
                if limits is not None and limits.above_ground is not None:
                    self._judge(member, height_m, limits.above_ground.floor_m)

    def _judge(self, member: Member, height_m: float, floor_m: float) -> None:
        vehicle_id = member.vehicle_id
        if not member.airborne or _comes_down(member):
            self._cleared.discard(vehicle_id)
            self._too_low.forget(vehicle_id)
            return
        if height_m >= floor_m:
            self._cleared.add(vehicle_id)
        is_too_low = vehicle_id in self._cleared and height_m < floor_m - _TOLERANCE_M
        if not self._too_low.has_changed(vehicle_id, is_too_low, self._clock.now_s()):
            return
        if is_too_low:
            text = f"{height_m:.1f} m above the ground, below the floor of {floor_m:g} m. Return it, or take it over"
            self._journal.notice(Severity.CRITICAL, text, vehicle_id)
        else:
            self._journal.notice(Severity.INFO, "above the floor above ground again", vehicle_id)


def _comes_down(member: Member) -> bool:
    """Return whether a vehicle is flown by its pilot, or returns or lands by its autopilot."""
    is_sent_down = isinstance(member.last_command, Land | ReturnToLaunch)
    return member.has_pilot or is_sent_down or member.state.mode in {FlightMode.RETURN, FlightMode.LAND}
