"""What distinguishes one vehicle from another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from aos_gcs.geometry.geodesy import LocalFrame


@dataclass(frozen=True, slots=True)
class VehicleIdentity:
    """Who a vehicle is and where its world lies."""

    system_id: int
    frame: LocalFrame
    uid: int
    """The flight controller board's own number."""
    start_up_s: float | None = None
    """From power-on to a position estimate; None: what the flavour usually needs."""
    parameters: Mapping[str, float] = field(default_factory=dict)
    """Values that differ from the flavour's settings."""
