"""The true story of a simulation, in files for those who check what a service has found and how it has flown."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import combinations, islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import pdist

from aos_gcs.geometry.geodesy import GeodeticPosition


@dataclass(frozen=True, slots=True)
class Target:
    """A person to be found."""

    name: str
    position_enu_m: tuple[float, float, float]
    height_m: float


@dataclass(frozen=True, slots=True)
class World:
    """Where the simulation takes place."""

    area_enu_m: tuple[tuple[float, float], ...]
    """Corners of the search area."""
    targets: tuple[Target, ...] = ()
    trees_per_ha: float = 0.0


@dataclass(frozen=True, slots=True)
class SwarmReport:
    """How the flight went so far."""

    sim_time_s: float
    min_separation_m: float | None
    """Smallest true distance of any two vehicles so far; None with a single vehicle."""
    min_separation_pair: tuple[int, int] | None
    """Their system ids."""
    landed: int
    """Vehicles on the ground and disarmed."""
    images: int
    """Images delivered by all cameras."""


class SeparationMonitor:
    """Remembers how near two vehicles have come."""

    def __init__(self) -> None:
        self.smallest_m: float | None = None
        self.pair: tuple[int, int] | None = None

    def update(self, system_ids: Sequence[int], position_enu_m: NDArray[np.float64]) -> None:
        """Take in the positions, shape (N, 3), of one instant."""
        if len(system_ids) < 2:
            return
        distances_m = pdist(position_enu_m)
        nearest = int(np.argmin(distances_m))
        if self.smallest_m is None or distances_m[nearest] < self.smallest_m:
            self.smallest_m = float(distances_m[nearest])
            self.pair = next(islice(combinations(system_ids, 2), nearest, None))


def write_report(path: Path, report: SwarmReport) -> None:
    """Write the report file anew, atomically."""
    _write_json(path, asdict(report))


def write_world_file(
    path: Path,
    world: World,
    origin: GeodeticPosition,
    seed: int,
    homes_enu_m: dict[int, tuple[float, float, float]],
) -> None:
    """Write the world file, atomically. ``homes_enu_m`` is by system id."""
    _write_json(
        path,
        {
            "origin": asdict(origin),
            "seed": seed,
            "trees_per_ha": world.trees_per_ha,
            "area_enu_m": world.area_enu_m,
            "targets": [asdict(target) for target in world.targets],
            "vehicles": [{"system_id": system_id, "home_enu_m": home} for system_id, home in homes_enu_m.items()],
        },
    )


def _write_json(path: Path, content: object) -> None:
    partial = path.with_name(path.name + ".part")
    partial.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    partial.replace(path)
