"""The custom modes of PX4."""

from __future__ import annotations

from enum import IntEnum


def custom_mode_of(main: int, sub: int = 0) -> int:
    """Return the custom mode of a main and a sub mode."""
    return main << 16 | sub << 24


class Px4Mode(IntEnum):
    """Custom modes of PX4 that the simulator knows: main mode in bits 16 to 23, sub mode above."""

    MANUAL = custom_mode_of(1)
    ALTITUDE = custom_mode_of(2)
    POSITION = custom_mode_of(3)
    TAKEOFF = custom_mode_of(4, 2)
    HOLD = custom_mode_of(4, 3)
    RETURN = custom_mode_of(4, 5)
    LAND = custom_mode_of(4, 6)
    MISSION = custom_mode_of(4, 4)
    OFFBOARD = custom_mode_of(6)


PILOT_MODES = (Px4Mode.MANUAL, Px4Mode.ALTITUDE, Px4Mode.POSITION)
MODES_NOT_ARMABLE = (Px4Mode.RETURN, Px4Mode.LAND)

OFFBOARD_LOSS_MODES = {
    0: Px4Mode.POSITION,
    1: Px4Mode.ALTITUDE,
    3: Px4Mode.RETURN,
    4: Px4Mode.LAND,
    5: Px4Mode.HOLD,
}
"""Modes by the value of COM_OBL_RC_ACT."""


def mode_name(custom_mode: int) -> str:
    """Return the name of a mode as PX4 writes it."""
    return Px4Mode(custom_mode).name.capitalize() if custom_mode in tuple(Px4Mode) else "Unknown"
