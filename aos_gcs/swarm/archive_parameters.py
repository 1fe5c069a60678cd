"""Parameters of the archive strategy."""

from __future__ import annotations

from dataclasses import dataclass

from aos_gcs.errors import ConfigurationError
from aos_gcs.swarm.archive_looks import Canopy
from aos_gcs.swarm.parameters import AosPsoParameters


@dataclass(frozen=True, slots=True, kw_only=True)
class ArchiveParameters(AosPsoParameters):
    """What AOS-PSO has, which scans until the target is in view and steps in without masks, and the archive's own.

    Raises:
        ConfigurationError: one of them violates its constraint; the text names it.
    """

    projection_line: bool = True
    aperture_radius_m: float = 15.0
    """Radius of the circle about the target that is looked from, at the mean height of the swarm, metres."""
    spot_pitch_m: float = 1.0
    """Between neighbouring spots that nobody has looked from, metres."""
    view_spacing_m: float = 3.1
    """Between drones that look along the lines chosen, at the mean height of the swarm, metres."""
    min_distance_m: float = 2.6
    """Horizontal distance that waypoints keep from each other, metres. Smaller than the spacing of views, as low drones
    see along the same lines from nearer to each other, and so that drones find ways between those that hold."""
    max_step_m: float = 1.0
    """Longest way of a step once the target was seen, metres, beside the target's own. Short ones take more frames per
    metre; where a step costs time of its own, 8 m are better."""
    optimism: float = 0.3
    """Share of the target that a line is hoped to show of which nothing is known, from 0 to 1. More than such lines
    show in the mean lets the swarm look for better ones."""
    area_exponent: float = 0.15
    """Views are chosen for normalised visibility times area to this power: 0 for visibility alone."""
    hysteresis: float = 0.01
    """Share by which another view must be better for a drone to leave the one it holds."""
    kernel_m: float = 0.5
    """Distance of two lines of sight in the canopy at which one tells little about the other, metres."""
    canopy_height_m: float = 10.0
    """Of the middle of the leaves above the focal plane, metres."""
    canopy_half_depth_m: float = 3.0
    """From there to the edges of the leaves, metres."""
    body_height_m: float = 1.75
    """Of the upright body that the target is taken for before much of it was seen, metres."""
    body_radius_m: float = 0.15
    """Half of its width, metres."""

    def __post_init__(self) -> None:
        AosPsoParameters.__post_init__(self)
        for name in _ABOVE_ZERO:
            value = getattr(self, name)
            if value <= 0.0:
                raise ConfigurationError(f"{name} must be above 0, but is {value:g}.")
        for name in ("area_exponent", "hysteresis"):
            value = getattr(self, name)
            if value < 0.0:
                raise ConfigurationError(f"{name} must be at least 0, but is {value:g}.")
        if not 0.0 <= self.optimism <= 1.0:
            raise ConfigurationError(f"optimism must lie between 0 and 1, but is {self.optimism:g}.")
        if self.min_distance_m > self.view_spacing_m:
            raise ConfigurationError(
                f"min_distance_m must be at most view_spacing_m, {self.view_spacing_m:g}, "
                f"but is {self.min_distance_m:g}."
            )
        if self.body_height_m >= self.canopy_height_m:
            raise ConfigurationError(
                f"body_height_m must be below canopy_height_m, {self.canopy_height_m:g}, but is {self.body_height_m:g}."
            )

    @property
    def canopy(self) -> Canopy:
        """Where the leaves are."""
        return Canopy(self.canopy_height_m, self.canopy_half_depth_m)


_ABOVE_ZERO = (
    "aperture_radius_m",
    "spot_pitch_m",
    "view_spacing_m",
    "min_distance_m",
    "max_step_m",
    "kernel_m",
    "canopy_height_m",
    "canopy_half_depth_m",
    "body_height_m",
    "body_radius_m",
)
