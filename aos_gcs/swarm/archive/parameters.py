"""Parameters of AOS-APSO with views kept, and of the archive strategy."""

from __future__ import annotations

from dataclasses import dataclass

from aos_gcs.errors import ParameterError
from aos_gcs.swarm.archive.looks import Canopy
from aos_gcs.swarm.declaration import declared
from aos_gcs.swarm.parameters import AosApsoPaperParameters


@dataclass(frozen=True, slots=True, kw_only=True)
class AosApsoParameters(AosApsoPaperParameters):
    """Parameters of the paper's AOS-APSO, which scans and takes over without masks, and those of the views kept.

    Raises:
        ParameterError: one of them violates its constraint; the text names it.
    """

    timed_steps: bool = declared(
        True, "The time that steps take decides how long they are, between the shortest and the longest."
    )
    aperture_radius_m: float = declared(
        15.0, "Radius of the circle about the target that is looked from, at the mean height of the swarm.", above=0.0
    )
    spot_pitch_m: float = declared(1.0, "Between neighbouring spots that nobody has looked from.", above=0.0)
    view_spacing_m: float = declared(
        3.1, "Between drones that look along the lines chosen, at the mean height of the swarm.", above=0.0
    )
    # Smaller than the spacing of views, as low drones see along the same lines from nearer to each other, and so that
    # drones find ways between those that hold.
    min_distance_m: float = declared(2.6, "Horizontal distance that waypoints keep from each other.", above=0.0)
    max_step_m: float = declared(
        1.0,
        "Longest way of a step once the target was seen, beside the target's own, where steps take only the time of "
        "their way: short ones take more frames per metre.",
        above=0.0,
    )
    long_step_m: float = declared(
        8.0,
        "The same where steps cost time of their own, to brake, to expose and to compute; timed steps only.",
        above=0.0,
    )
    optimism: float = declared(
        0.3,
        "Share of the target that a line is hoped to show of which nothing is known. More than such lines show in the "
        "mean lets the swarm look for better ones.",
        at_least=0.0,
        at_most=1.0,
    )
    area_exponent: float = declared(
        0.15,
        "Views are chosen for normalised visibility times area to this power: 0 for visibility alone.",
        at_least=0.0,
    )
    hysteresis: float = declared(
        0.01, "Share by which another view must be better for a drone to leave the one it holds.", at_least=0.0
    )
    # The next three are what the study of the step's parts leaves out (docs/strategies.md).
    keeps_looks: bool = declared(True, "Views of earlier steps are remembered; otherwise those of the last step alone.")
    joint_choice: bool = declared(
        True, "Views are chosen for what they are expected to show together; otherwise for what each shows alone."
    )
    wander_m: float = declared(
        0.0, "Way in a random direction that drones make per step where they would rest.", at_least=0.0
    )
    kernel_m: float = declared(
        0.5, "Distance of two lines of sight in the canopy at which one tells little about the other.", above=0.0
    )
    canopy_height_m: float = declared(10.0, "Of the middle of the leaves above the focal plane.", above=0.0)
    canopy_half_depth_m: float = declared(3.0, "From there to the edges of the leaves.", above=0.0)
    body_height_m: float = declared(
        1.75, "Of the upright body that the target is taken for before much of it was seen.", above=0.0
    )
    body_radius_m: float = declared(0.15, "Half of its width.", above=0.0)

    def __post_init__(self) -> None:
        AosApsoPaperParameters.__post_init__(self)
        if self.max_step_m > self.long_step_m:
            raise ParameterError(
                f"max_step_m must be at most long_step_m, {self.long_step_m:g}, but is {self.max_step_m:g}.",
                "max_step_m",
            )
        if self.min_distance_m > self.view_spacing_m:
            raise ParameterError(
                f"min_distance_m must be at most view_spacing_m, {self.view_spacing_m:g}, "
                f"but is {self.min_distance_m:g}.",
                "min_distance_m",
            )
        if self.body_height_m >= self.canopy_height_m:
            raise ParameterError(
                f"body_height_m must be below canopy_height_m, {self.canopy_height_m:g}, "
                f"but is {self.body_height_m:g}.",
                "body_height_m",
            )

    @property
    def canopy(self) -> Canopy:
        """Return the layer of leaves."""
        return Canopy(self.canopy_height_m, self.canopy_half_depth_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class ArchiveParameters(AosApsoParameters):
    """Parameters of the archive strategy, whose steps have one length."""

    timed_steps: bool = False
