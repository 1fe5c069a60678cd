"""Preflight checks of the returns that autopilots fly by themselves, against the ground and the layers of others."""

from __future__ import annotations

from collections.abc import Sequence

from aos_gcs.airspace.accuracy import allowed_offset_m
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.preflight import checks
from aos_gcs.mission.preflight.setup import ReturnBounds
from aos_gcs.planning.terrain.returns import ReturnClearance


def return_bounds(roster: Roster, member: Member, clearance: ReturnClearance | None) -> ReturnBounds:
    """Return the heights above its home between which a vehicle's own return has to be.

    Over relief that its layer follows, it is one height alone: a lower one would cross the returns of others.
    """
    return_m = roster.layers.return_above_home_m(member)
    if clearance is None or member.home_enu_m is None:
        return ReturnBounds(return_m)
    least_m, least_of = (
        clearance.least_up_m - float(member.home_enu_m[2]),
        f"the floor above the ground at {clearance.place}",
    )
    if return_m is not None and roster.layers.follow_ground and return_m > least_m:
        least_m, least_of = return_m, "its layer above the highest place of the ground that the layers follow"
    return ReturnBounds(return_m, least_m, least_of)


def check_return_climbs(
    roster: Roster, members: Sequence[Member], separation_m: float, layer_spacing_m: float
) -> list[PreflightCheck]:
    """Return for every vehicle whether its own return may climb through the layers of others.

    Over level layers it never climbs out of its own. Where layers follow the ground, it climbs to its layer above the
    highest place of the surface first.

    Args:
        roster: the vehicles heard.
        members: those that are to fly.
        separation_m: smallest distance between two vehicles.
        layer_spacing_m: vertical distance between altitude layers.
    """
    surface = roster.layers.surface
    climb_m = 0.0 if surface is None else surface.highest_m - surface.lowest_m
    if climb_m <= allowed_offset_m(separation_m, layer_spacing_m):
        return []
    return [_check_climb(member, members, climb_m, separation_m) for member in members]


def _check_climb(member: Member, members: Sequence[Member], climb_m: float, separation_m: float) -> PreflightCheck:
    vehicle_id, layer_m = member.vehicle_id, member.layer_height_m
    reach_m = climb_m + separation_m
    above = [
        other.vehicle_id
        for other in members
        if layer_m is not None and other.layer_height_m is not None and 0.0 < other.layer_height_m - layer_m < reach_m
    ]
    if layer_m is not None and not above:
        return checks.passed(vehicle_id, checks.RETURN_CLIMB, "through no other layer")
    others = ", ".join(map(str, above))
    text = f"by up to {climb_m:.1f} m, through the layers of vehicles that may be above it then: {others}"
    remedy = "use level altitude layers, or override this check"
    return checks.failed(vehicle_id, checks.RETURN_CLIMB, text, remedy)
