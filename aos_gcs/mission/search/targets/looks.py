"""Looks: where the swarm has converged, for how many steps, and which places it need not look at again."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.imaging.step.judgement import SETTLED_M


@dataclass(slots=True)
class _Look:
    """One place that the swarm has converged on."""

    place_enu_m: tuple[float, float]
    track_id: int | None
    """None: its track has gone on to something else."""
    steps: int = 0
    others: int = 0
    """Sightings that were surely no person, since the last one that may have been."""
    is_settled: bool = False


class Looks:
    """Places that the swarm has looked at, by place: a track that is lost and seen again is not looked at anew."""

    def __init__(self) -> None:
        self._looks: list[_Look] = []
        self._left_enu_m: list[tuple[float, float]] = []

    @property
    def settled_enu_m(self) -> tuple[tuple[float, float], ...]:
        """Places that the swarm does not converge on again."""
        return (*(look.place_enu_m for look in self._looks if look.is_settled), *self._left_enu_m)

    def follow(self, places_enu_m: Mapping[int, NDArray[np.float64]]) -> None:
        """Move the places with their tracks in view, whose positions, shape (2,), are given by id.

        A track that goes on to something farther off leaves the place where it is.
        """
        for look in self._looks:
            if look.track_id is None or look.track_id not in places_enu_m:
                continue
            east_m, north_m = map(float, places_enu_m[look.track_id])
            if math.dist(look.place_enu_m, (east_m, north_m)) <= SETTLED_M:
                look.place_enu_m = east_m, north_m
            else:
                look.track_id = None

    def count(self, track_id: int, position_enu_m: EnuPoint) -> int:
        """Count a step of converging on a target, and return the number of such steps."""
        look = self._at(track_id, position_enu_m)
        look.steps += 1
        return look.steps

    def count_other(
        self, track_id: int, position_enu_m: EnuPoint, *, is_surely_other: bool, may_be_person: bool, worth: int = 1
    ) -> int:
        """Count a sighting of a target, worth one or several, and return how many in a row were surely no person.

        One that may be a person begins anew. Steps without a sighting leave the number as it is, as do sightings by too
        few vehicles to be sure: what leaves show and hide in turn is looked at in parts.
        """
        look = self._at(track_id, position_enu_m)
        if is_surely_other:
            look.others += worth
        elif may_be_person:
            look.others = 0
        return look.others

    def settle(self, track_id: int, position_enu_m: EnuPoint) -> None:
        """Converge on a target no more."""
        self._at(track_id, position_enu_m).is_settled = True

    def leave(self, blob_enu_m: EnuPoint) -> None:
        """Converge no more on the blob that showed a settled target.

        Where poses err, or another thing adds to it, its middle lies beside the place of the target; without this, the
        swarm would turn to it in the next step again.
        """
        if all(math.dist(blob_enu_m[:2], place_enu_m) > SETTLED_M for place_enu_m in self.settled_enu_m):
            self._left_enu_m.append(blob_enu_m[:2])

    def _at(self, track_id: int, position_enu_m: EnuPoint) -> _Look:
        for look in self._looks:
            if look.track_id == track_id or math.dist(look.place_enu_m, position_enu_m[:2]) <= SETTLED_M:
                look.track_id = track_id
                return look
        self._looks.append(_Look(position_enu_m[:2], track_id))
        return self._looks[-1]
