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
        True, "Adapt the length of steps, between the shortest and the longest, to the time that they take."
    )
    aperture_radius_m: float = declared(
        15.0, "Radius of the circle of viewpoints about the target, at the mean height of the swarm.", above=0.0
    )
    spot_pitch_m: float = declared(1.0, "Distance of neighbouring viewpoints that are not used yet.", above=0.0)
    view_spacing_m: float = declared(
        3.1, "Smallest distance of two chosen viewpoints, at the mean height of the swarm.", above=0.0
    )
    # Smaller than the spacing of views, as low drones see along the same lines from nearer to each other, and so that
    # drones find ways between those that hold.
    min_distance_m: float = declared(2.6, "Horizontal distance that waypoints keep from each other.", above=0.0)
    max_step_m: float = declared(
        1.0,
        "Longest path of a step once the target was seen, on top of the target's own motion, where steps take only the "
        "time of flight: short steps take more frames per metre.",
        above=0.0,
    )
    long_step_m: float = declared(
        8.0,
        "The same where steps also take time to brake, to expose and to compute; timed steps only.",
        above=0.0,
    )
    optimism: float = declared(
        0.3,
        "Share of the target that an unknown line of sight is expected to show. A value above the mean of such lines "
        "makes the swarm look for better ones.",
        at_least=0.0,
        at_most=1.0,
    )
    area_exponent: float = declared(
        0.15,
        "Exponent of the visible area, by which normalised visibility is weighted; 0: visibility alone.",
        at_least=0.0,
    )
    hysteresis: float = declared(
        0.01, "Share by which another view must be better before a drone leaves its present one.", at_least=0.0
    )
    # The next three are what the study of the step's parts leaves out (docs/strategies.md).
    keeps_looks: bool = declared(True, "Keep the views of earlier steps; otherwise only those of the last step.")
    joint_choice: bool = declared(
        True, "Choose views by what they are expected to show together; otherwise by what each shows alone."
    )
    wander_m: float = declared(0.0, "Distance that drones at rest move in a random direction per step.", at_least=0.0)
    kernel_m: float = declared(
        0.5,
        "Distance of two lines of sight in the canopy beyond which their visibility is hardly correlated.",
        above=0.0,
    )
    canopy_height_m: float = declared(10.0, "Height of the middle of the leaves above the focal plane.", above=0.0)
    canopy_half_depth_m: float = declared(3.0, "Half of the thickness of the layer of leaves.", above=0.0)
    body_height_m: float = declared(
        1.75, "Height of the upright body assumed for the target until enough of it was seen.", above=0.0
    )
    body_radius_m: float = declared(0.15, "Radius of that body.", above=0.0)

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
