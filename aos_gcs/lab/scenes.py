"""Port of the study of effectiveness to a simulator, found through the entry points ``aos_gcs.scenes``.

A scene is a forest with or without a person, with things that may be taken for one, and a swarm whose cameras and
navigation err as real ones do. Frame: ENU metres, the ground is the plane z = 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.lab.simulator import simulator_part

GROUP = "aos_gcs.scenes"


class PositionGrade(StrEnum):
    """Grade of the vehicles' position errors."""

    GNSS = "gnss"
    """0.5 m horizontally."""
    RTK = "rtk"
    """0.02 m."""


@dataclass(frozen=True, slots=True)
class SceneSettings:
    """Parameters of a scene."""

    seed: int
    trees_per_ha: float
    has_person: bool
    vehicles: int


@dataclass(frozen=True, slots=True)
class SceneBody:
    """Something that attracts the search."""

    kind: str
    """``person standing``, ``deer``, ``stone`` …"""
    position_enu_m: tuple[float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Exposure:
    """One frame, with the pose that the vehicle would report for it with either grade of positions."""

    image: NDArray[np.float32]
    """Red, green, blue (0 to 255) and thermal (degrees Celsius), shape (H, W, 4)."""
    reported: Mapping[PositionGrade, Pose]


class SearchScene(Protocol):
    """A scene. Equal settings give equal scenes; nothing it does changes it."""

    @property
    def bodies(self) -> Sequence[SceneBody]:
        """The person first, if there is one."""
        ...

    def visible_areas_m2(self, positions_enu_m: NDArray[np.float64], camera: CameraModel) -> NDArray[np.float64]:
        """Return the area of each body that nadir cameras see, shape (n, bodies), on the ground.

        ``positions_enu_m`` as in :meth:`expose`.
        """
        ...

    def expose(
        self, positions_enu_m: NDArray[np.float64], camera: CameraModel, rng: np.random.Generator
    ) -> list[Exposure]:
        """Return one frame per vehicle of hovering nadir cameras.

        Args:
            positions_enu_m: waypoints of the vehicles, shape (n, 3), in the order of the vehicles. They hover
                beside it by the lasting error of their GNSS positions.
            camera: their common model.
            rng: draws what differs from one exposure to the next.
        """
        ...


class SceneBuilder(Protocol):
    """An entry point of the group: it builds a scene."""

    def __call__(self, settings: SceneSettings) -> SearchScene:
        """Return the scene of these settings.

        Raises:
            ConfigurationError: a value is out of its range.
        """
        ...


def build_scene(settings: SceneSettings) -> SearchScene:
    """Return the scene that the installed simulator builds; takes a second.

    Raises:
        ConfigurationError: no simulator is installed, or it refuses the settings.
    """
    build: SceneBuilder = simulator_part(GROUP, "grow a forest")
    return build(settings)
