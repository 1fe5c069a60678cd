"""Takeoffs of the flights whose photographs lie in one folder, by the altitudes that their relative heights count from.

Absolute altitudes of receivers without RTK drift by metres from one photograph to the next, where heights above the
place of takeoff err by decimetres. So all photographs of a takeoff share one altitude, the median of what they tell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.heights import AmslM

MIN_APART_M = 5.0
"""Gap between altitudes from which they are those of two takeoffs: less may be the drift of one flight."""
FEWEST = 3
"""Photographs that make a takeoff of their own: with fewer it is the receiver that errs."""


@dataclass(frozen=True, slots=True)
class TakeoffSite:
    """A place that an aircraft has taken off from."""

    altitude_amsl_m: AmslM
    """Altitude that its photographs tell, in the median."""
    photographs: tuple[int, ...]
    """Indices of the photographs of the flight."""
    strays: tuple[int, ...] = ()
    """Indices of those among them that tell an altitude far from it, which is taken for an error."""


def group_takeoffs(altitudes_amsl_m: Sequence[AmslM | None]) -> tuple[TakeoffSite, ...]:
    """Return the takeoffs of photographs, the one with the most photographs first; none where no altitude is told.

    Args:
        altitudes_amsl_m: altitude of the takeoff that each photograph tells, in their order; one that tells none
            belongs to the takeoff of the nearest one that does.
    """
    told = [altitude_m for altitude_m in altitudes_amsl_m if altitude_m is not None]
    if not told:
        return ()
    known = np.array([altitude_m is not None for altitude_m in altitudes_amsl_m])
    altitudes_m = np.array(told, dtype=np.float64)
    own = _apart(altitudes_m)
    joined = _with_strays(own)
    places = np.flatnonzero(known)
    nearest = np.searchsorted((places[1:] + places[:-1]) / 2.0, np.arange(len(known)))
    takeoffs = []
    for group in np.unique(joined):
        altitude_m = float(np.median(altitudes_m[(own == group) & (joined == group)]))
        strays = places[(joined == group) & (own != group)]
        photographs = np.flatnonzero(joined[nearest] == group)
        takeoffs.append(TakeoffSite(AmslM(altitude_m), tuple(photographs.tolist()), tuple(strays.tolist())))
    return tuple(sorted(takeoffs, key=lambda one: (-len(one.photographs), one.photographs)))


def _apart(altitudes_m: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return a number for each altitude, the same for those between which there is no gap."""
    order = np.argsort(altitudes_m, kind="stable")
    numbers = np.zeros(len(altitudes_m), dtype=np.intp)
    numbers[order[1:]] = np.cumsum(np.diff(altitudes_m[order]) > MIN_APART_M)
    return numbers


def _with_strays(groups: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return groups in which the members of very small ones belong to the one before them, else to the one behind."""
    is_large = np.bincount(groups)[groups] >= FEWEST
    if not is_large.any():
        return groups
    large = np.flatnonzero(is_large)
    before = np.searchsorted(large, np.arange(len(groups)), side="right") - 1
    return groups[large[np.maximum(before, 0)]]
