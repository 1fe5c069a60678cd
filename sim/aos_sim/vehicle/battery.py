"""A battery that drains with what the vehicle does."""

from __future__ import annotations

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

    def drain(self, armed: bool, airborne: bool, duration_s: float) -> None:
        """Take what ``duration_s`` in this condition costs; an empty battery stays empty."""
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
