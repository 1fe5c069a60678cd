"""Attitude of a camera whose telemetry does not tell it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Attitude:
    """Attitude of a camera whose gimbal's angles are not recorded, degrees; -90 is down."""

    yaw_deg: float | None
    """None: along the course."""
    pitch_deg: float
    roll_deg: float = 0.0
