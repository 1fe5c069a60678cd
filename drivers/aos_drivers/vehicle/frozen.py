"""Positions that an autopilot goes on to send although it has no new ones."""

from __future__ import annotations

import math

from aos_gcs.geometry.geodesy import GeodeticPosition

_MOVING_MPS = 0.5
"""Speed at which a position, in units of a centimetre, changes from report to report."""
_LONGEST_S = 0.5
"""Time for which a moving vehicle may report the same position: estimators run slower than some streams."""
_CLIMBED_HPA = 0.18
"""Change of pressure, about 1.5 m of height, that shows that a vehicle is not where it was."""
_WEATHER_S = 30.0
"""Time after which the pressure is compared with a newer one: it changes with the weather, too."""


class FrozenPosition:
    """Tells positions that are repeated to the bit, while velocity or pressure say otherwise, from a still hover."""

    def __init__(self) -> None:
        self._position: GeodeticPosition | None = None
        self._since_s = 0.0
        self._pressure: tuple[float, float] | None = None
        """Pressure to compare with, and its time."""

    def is_repeated(
        self,
        position: GeodeticPosition,
        now_s: float,
        velocity_enu_mps: tuple[float, float, float] | None,
        pressure_hpa: float | None,
    ) -> bool:
        """Return whether a reported position is only the former one, of a vehicle that has moved."""
        if position != self._position:
            self._position, self._since_s, self._pressure = position, now_s, None
        if pressure_hpa is not None:
            former_hpa, former_at_s = self._pressure or (pressure_hpa, now_s)
            if abs(pressure_hpa - former_hpa) > _CLIMBED_HPA:
                return True
            if self._pressure is None or now_s - former_at_s > _WEATHER_S:
                self._pressure = pressure_hpa, now_s
        is_moving = velocity_enu_mps is not None and math.hypot(*velocity_enu_mps) > _MOVING_MPS
        return is_moving and now_s - self._since_s > _LONGEST_S
