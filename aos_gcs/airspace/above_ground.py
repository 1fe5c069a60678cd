"""Vetting of segments against the ground: the part of each that keeps its heights above it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.limits import GroundLimits
from aos_gcs.airspace.terrain import GroundProfile, GroundRaster
from aos_gcs.airspace.traffic import Admission, WaypointRequest

FloatArray = NDArray[np.float64]

_TOLERANCE_M = 1e-6
UNKNOWN_GROUND = "the elevation model is not loaded"


def above_ground(
    requests: Sequence[WaypointRequest], limits: GroundLimits | None, ground: GroundRaster | None
) -> dict[int, Admission]:
    """Return which part of each segment keeps the limits above ground, by id; those that keep them are left out.

    A vehicle that violates a limit already may move, but not so that it violates it more; from above ground that is not
    known it may leave to where it is.
    """
    if limits is None or not requests:
        return {}
    if ground is None:
        return {request.vehicle_id: Admission(0.0, UNKNOWN_GROUND) for request in requests}
    starts_m = np.array([request.position_enu_m for request in requests], dtype=np.float64)
    ends_m = np.array([request.requested_enu_m for request in requests], dtype=np.float64)
    profile = ground.along(starts_m, ends_m)
    lacking_m = _lacking_m(profile, limits, _heights_m(ground, starts_m), _heights_m(ground, ends_m))
    barred = np.flatnonzero(lacking_m > _TOLERANCE_M)
    found = {}
    for row in np.unique(profile.segments[barred]):
        own = barred[profile.segments[barred] == row]
        fraction = float(profile.fractions[own[0]])
        worst = own[int(np.argmax(lacking_m[own]))]
        found[requests[int(row)].vehicle_id] = Admission(fraction, _reason(profile, worst, limits, lacking_m[worst]))
    return found


def _heights_m(ground: GroundRaster, places_enu_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the least and the greatest height that places, shape (n, 3), may have above the ground."""
    lowest_m, highest_m = ground.bounds_at(places_enu_m[:, :2])
    return places_enu_m[:, 2] - highest_m, places_enu_m[:, 2] - lowest_m


def _lacking_m(
    profile: GroundProfile,
    limits: GroundLimits,
    at_start_m: tuple[FloatArray, FloatArray],
    at_end_m: tuple[FloatArray, FloatArray],
) -> FloatArray:
    """Return by how much each interval misses its limits; infinite where the ground is not known, 0 where it may be."""
    least_m = np.fmin(limits.floor_m, at_start_m[0])[profile.segments]
    most_m = np.fmax(limits.ceiling_m, at_start_m[1])[profile.segments]
    too_low_m = least_m - (profile.least_up_m - profile.highest_m)
    too_high_m = profile.most_up_m - profile.lowest_m - most_m
    too_far_m = np.fmax(np.fmax(too_low_m, too_high_m), 0.0)
    # Of a segment that leaves unknown ground, what comes before the first interval that is known may be unknown.
    leaves = np.isnan(at_start_m[0]) & np.isfinite(at_end_m[0])
    firsts = np.searchsorted(profile.segments, np.arange(len(leaves)))
    known = np.cumsum(profile.is_known)
    known_so_far: NDArray[np.int64] = known - (known - profile.is_known)[firsts][profile.segments]
    may_be_unknown = leaves[profile.segments] & (known_so_far == 0)
    return np.where(profile.is_known | may_be_unknown, too_far_m, np.inf)


def _reason(profile: GroundProfile, at: int, limits: GroundLimits, lacking_m: float) -> str:
    east_m, north_m, _ = profile.places_enu_m[at]
    where = f"{east_m:.0f} m east, {north_m:.0f} m north"
    if not np.isfinite(lacking_m):
        return f"the ground is not known at {where}"
    height_m = profile.least_up_m[at] - profile.highest_m[at]
    if height_m < limits.floor_m:
        below_m = limits.floor_m - height_m
        return f"{height_m:.1f} m above the ground at {where}, {below_m:.1f} m below the floor above ground"
    over_m = profile.most_up_m[at] - profile.lowest_m[at]
    return (
        f"{over_m:.1f} m above the ground at {where}, {over_m - limits.ceiling_m:.1f} m beyond the ceiling above ground"
    )
