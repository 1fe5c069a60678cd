"""The best positions that full knowledge of the forest would choose: the upper bound of every strategy.

A swarm of n vehicles, each in its own altitude layer, may stand on any of c places; what each would see from there is
known. One place per layer is chosen so that the normalised visibility is greatest: the union of what they see over the
union of what they would see without forest (spec, section 2). This is a maximum coverage with conflicts, which is
NP-hard: it is solved greedily, beginning with each layer in turn, and improved by exchanges until none helps. The tests
compare small cases with the exact solution of a mixed-integer program.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.lab.worlds import Target, World

BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

MAX_SWEEPS = 50
"""Limit of the exchanges over all layers; each one improves the result, so that a few suffice."""


PITCH_M = 1.0
"""Spacing of the lattice, well below the distance over which views stop being alike."""


@dataclass(frozen=True, slots=True, eq=False)
class Oracle:
    """Result of the best positions."""

    positions_enu_m: NDArray[np.float64]
    """Positions of the vehicles, shape (n, 2)."""
    visibility: float
    """Normalised: area seen over the area that the same views would cover without forest."""
    area_m2: float
    """Seen by all together, on the focal plane."""


def find_oracle(
    world: World,
    camera: CameraModel,
    target: Target,
    heights_m: Sequence[float],
    spacing_m: float,
    *,
    radius_m: float,
) -> Oracle:
    """Return the best positions about a target for nadir cameras, one per height above the ground.

    Args:
        world: world of the target.
        camera: camera of all vehicles.
        target: target to look at.
        heights_m: heights of the vehicles above the ground.
        spacing_m: least horizontal distance of two vehicles.
        radius_m: radius of the disc around the target for the vehicles.

    Raises:
        ValueError: there is no room for so many vehicles at that spacing.
    """
    places_enu_m = _disc(radius_m, PITCH_M) + target.position_enu_m
    views = [
        world.view_target([nadir_pose([*place, height_m]) for place in places_enu_m], camera, target)
        for height_m in heights_m
    ]
    seen, footprint = (
        np.array([masks.reshape(len(places_enu_m), -1) for masks in kind])
        for kind in ([view.seen for view in views], [view.unoccluded for view in views])
    )
    used = footprint.any(axis=(0, 1))
    seen, footprint = seen[..., used], footprint[..., used]
    chosen = best_places(seen, footprint, places_enu_m, spacing_m)
    layers = np.arange(len(chosen))
    seen_cells = int(np.count_nonzero(seen[layers, chosen].any(axis=0)))
    footprint_cells = int(np.count_nonzero(footprint[layers, chosen].any(axis=0)))
    return Oracle(
        positions_enu_m=places_enu_m[chosen],
        visibility=seen_cells / max(footprint_cells, 1),
        area_m2=seen_cells * views[0].resolution_m ** 2,
    )


def _disc(radius_m: float, pitch_m: float) -> NDArray[np.float64]:
    """Return a square lattice within a circle, shape (c, 2)."""
    steps = np.arange(-(radius_m // pitch_m), radius_m // pitch_m + 1) * pitch_m
    lattice = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    return np.asarray(lattice[np.linalg.norm(lattice, axis=1) <= radius_m])


def best_places(
    seen: BoolArray,
    footprint: BoolArray,
    places_enu_m: NDArray[np.float64],
    spacing_m: float,
) -> IntArray:
    """Return the index of the place of each layer, shape (n,).

    Args:
        seen: cells of the focal plane that a vehicle in layer l sees from place c, shape (n, c, cells).
        footprint: cells that it would see without forest, same shape.
        places_enu_m: shape (c, 2).
        spacing_m: least horizontal distance of two vehicles (c4).

    Raises:
        ValueError: the shapes do not fit, or the places have no room for n vehicles at that spacing.
    """
    if seen.shape != footprint.shape or seen.ndim != 3 or places_enu_m.shape != (seen.shape[1], 2):
        raise ValueError(
            f"seen and footprint must have one shape (n, c, cells) and places_enu_m (c, 2), but they have "
            f"{seen.shape}, {footprint.shape} and {places_enu_m.shape}."
        )
    distances_m = np.linalg.norm(places_enu_m[:, np.newaxis] - places_enu_m, axis=-1)
    conflicts = distances_m < spacing_m * (1.0 - 1e-9)
    search = _Search(seen, footprint, conflicts)
    solutions = [search.exchange(search.greedy(first)) for first in range(len(seen))]
    return max(solutions, key=search.value)


class _Search:
    """Local search over one place per layer; -1 stands for none yet."""

    def __init__(self, seen: BoolArray, footprint: BoolArray, conflicts: BoolArray) -> None:
        self._seen, self._footprint, self._conflicts = seen, footprint, conflicts
        self._layers = np.arange(seen.shape[0])

    def greedy(self, first: int) -> IntArray:
        """Choose layer by layer, beginning with ``first``."""
        chosen = np.full(len(self._layers), -1)
        for layer in np.roll(self._layers, -first).tolist():
            chosen[layer] = int(self._scores(layer, chosen).argmax())
        return chosen

    def exchange(self, chosen: IntArray) -> IntArray:
        """Move one vehicle at a time to its best place, as long as that helps."""
        improved, sweeps = True, 0
        while improved and sweeps < MAX_SWEEPS:
            improved, sweeps = False, sweeps + 1
            for layer in range(len(chosen)):
                scores = self._scores(layer, chosen)
                best = int(scores.argmax())
                if scores[best] > scores[chosen[layer]]:
                    chosen[layer], improved = best, True
        return chosen

    def value(self, chosen: IntArray) -> float:
        return float(self._scores(0, chosen)[chosen[0]])

    def _scores(self, layer: int, chosen: IntArray) -> NDArray[np.float64]:
        """Return the normalised visibility for every place of a layer, the others staying where they are, shape (c,).

        Places too near to the others have a score of minus infinity.
        """
        others = self._layers[(self._layers != layer) & (chosen >= 0)]
        seen = self._seen[others, chosen[others]].any(axis=0)
        scores: NDArray[np.float64] = np.count_nonzero(seen | self._seen[layer], axis=1).astype(np.float64)
        footprint = self._footprint[others, chosen[others]].any(axis=0)
        scores /= np.maximum(np.count_nonzero(footprint | self._footprint[layer], axis=1), 1)
        scores[self._conflicts[chosen[others]].any(axis=0)] = -np.inf
        if not np.isfinite(scores).any():
            raise ValueError(
                f"There is no room for {len(chosen)} vehicles at this spacing on {len(scores)} places: "
                "give more places, or a smaller spacing."
            )
        return scores
