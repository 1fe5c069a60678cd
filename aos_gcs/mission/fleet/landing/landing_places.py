"""Landing places: launch points, or spots about a return point, none of them where another vehicle stands."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.spacing import landing_spots
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.landing.descents import is_within, landing_place_enu_m, near_standing, stands_near
from aos_gcs.mission.fleet.member import Member
from aos_gcs.ports import Severity

FloatArray = NDArray[np.float64]

_SPOTS_APART: Final = 2.0
"""Distance of two landing spots, in separations: both vehicles may err by half of one."""
_ROUNDING: Final = 0.99
_SPOTS_PER_VEHICLE: Final = 6
"""Number of spots to choose from, per vehicle: one on the ground occupies up to four."""


class LandingPlaces:
    """Landing places of the vehicles that return."""

    def __init__(self, context: FlightContext) -> None:
        self._context = context
        self._instead_of: dict[int, FloatArray] = {}
        """Launch point that another place was chosen for, by vehicle, without a return point."""

    def of(self, member: Member) -> FloatArray | None:
        """Return a vehicle's landing place, shape (3,); None while it is not known.

        That is its launch point, or its own spot about the return point where the plan has one.
        """
        context, home_enu_m = self._context, member.home_enu_m
        centre_enu_m = context.settings.return_enu_m
        instead_of = self._instead_of.get(member.vehicle_id)
        if instead_of is not None and instead_of is not home_enu_m:
            # It has taken off elsewhere since.
            del self._instead_of[member.vehicle_id]
            member.landing_enu_m = None
        if home_enu_m is not None and member.landing_enu_m is None and centre_enu_m is not None:
            self._choose(member, home_enu_m, np.asarray(centre_enu_m))
        return landing_place_enu_m(member)

    def leave_occupied(self, member: Member) -> bool:
        """Choose another landing place for a vehicle where another one stands; return whether that was necessary."""
        place_enu_m, home_enu_m = self.of(member), member.home_enu_m
        if place_enu_m is None or home_enu_m is None:
            return False
        other_id = stands_near(self._context, member, place_enu_m[:2])
        if other_id is None:
            return False
        centre_enu_m = self._context.settings.return_enu_m
        if centre_enu_m is None:
            self._instead_of[member.vehicle_id] = home_enu_m
        member.landing_enu_m = None
        if not self._choose(member, home_enu_m, home_enu_m if centre_enu_m is None else np.asarray(centre_enu_m)):
            return False
        text = f"lands beside its landing place: vehicle {other_id} stands there"
        self._context.journal.notice(Severity.WARNING, text, member.vehicle_id)
        return True

    def _choose(self, member: Member, home_enu_m: FloatArray, centre_enu_m: FloatArray) -> bool:
        """Give a vehicle the free spot that is nearest to a place; without one, it keeps its launch point."""
        context, limits = self._context, self._context.bounds.limits
        if limits is None:
            return False
        members = context.roster.members()
        spacing_m = max(_SPOTS_APART * limits.separation_m, context.flight.clearance_m(members))
        spots_m = landing_spots(centre_enu_m[:2].tolist(), _SPOTS_PER_VEHICLE * (len(members) + 2), spacing_m)
        offsets_m = spots_m[:, None] - self._taken_m(member)
        is_free = (np.linalg.norm(offsets_m, axis=-1) > _ROUNDING * spacing_m).all(axis=1)
        is_free &= is_within(context, spots_m)
        for is_near in near_standing(context, member, spots_m).values():
            is_free &= ~is_near
        if not is_free.any():
            return False
        member.landing_enu_m = np.array([*spots_m[is_free][0], home_enu_m[2]])
        return True

    def _taken_m(self, member: Member) -> FloatArray:
        """Return the landing places of the others, shape (k, 2)."""
        has_point = self._context.settings.return_enu_m is not None
        others = [other for other in self._context.roster.members() if other is not member]
        places = [other.landing_enu_m if has_point else landing_place_enu_m(other) for other in others]
        return np.array([place_enu_m[:2] for place_enu_m in places if place_enu_m is not None]).reshape(-1, 2)
