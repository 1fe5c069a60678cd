"""A battery that drains with what the vehicle does."""

from __future__ import annotations

import math
from dataclasses import dataclass

CELLS = 6
FULL_CELL_V = 4.2
EMPTY_CELL_V = 3.4

STANDBY_A = 0.3
IDLE_A = 1.5
"""Armed on the ground."""
HOVER_A = 20.0
INTERNAL_RESISTANCE_OHM = 0.02


@dataclass(slots=True)
class Battery:
    """Charge of one vehicle; the voltage falls linearly with it and sags under load."""

    capacity_mah: float = 10_000.0
    consumed_mah: float = 0.0
    current_a: float = STANDBY_A
    swap_s: float = math.inf
    """Time on the ground with stopped motors, after a flight, after which somebody has put in a full one."""
    number: int = 1
    """Number of the battery that is in the vehicle."""
    _has_flown: bool = False
    _rested_s: float = 0.0

    def drain(self, armed: bool, airborne: bool, duration_s: float) -> None:
        """Take what ``duration_s`` in this condition costs; an empty battery stays empty."""
        self._has_flown |= airborne
        self._rested_s = 0.0 if armed or airborne else self._rested_s + duration_s
        if self._has_flown and self._rested_s >= self.swap_s:
            self.consumed_mah, self._has_flown, self.number = 0.0, False, self.number + 1
        self.current_a = HOVER_A if airborne else IDLE_A if armed else STANDBY_A
        self.consumed_mah = min(self.capacity_mah, self.consumed_mah + self.current_a * duration_s / 3.6)

    @property
    def remaining(self) -> float:
        """Share of the charge that is left, [0, 1]."""
        return 1.0 - self.consumed_mah / self.capacity_mah

    @property
    def voltage_v(self) -> float:
        """Voltage at the terminals."""
        cell_v = EMPTY_CELL_V + (FULL_CELL_V - EMPTY_CELL_V) * self.remaining
        return CELLS * cell_v - INTERNAL_RESISTANCE_OHM * self.current_a


def capacity_mah(flight_s: float) -> float:
    """Return the capacity of a battery that lasts a time in flight."""
    return flight_s * HOVER_A / 3.6
