"""Configuration of a simulated vehicle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from aos_gcs.geometry.geodesy import LocalFrame
from aos_sim.world.relief import Relief


@dataclass(frozen=True, slots=True)
class VehicleIdentity:
    """Identity of a vehicle and origin of its world."""

    system_id: int
    frame: LocalFrame
    uid: int
    """The flight controller board's own number, not negative."""
    start_up_s: float | None = None
    """Time from power-on to a position estimate; None: the autopilot's usual time."""
    parameters: Mapping[str, float] = field(default_factory=dict)
    """Values that differ from the flavour's settings."""
    speed: float = 1.0
    """Simulated seconds per real second."""
    relief: Relief | None = None
    """Shape of the ground; None: the plane z = 0."""

    @property
    def board_id(self) -> str:
        """The board's number as ground stations write it: hexadecimal, the lowest byte first."""
        return self.uid.to_bytes(18, "little").rstrip(b"\0").hex()
