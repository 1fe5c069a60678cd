"""Stopping distance of a vehicle: how far it flies on after it should have turned back."""

from __future__ import annotations

from dataclasses import dataclass

DECELERATION_MPS2 = 2.5
"""Horizontal deceleration of a vehicle that is told to hold: ArduCopter's default; PX4's is 3."""
REACTION_S = 1.0
"""Time from the crossing of a limit until a vehicle brakes: a position is old, the command is repeated once."""
POSITION_ERROR_M = 2.5
"""Error of a horizontal position without RTK, 95 %."""


@dataclass(frozen=True, slots=True)
class StoppingDistance:
    """Distance in which a vehicle at a speed comes to a stop, reaction and error of its position included."""

    speed_mps: float

    @property
    def reaction_m(self) -> float:
        """Distance flown before the vehicle brakes."""
        return self.speed_mps * REACTION_S

    @property
    def braking_m(self) -> float:
        """Distance flown while it brakes."""
        return self.speed_mps * self.speed_mps / (2.0 * DECELERATION_MPS2)

    @property
    def total_m(self) -> float:
        """Whole distance."""
        return self.reaction_m + self.braking_m + POSITION_ERROR_M

    def __str__(self) -> str:
        return (
            f"{self.total_m:.1f} m, the stopping distance at {self.speed_mps:g} m/s: {self.reaction_m:.1f} m in "
            f"{REACTION_S:g} s of reaction, {self.braking_m:.1f} m of braking at {DECELERATION_MPS2:g} m/s², "
            f"{POSITION_ERROR_M:g} m of position error"
        )
