"""Positions that an autopilot goes on to send although it has no new ones."""

from __future__ import annotations

import math

from aos_gcs.geometry.geodesy import GeodeticPosition

_MOVING_MPS = 0.5
"""Speed at which a position, in units of a centimetre, changes from report to report."""
_LONGEST_S = 0.5
"""Time for which a moving vehicle may report the same position: estimators run slower than some streams."""
_COPIES_S = 1.0
"""Time for which the same report may come again: over another link, or on a link that delivers twice."""
_CLIMBED_HPA = 0.18
"""Change of pressure, about 1.5 m of height, that shows that a vehicle is not where it was."""
_WEATHER_S = 30.0
"""Time after which the pressure is compared with a newer one: it changes with the weather, too."""


class FrozenPosition:
    """Tells positions that are repeated to the bit, while velocity or pressure say otherwise, from a still hover.

    Place and altitude are judged apart: an estimator may lose the one and go on to measure the other.
    """

    __slots__ = (
        "_altitude_amsl_m",
        "_altitude_since_s",
        "_place_deg",
        "_place_since_s",
        "_pressure",
        "_report",
        "_report_since_s",
    )

    def __init__(self) -> None:
        self._place_deg: tuple[float, float] | None = None
        self._altitude_amsl_m: float | None = None
        self._place_since_s = self._altitude_since_s = 0.0
        self._pressure: tuple[float, float] | None = None
        """Pressure to compare with, and its time."""
        self._report: tuple[int, GeodeticPosition] | None = None
        self._report_since_s = 0.0

    def is_copy(self, position: GeodeticPosition, boot_ms: int, now_s: float) -> bool:
        """Return whether a report is an old one that is sent again and again, the time since boot included."""
        if (boot_ms, position) != self._report:
            self._report, self._report_since_s = (boot_ms, position), now_s
        return now_s - self._report_since_s > _COPIES_S

    def is_repeated(
        self,
        position: GeodeticPosition,
        now_s: float,
        velocity_enu_mps: tuple[float, float, float] | None,
        pressure_hpa: float | None,
    ) -> bool:
        """Return whether a reported position is only the former one, of a vehicle that has moved."""
        place_deg, altitude_m = (position.latitude_deg, position.longitude_deg), position.altitude_amsl_m
        is_new_place, is_new_altitude = place_deg != self._place_deg, altitude_m != self._altitude_amsl_m
        # An estimator that comes back may change the one first: both are judged anew.
        is_back = (is_new_place or is_new_altitude) and (
            now_s - max(self._place_since_s, self._altitude_since_s) > _LONGEST_S
        )
        if is_new_place or is_back:
            self._place_deg, self._place_since_s = place_deg, now_s
        if is_new_altitude or is_back:
            self._altitude_amsl_m, self._altitude_since_s, self._pressure = altitude_m, now_s, None
        if pressure_hpa is not None:
            former_hpa, former_at_s = self._pressure or (pressure_hpa, now_s)
            if abs(pressure_hpa - former_hpa) > _CLIMBED_HPA:
                return True
            if self._pressure is None or now_s - former_at_s > _WEATHER_S:
                self._pressure = pressure_hpa, now_s
        if velocity_enu_mps is None:
            return False
        east_mps, north_mps, up_mps = velocity_enu_mps
        place_s, altitude_s = now_s - self._place_since_s, now_s - self._altitude_since_s
        if place_s > _LONGEST_S and math.hypot(east_mps, north_mps) > _MOVING_MPS:
            return True
        if altitude_s > _LONGEST_S and abs(up_mps) > _MOVING_MPS:
            return True
        return min(place_s, altitude_s) > _LONGEST_S and math.hypot(east_mps, north_mps, up_mps) > _MOVING_MPS
