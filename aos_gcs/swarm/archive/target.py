"""Position and motion of the target for the archive strategy.

An observation tells no time, so that motion is counted per step: an alpha-beta filter follows the target, and one that
stands still is the mean of its sightings.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm.archive.raster import centroids
from aos_gcs.swarm.model import TargetMasks
from aos_gcs.swarm.state import Point

FloatArray = NDArray[np.float64]

ALPHA = 0.5
"""Share of a sighting's deviation that corrects the position."""
BETA = 0.2
"""Share of it that corrects the velocity."""
STRAY_M = 0.5
"""Distance from the mean of its sightings at which a still target counts as moving; their noise is below 0.1 m."""
REST_M = 0.4
"""Path within ``CHECK_SIGHTINGS`` below which a moving target counts as still; a stroller makes 1.5 m in a second."""
CHECK_SIGHTINGS = 10
"""Sightings between two such checks."""
JUMP_M = 6.0
"""A sighting farther from where the target is expected shows something else."""
MAX_MEAN = 20
"""Sightings of a still target after which older ones fade."""
COASTING = 0.8
"""Share of its velocity that a target out of view is expected to keep per step."""


@dataclass(frozen=True, slots=True)
class TargetState:
    """The target as far as it is known."""

    tracked_enu_m: Point
    """Estimate of the filter."""
    velocity_m: Point
    """Displacement per step, east and north."""
    reference_enu_m: Point
    """While still, the mean of the sightings; while moving, its place at the last check."""
    reference_sightings: int = 1
    """Number of sightings in the mean, or since."""
    is_moving: bool = False
    sightings: int = 1
    drift_enu_m: Point = (0.0, 0.0)
    """Displacement since it was found, without the noise of a still target."""
    lost_steps: int = 0
    """Steps since it was last in view."""

    @property
    def position_enu_m(self) -> FloatArray:
        """Best estimate of the point on the focal plane below the target's body, shape (2,)."""
        return np.array(self.tracked_enu_m if self.is_moving else self.reference_enu_m)

    @property
    def next_way_m(self) -> FloatArray:
        """Way that it is expected to make until the next step, shape (2,)."""
        return np.array(self.velocity_m) if self.is_moving else np.zeros(2)


def first_sighting(ground_enu_m: FloatArray) -> TargetState:
    """Return the estimate after the first sighting."""
    point = _point(ground_enu_m)
    return TargetState(point, (0.0, 0.0), point)


def is_elsewhere(estimate: TargetState, ground_enu_m: FloatArray) -> bool:
    """Return whether a sighting is too far from where the target is expected to be of it."""
    expected_m = np.add(estimate.tracked_enu_m, estimate.velocity_m)
    return bool(np.linalg.norm(ground_enu_m - expected_m) > JUMP_M)


def after_sighting(estimate: TargetState, ground_enu_m: FloatArray) -> TargetState:
    """Return the estimate after one more sighting."""
    expected_m = np.array(estimate.tracked_enu_m) + np.array(estimate.velocity_m)
    deviation_m = ground_enu_m - expected_m
    sightings = estimate.sightings + 1
    tracked_m = expected_m + max(ALPHA, 1.0 / sightings) * deviation_m
    velocity_m = np.array(estimate.velocity_m) + BETA * deviation_m
    followed = replace(
        estimate, tracked_enu_m=_point(tracked_m), velocity_m=_point(velocity_m), sightings=sightings, lost_steps=0
    )
    if not estimate.is_moving:
        return _while_still(followed, ground_enu_m)
    drift_m = np.array(estimate.drift_enu_m) + tracked_m - estimate.tracked_enu_m
    return _while_moving(replace(followed, drift_enu_m=_point(drift_m)))


def _while_still(estimate: TargetState, ground_enu_m: FloatArray) -> TargetState:
    """Take a sighting into the mean, unless the target has left it."""
    mean_m, count = np.array(estimate.reference_enu_m), min(estimate.reference_sightings + 1, MAX_MEAN)
    away_m = np.array(estimate.tracked_enu_m) - mean_m
    if np.linalg.norm(away_m) > STRAY_M:
        drift_m = np.array(estimate.drift_enu_m) + away_m
        return replace(
            estimate,
            is_moving=True,
            drift_enu_m=_point(drift_m),
            reference_enu_m=estimate.tracked_enu_m,
            reference_sightings=0,
        )
    mean_m += (ground_enu_m - mean_m) / count
    return replace(estimate, reference_enu_m=_point(mean_m), reference_sightings=count)


def _while_moving(estimate: TargetState) -> TargetState:
    """Look from time to time whether the target has got any farther."""
    if estimate.reference_sightings + 1 < CHECK_SIGHTINGS:
        return replace(estimate, reference_sightings=estimate.reference_sightings + 1)
    way_m = np.subtract(estimate.tracked_enu_m, estimate.reference_enu_m)
    return replace(
        estimate,
        is_moving=bool(np.linalg.norm(way_m) > REST_M),
        reference_enu_m=estimate.tracked_enu_m,
        reference_sightings=1,
    )


def out_of_view(estimate: TargetState) -> TargetState:
    """Return the estimate after a step without a sighting: a moving target goes on, ever more slowly."""
    way_m = estimate.next_way_m
    return replace(
        estimate,
        tracked_enu_m=_point(estimate.tracked_enu_m + way_m),
        drift_enu_m=_point(estimate.drift_enu_m + way_m),
        velocity_m=_point(COASTING * np.array(estimate.velocity_m)),
        lost_steps=estimate.lost_steps + 1,
    )


def ground_point(
    masks: TargetMasks,
    positions_enu_m: FloatArray,
    heights_m: FloatArray,
    target_enu_m: FloatArray,
    body_height_m: float,
) -> FloatArray:
    """Return the point below the target's body that the masks of one step speak for, shape (2,).

    A body is seen beside its foot, away from the camera by half of its height times the slope of the view: without
    that correction the estimate would follow the swarm around.

    Args:
        masks: at least one cell is marked.
        positions_enu_m: positions of the vehicles, shape (n, 2).
        heights_m: heights of the vehicles above the focal plane, shape (n,).
        target_enu_m: first guess, shape (2,).
        body_height_m: height of the target.
    """
    middles_m, counts = centroids(masks)
    slopes = (positions_enu_m - target_enu_m) / heights_m[:, None]
    return np.asarray((middles_m + 0.5 * body_height_m * slopes).T @ (counts / counts.sum()))


def _point(row: FloatArray) -> Point:
    return (float(row[0]), float(row[1]))
