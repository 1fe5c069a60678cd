"""Errors of gimbals: where a camera points differs from what is reported, straight down and along the heading."""

from __future__ import annotations

from dataclasses import dataclass

from aos_sim.errors.sizes import check_sizes


@dataclass(frozen=True, slots=True)
class GimbalErrors:
    """Sizes of the errors; angles are standard deviations, those of tilts per axis.

    Raises:
        ConfigurationError: a value is negative.
    """

    tilt_rad: float = 0.0
    """Constant tilt of the camera: how it is mounted, and the level that the gimbal holds."""
    pan_rad: float = 0.0
    """Constant angle between the camera and the vehicle's nose."""
    jitter_rad: float = 0.0
    """Part that differs from one exposure to the next, per axis."""
    lag_s: float = 0.0
    """Time by which the gimbal follows the vehicle late: it lets through the rate of turning times this."""

    def __post_init__(self) -> None:
        check_sizes(self, "gimbal")
