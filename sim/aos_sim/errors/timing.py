"""Errors of exposure times: the shutter opens later than the pose is reported for, by an amount nobody knows."""

from __future__ import annotations

from dataclasses import dataclass

from aos_sim.errors.sizes import check_sizes


@dataclass(frozen=True, slots=True)
class TimingErrors:
    """Sizes of the errors.

    Raises:
        ConfigurationError: a value is negative.
    """

    delay_s: float = 0.0
    """Mean delay of the shutter."""
    clock_s: float = 0.0
    """Standard deviation from camera to camera of a constant offset between the clocks of camera and autopilot."""
    jitter_s: float = 0.0
    """Standard deviation from exposure to exposure."""

    def __post_init__(self) -> None:
        check_sizes(self, "timing")
