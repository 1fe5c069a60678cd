"""Report of a simulated flight as a file, for checks of a service."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aos_sim.world.relief import Relief, ground_below


@dataclass(frozen=True, slots=True)
class SwarmReport:
    """Figures of the flight so far."""

    sim_time_s: float
    min_separation_m: float | None
    """Smallest true distance of any two vehicles so far; None with a single vehicle."""
    min_separation_pair: tuple[int, int] | None
    """System ids of these two vehicles."""
    landed: int
    """Vehicles on the ground and disarmed."""
    images: int
    """Images delivered by all cameras."""
    min_height_above_ground_m: float | None = None
    """Smallest true height of a vehicle above a relief so far, farther than 15 m from where it stood at first."""


@lru_cache(maxsize=16)
def _pairs(n: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    first, second = np.triu_indices(n, 1)
    return first, second


class SeparationMonitor:
    """Remembers how near two vehicles have come."""

    def __init__(self) -> None:
        self.smallest_m: float | None = None
        self.pair: tuple[int, int] | None = None

    def update(self, system_ids: Sequence[int], position_m: NDArray[np.float64]) -> None:
        """Take in the positions, shape (N, 3), of one instant, in any Cartesian frame."""
        if len(system_ids) < 2:
            return
        first, second = _pairs(len(system_ids))
        offsets_m = position_m[first] - position_m[second]
        distances_m = np.sqrt(np.einsum("ij,ij->i", offsets_m, offsets_m))
        nearest = int(np.argmin(distances_m))
        if self.smallest_m is None or distances_m[nearest] < self.smallest_m:
            self.smallest_m = float(distances_m[nearest])
            self.pair = (system_ids[first[nearest]], system_ids[second[nearest]])


_LAUNCH_COLUMN_M = 15.0
"""Distance from their launch points within which vehicles climb and land."""


class ClearanceMonitor:
    """Remembers how near vehicles have come to the ground on their ways.

    Args:
        homes_enu_m: launch points, shape (n, 3).
        relief: shape of the ground; None: it is level, and nothing is watched.
    """

    def __init__(self, homes_enu_m: NDArray[np.float64], relief: Relief | None) -> None:
        self.smallest_m: float | None = None
        self._homes_enu_m = homes_enu_m
        self._relief = relief

    def update(self, position_enu_m: NDArray[np.float64]) -> None:
        """Take in the true positions of one instant, shape (n, 3)."""
        if self._relief is None:
            return
        east_m, north_m = (position_enu_m - self._homes_enu_m)[:, :2].T
        away = np.hypot(east_m, north_m) > _LAUNCH_COLUMN_M
        if not away.any():
            return
        places_enu_m = position_enu_m[away]
        lowest_m = float((places_enu_m[:, 2] - ground_below(places_enu_m, self._relief)).min())
        self.smallest_m = lowest_m if self.smallest_m is None else min(lowest_m, self.smallest_m)


@dataclass(frozen=True, slots=True)
class AttachedCameraReport:
    """Figures of the camera of one vehicle so far."""

    system_id: int
    images: int
    refused: int
    """Exposures without an image, because the vehicle's pose or the world's place was not known."""
    tells_true_pose: bool
    """Whether the vehicle tells where it is, not only where it believes to be."""
    max_position_error_m: float | None
    """Largest distance between the two at an exposure."""


@dataclass(frozen=True, slots=True)
class AttachedCamerasReport:
    """Figures of all attached cameras so far."""

    min_separation_m: float | None
    """Smallest true distance of any two vehicles so far, from poses that are told some ten times per second."""
    min_separation_pair: tuple[int, int] | None
    """System ids of these two vehicles."""
    images: int
    """Images delivered by all cameras."""
    cameras: tuple[AttachedCameraReport, ...]
    min_height_above_ground_m: float | None = None
    """Smallest true height of a vehicle above a relief so far, farther than 15 m from where it stood at first."""


def write_report(path: Path, report: SwarmReport | AttachedCamerasReport) -> None:
    """Write the report file anew, atomically."""
    write_json(path, asdict(report))


def write_json(path: Path, content: object) -> None:
    """Write a file anew, atomically."""
    partial = path.with_name(path.name + ".part")
    partial.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    partial.replace(path)
