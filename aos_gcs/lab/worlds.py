"""Port of the laboratory to simulated worlds, found through the entry points ``aos_gcs.worlds``.

A world is a forest that never changes. The target stands apart from it, so that one forest serves every strategy and
every moment of a walk. Frame: ENU metres, the ground is the plane z = 0 and also the focal plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.groundmap.detection import Posture
from aos_gcs.lab.simulator import simulator_part

GROUP = "aos_gcs.worlds"
MAX_TREES_PER_HA = 2000.0
"""Greatest density of a forest that the simulator builds."""


class ForestType(StrEnum):
    """Species of the trees."""

    BROADLEAF = "broadleaf"
    CONIFER = "conifer"


class TerrainShape(StrEnum):
    """The shape of the ground."""

    FLAT = "flat"


class ErrorGrade(StrEnum):
    """Grade of the errors of vehicles, cameras and wind; docs/simulator.md says what they are."""

    NONE = "none"
    RTK = "rtk"
    GNSS = "gnss"


@dataclass(frozen=True, slots=True)
class WorldParameters:
    """Parameters of a forest; a world refuses what it cannot build."""

    seed: int
    trees_per_ha: float = 300.0
    forest: ForestType = ForestType.BROADLEAF
    terrain: TerrainShape = TerrainShape.FLAT
    side_m: float = 100.0
    """Side of the forest square."""
    errors: ErrorGrade = ErrorGrade.RTK
    """Errors in rendered images; what a camera sees of the target by rays has none."""


@dataclass(frozen=True, slots=True)
class Target:
    """The person to find, at one moment."""

    position_enu_m: tuple[float, float]
    """East and north of the point on the ground below the body's middle."""
    heading_rad: float = 0.0
    """Direction of the chest (lying: of the feet), clockwise from north."""
    posture: Posture = Posture.STANDING


@dataclass(frozen=True, slots=True, eq=False)
class TargetViews:
    """Visible parts of the target per camera, projected onto the ground: a north-up raster around the target.

    A cell belongs to the target when the ray from the camera to the centre of the cell meets the target's surface.
    Edges lie at multiples of the resolution, so that the rasters of a target that stays are the same.
    """

    seen: NDArray[np.bool_]
    """Shape (n, rows, columns)."""
    unoccluded: NDArray[np.bool_]
    """Parts that the same cameras would see without the forest, shape (n, rows, columns)."""
    west_m: float
    """East coordinate of the outer edge of column 0."""
    north_m: float
    """North coordinate of the outer edge of row 0."""
    resolution_m: float
    """Edge of a cell."""


class World(Protocol):
    """A simulated forest. Equal arguments give equal results; nothing it does changes it."""

    @property
    def area_enu_m(self) -> NDArray[np.float64]:
        """The forest's square, corners counter-clockwise from the south-west, shape (4, 2)."""
        ...

    @property
    def trunks_enu_m(self) -> NDArray[np.float64]:
        """Positions of the trees, shape (trees, 2)."""
        ...

    def view_target(self, poses: Sequence[Pose], camera: CameraModel, target: Target) -> TargetViews:
        """Return what cameras at these poses see of the target; one at least, all above it. Distortion is left out."""
        ...

    def render(
        self, poses: Sequence[Pose], camera: CameraModel, target: Target | None, rng: np.random.Generator
    ) -> list[NDArray[np.float32]]:
        """Return one image per pose: red, green, blue (0 to 255) and thermal (degrees Celsius), shape (H, W, 4).

        Args:
            poses: what the vehicles believe of their cameras' poses, straight down; they err by the world's grade.
            camera: their common model.
            target: None for a forest without a person.
            rng: draws what differs from one exposure to the next.
        """
        ...


class WorldBuilder(Protocol):
    """An entry point of the group: it builds a world."""

    def __call__(self, parameters: WorldParameters) -> World:
        """Return the world of these parameters.

        Raises:
            ConfigurationError: a value is out of its range, or asks for what this simulator does not have.
        """
        ...


def build_world(parameters: WorldParameters) -> World:
    """Return the world that the installed simulator builds; takes a second or two.

    Raises:
        ConfigurationError: no simulator is installed, or it refuses the parameters.
    """
    build: WorldBuilder = simulator_part(GROUP, "grow a forest")
    return build(parameters)
