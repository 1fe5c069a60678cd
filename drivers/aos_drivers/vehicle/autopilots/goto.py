"""Conditions for sending a goto, and the evidence in telemetry that the vehicle follows it."""

from __future__ import annotations

import math

import numpy as np

from aos_drivers.vehicle.telemetry import Telemetry
from aos_gcs.errors import CommandRefusedError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.ports import Goto, LandedState

TARGET_TOLERANCE_M = 2.0
"""Autopilots echo a target through their own integers and frames."""
MOVEMENT_M = 1.0
ECHO_SILENCE_S = 3.0
"""Time without an echo after which movement counts as evidence."""


def check_goto(command: Goto, vehicle_id: int, telemetry: Telemetry) -> None:
    """Check that a goto can be sent.

    Raises:
        CommandRefusedError: its position, speed or heading is invalid, or the vehicle is not flying.
    """
    position = command.position
    values = (position.latitude_deg, position.longitude_deg, position.altitude_amsl_m)
    if not all(math.isfinite(value) for value in values):
        problem = f"the position {values} is not finite"
    elif abs(position.latitude_deg) > 90 or abs(position.longitude_deg) > 180:
        problem = f"{values[:2]} is not a latitude and longitude in degrees"
    elif position.latitude_deg == 0 and position.longitude_deg == 0:
        problem = "latitude and longitude 0 mean an unknown position"
    elif not (math.isfinite(command.speed_mps) and command.speed_mps > 0):
        problem = f"a speed of {command.speed_mps} m/s is not positive"
    elif command.heading_rad is not None and not math.isfinite(command.heading_rad):
        problem = f"a heading of {command.heading_rad} rad is not finite"
    elif not telemetry.armed or telemetry.landed is LandedState.ON_GROUND:
        problem = "it is not flying, take off first"
    else:
        return
    raise CommandRefusedError(f"vehicle {vehicle_id} cannot go there: {problem}")


class GotoEvidence:
    """Evidence that the vehicle flies to ``position``, called repeatedly after ``started_s``.

    The autopilot's own target (POSITION_TARGET_GLOBAL_INT) proves it. Otherwise the vehicle has to be there or to come
    measurably closer, which counts only while no such target is reported, or where it may be a wrong one.
    """

    def __init__(
        self, position: GeodeticPosition, telemetry: Telemetry, started_s: float, *, is_echo_reliable: bool = True
    ) -> None:
        self._frame = LocalFrame(position)
        self._started_s = started_s
        self._is_echo_reliable = is_echo_reliable
        echo = telemetry.target
        self._echo_heard_s = echo.at_s if echo is not None and is_echo_reliable else -math.inf
        self._farthest_m = 0.0 if telemetry.position is None else self._distance_m(telemetry.position)
        shown = (telemetry.position, None if echo is None else echo.position)
        self.is_shown_before = any(one is not None and self._distance_m(one) <= TARGET_TOLERANCE_M for one in shown)
        """Whether telemetry would look the same without the command: it is to a place close by."""

    def __call__(self, telemetry: Telemetry, now_s: float) -> bool:
        """Return whether telemetry shows it."""
        echo = telemetry.target
        if echo is not None and echo.at_s > self._started_s:
            is_ours = self._distance_m(echo.position) <= TARGET_TOLERANCE_M
            if is_ours or self._is_echo_reliable:
                return is_ours
        if self._is_echo_reliable and now_s - max(self._started_s, self._echo_heard_s) < ECHO_SILENCE_S:
            return False
        return self._comes_closer(telemetry)

    def _comes_closer(self, telemetry: Telemetry) -> bool:
        position, position_at_s = telemetry.position, telemetry.position_at_s
        if position is None or position_at_s is None or position_at_s <= self._started_s:
            return False
        distance_m = self._distance_m(position)
        self._farthest_m = max(self._farthest_m, distance_m)  # it may have to turn round first
        return distance_m <= TARGET_TOLERANCE_M or distance_m <= self._farthest_m - MOVEMENT_M

    def _distance_m(self, position: GeodeticPosition) -> float:
        return float(np.linalg.norm(self._frame.to_enu(position)))
