"""The airspace that a mission may use, checked against true positions: geofence, no-go zones, floor and ceiling."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.polygon import Boundary
from aos_sim.vehicle.flight import Manoeuvre

TRACKING_M = 0.5
"""Distance by which a vehicle may miss the path that it was sent on, in gusts and while it brakes."""
BY_THE_STATION = frozenset({Manoeuvre.POSITION, Manoeuvre.FOLLOW})
"""Manoeuvres by which a vehicle flies where the station has sent it; others go straight up or down, or are the return
of the autopilot, which knows no zones of the station."""
RECOVERY_M = 0.2
"""Distance by which a vehicle flies back from one look to the next, once its position estimate is right again."""
EVERY = 2
"""Steps of the simulation from one look to the next: 0.2 s, in which a vehicle flies 2 m at most."""
GROUND_M = 0.5
RISEN_M = 2.0
"""Height above the floor from which a vehicle must not sink below it: one that is held while it lands sinks on."""

Point = Sequence[float]


class AirspaceWatch:
    """Reports vehicles that leave the airspace while the station flies them.

    The margins of geofence and zones are to be kept, too. True positions may differ from what the limits ask for by
    :data:`TRACKING_M` and the vehicle's own error at that time (of its height, its change since the ground).

    Args:
        report: takes the kind of a violation and what happened.
    """

    def __init__(self, report: Callable[[str, str], None]) -> None:
        self._report = report
        self._limits: SafetyLimits | None = None
        self._boundaries: tuple[Boundary, ...] = ()
        self._outside: set[tuple[int, str]] = set()
        """Vehicles beyond a limit, with its name: only who crosses one is reported."""
        self._risen: set[int] = set()
        """Vehicles that the station flies above the floor; they may be below it on their way up and down."""
        self._beside_m: dict[int, float] = {}
        """Horizontal error of each vehicle's position, now or so lately that it has not flown back yet."""
        self._offset_m: dict[int, float] = {}
        """Error of each vehicle's height on the ground, which the station takes out."""

    def set_limits(self, limits: SafetyLimits | None) -> None:
        """Take the limits of the flight; those of before stay while a station knows none."""
        if limits is not None and limits is not self._limits:
            self._limits, self._boundaries = limits, limits.boundaries()

    def look(
        self, vehicle_id: int, true_enu_m: Point, believed_enu_m: Point, manoeuvre: Manoeuvre, *, is_ours: bool
    ) -> None:
        """Look at a vehicle.

        Args:
            vehicle_id: its id.
            true_enu_m: where it is.
            believed_enu_m: where its autopilot believes that it is.
            manoeuvre: what its autopilot does.
            is_ours: whether the station flies it: its motors run, and neither a pilot nor a fault has taken it away.
        """
        error_m = np.subtract(believed_enu_m, true_enu_m)
        lately_m = self._beside_m.get(vehicle_id, 0.0) - RECOVERY_M
        self._beside_m[vehicle_id] = max(float(np.hypot(*error_m[:2])), lately_m)
        if true_enu_m[2] < GROUND_M:
            self._offset_m[vehicle_id] = float(error_m[2])
            self._risen.discard(vehicle_id)
            return
        if self._limits is None:
            return
        sent = is_ours and manoeuvre in BY_THE_STATION
        beside_m = self._beside_m[vehicle_id] + TRACKING_M
        for boundary in self._boundaries:
            left_m = boundary.depth_m(np.array(true_enu_m[:2])) - boundary.margin_m
            kind = "beyond the geofence's margin" if boundary.keeps_in else "within a no-go zone's margin"
            self._note(vehicle_id, boundary.name, left_m + beside_m, kind, is_reported=sent)
        above_m = abs(float(error_m[2]) - self._offset_m.get(vehicle_id, 0.0)) + TRACKING_M
        over_m = self._limits.ceiling_m + above_m - true_enu_m[2]
        self._note(vehicle_id, "the ceiling", over_m, "above the ceiling", is_reported=is_ours)
        if not sent:
            self._risen.discard(vehicle_id)
        elif true_enu_m[2] > self._limits.floor_m + RISEN_M:
            self._risen.add(vehicle_id)
        if vehicle_id in self._risen:
            under_m = true_enu_m[2] + above_m - self._limits.floor_m
            self._note(vehicle_id, "the floor", under_m, "below the floor", is_reported=sent)

    def _note(self, vehicle_id: int, name: str, left_m: float, kind: str, *, is_reported: bool) -> None:
        """Note how far a vehicle is from the wrong side of a limit; negative: it is there."""
        key = vehicle_id, name
        if left_m >= 0.0:
            self._outside.discard(key)
        elif key not in self._outside:
            self._outside.add(key)
            if is_reported:
                self._report(kind, f"vehicle {vehicle_id} is {-left_m:.2f} m beyond what {name} allows")
