"""A world of the laboratory without a simulator: square targets, and a forest that hides what it is told to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.lab.worlds import Target, TargetViews

CELL_M = 0.1
CELLS = 40
TARGET_CELLS = 10


@dataclass(frozen=True)
class FakeWorld:
    """The target is a square of 1 m on the ground; a view within ``reach_m`` shows the share that ``seen`` says."""

    seen: Callable[[NDArray[np.float64]], float] = lambda offset_m: 0.5  # noqa: ARG005
    """Share of the target's columns, from the west, by the camera's horizontal offset from it."""
    reach_m: float = 16.0
    trunks_enu_m: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 2)))
    side_m: float = 100.0

    @property
    def area_enu_m(self) -> NDArray[np.float64]:
        half = self.side_m / 2
        return np.array([[-half, -half], [half, -half], [half, half], [-half, half]])

    def view_target(self, poses: Sequence[Pose], camera: CameraModel, target: Target) -> TargetViews:  # noqa: ARG002
        unoccluded = np.zeros((len(poses), CELLS, CELLS), dtype=np.bool_)
        seen = np.zeros_like(unoccluded)
        first = (CELLS - TARGET_CELLS) // 2
        square = slice(first, first + TARGET_CELLS)
        for view, pose in enumerate(poses):
            offset_m = pose.position_enu_m[:2] - target.position_enu_m
            if np.linalg.norm(offset_m) <= self.reach_m:
                unoccluded[view, square, square] = True
                columns = round(self.seen(offset_m) * TARGET_CELLS)
                seen[view, square, first : first + columns] = True
        half_m = CELLS / 2 * CELL_M
        east_m, north_m = (CELL_M * round(value / CELL_M) for value in target.position_enu_m)
        return TargetViews(seen, unoccluded, east_m - half_m, north_m + half_m, CELL_M)

    def render(
        self, poses: Sequence[Pose], camera: CameraModel, target: Target | None, rng: np.random.Generator
    ) -> list[NDArray[np.float32]]:
        raise NotImplementedError("this world has no light")
