"""Preflight checks of every vehicle from its telemetry: the matrix vehicle x check."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from aos_gcs.airspace.accuracy import beside_errors_m
from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.mission.fleet.accuracies import accuracy_of
from aos_gcs.mission.fleet.homes import home_away_m
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.fleet.watches.condition import MAX_BATTERY_AGE_S
from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.preflight import checks
from aos_gcs.planning.settings import MissionSettings

MIN_GPS_FIX = 3
"""Smallest GPS fix: 3D."""
GPS_FIXES: Final = {
    0: "no GPS",
    1: "no fix",
    2: "2D fix",
    3: "3D fix",
    4: "DGPS fix",
    5: "RTK float fix",
    6: "RTK fix",
    7: "static fix",
    8: "PPP fix",
}
"""Names of MAVLink's GPS_FIX_TYPE."""
MIN_START_BATTERY_FRACTION = 0.5
MAX_LINK_AGE_S = 3.0
MAX_LOSS_FRACTION = 0.2
MAX_ROUND_TRIP_S = 1.0
MAX_CLOCK_DRIFT = 1e-3
"""Largest drift: a quartz is ten times better; more is a clock being set, or an overloaded link."""
MIN_SATELLITES = 8
MAX_HDOP = 2.0
_SLACK_M = 0.01
_TRAFFIC_REACH_M = 100.0
"""Distance outside of the geofence up to which another vehicle in the air counts as near."""


def check_area(settings: MissionSettings) -> tuple[PreflightCheck, ...]:
    """Return a failed check as long as there is no area to search."""
    if settings.area_enu_m:
        return ()
    text, remedy = "there is no search area", "draw one in the plan of the dashboard, and apply it"
    return (checks.failed(checks.MISSION, checks.PLAN, text, remedy),)


def check_vehicles(roster: Roster, planned: int) -> tuple[PreflightCheck, ...]:
    """Return a failed check while it is open which vehicles fly, or while one that does is not heard."""
    heard, chosen = roster.members(), roster.chosen()
    if chosen and len(chosen) == planned:
        return ()
    if len(heard) < planned:
        text, remedy = f"{len(heard)} of {planned} heard", "switch the others on, or lower the number"
    else:
        ids = ", ".join(str(member.vehicle_id) for member in heard)
        text, remedy = f"{planned} planned, heard: {ids}", "confirm the vehicles that fly; others are not armed"
    return (checks.failed(checks.MISSION, checks.VEHICLES, text, remedy),)


def check_all(roster: Roster, members: Sequence[Member], launch_distance_m: float) -> tuple[PreflightCheck, ...]:
    """Return the matrix vehicle x check, in the order of the ids.

    Args:
        roster: the vehicles heard.
        members: those to be checked.
        launch_distance_m: smallest distance between two launch points.
    """
    found = [check for member in members for check in _check_vehicle(roster, member)]
    return checks.in_order([*found, *_check_launch_points(roster, members, launch_distance_m)])


def check_layers(
    roster: Roster, members: Sequence[Member], layer_spacing_m: float, limits: SafetyLimits | None
) -> list[PreflightCheck]:
    """Return for each member whether it has an altitude layer, within the limits, and the layer is free.

    Other vehicles that fly, heard or not, occupy a layer where they are or were last; those far outside of the geofence
    do not.
    """
    others = [member for member in roster.members() if member in members or _may_meet(roster, member, limits)]
    rows_m = np.array([np.nan if m.layer_height_m is None else m.layer_height_m for m in members])
    layers_m = np.array([np.nan if m.layer_height_m is None else m.layer_height_m for m in others])
    flown_m = np.array([_flown_height_m(roster, member) for member in others])
    # Rows need a layer, columns may occupy it, by plan or because they fly there.
    taken = np.abs(np.stack([layers_m, flown_m])[:, None, :] - rows_m[:, None]) < layer_spacing_m - _SLACK_M
    found = []
    for member, row in zip(members, taken.any(axis=0), strict=True):
        takers = [others[k] for k in np.flatnonzero(row) if others[k] is not member]
        found.append(_check_layer(roster, member, takers, limits))
    return found


def _may_meet(roster: Roster, member: Member, limits: SafetyLimits | None) -> bool:
    """Return whether a vehicle in the air is near enough to the geofence to meet those of the mission."""
    position_enu_m = roster.position_enu_m(member)
    if limits is None or position_enu_m is None:
        return True
    fence, *_ = limits.boundaries()
    return fence.depth_m(position_enu_m[:2]) > -_TRAFFIC_REACH_M


def _check_vehicle(roster: Roster, member: Member) -> list[PreflightCheck]:
    return [
        _check_autopilot(member),
        _check_link(roster, member),
        _check_clock(member),
        _check_position(member),
        _check_home(member),
        _check_battery(member),
        _check_ready(member),
    ]


def _check_autopilot(member: Member) -> PreflightCheck:
    autopilot = member.state.autopilot
    if autopilot == "unknown":
        remedy = "it can be shown, but not commanded: use ArduCopter or PX4"
        return checks.failed(member.vehicle_id, checks.AUTOPILOT, autopilot, remedy)
    return checks.passed(member.vehicle_id, checks.AUTOPILOT, autopilot)


def _check_link(roster: Roster, member: Member) -> PreflightCheck:
    age_s = roster.link_age_s(member)
    text = "never heard" if age_s is None else f"heard {age_s:.1f} s ago"
    if age_s is None or age_s > MAX_LINK_AGE_S:
        return checks.failed(member.vehicle_id, checks.LINK, text, "check its radio and the link's address")
    loss_fraction, link = member.state.packet_loss_fraction, member.state.link
    round_trip_s = None if link is None else link.round_trip_s
    text += "" if loss_fraction is None else f", {100 * loss_fraction:.0f} % lost"
    text += "" if round_trip_s is None else f", {1000 * round_trip_s:.0f} ms round trip"
    if (loss_fraction or 0.0) > MAX_LOSS_FRACTION or (round_trip_s or 0.0) > MAX_ROUND_TRIP_S:
        return checks.warned(member.vehicle_id, checks.LINK, text, "bring it closer, or lower its telemetry rates")
    return checks.passed(member.vehicle_id, checks.LINK, text)


def _check_clock(member: Member) -> PreflightCheck:
    link = member.state.link
    if link is None or link.clock_offset_s is None:
        return checks.warned(member.vehicle_id, checks.CLOCK, "offset not known", "wait: its clock is being read")
    if link.clock_drift is None:
        return checks.passed(member.vehicle_id, checks.CLOCK, "offset known")
    text = f"offset known, drifts by {1e6 * link.clock_drift:+.0f} µs per second"
    if abs(link.clock_drift) > MAX_CLOCK_DRIFT:
        return checks.warned(member.vehicle_id, checks.CLOCK, text, "wait until its clock is set, or check its link")
    return checks.passed(member.vehicle_id, checks.CLOCK, text)


def _check_position(member: Member) -> PreflightCheck:
    state = member.state
    fix = "fix unknown" if state.gps_fix is None else GPS_FIXES.get(state.gps_fix, f"GPS fix {state.gps_fix}")
    text = f"{fix}, " + ("satellites unknown" if state.satellites is None else f"{state.satellites} satellites")
    if state.gps_fix is None or state.gps_fix < MIN_GPS_FIX:
        remedy = "no 3D position fix: wait, or move it away from obstacles"
        return checks.failed(member.vehicle_id, checks.POSITION, text, remedy)
    if state.position is None:
        remedy = "wait until its autopilot has a position estimate"
        return checks.failed(member.vehicle_id, checks.POSITION, f"{text}, but no position yet", remedy)
    text += "" if state.hdop is None else f", HDOP {state.hdop:.1f}"
    if (state.satellites or 0) < MIN_SATELLITES or (state.hdop or 0.0) > MAX_HDOP:
        return checks.warned(member.vehicle_id, checks.POSITION, text, "wait for more satellites, in the open")
    return checks.passed(member.vehicle_id, checks.POSITION, text)


def _check_home(member: Member) -> PreflightCheck:
    if member.state.home is None:
        return checks.failed(member.vehicle_id, checks.HOME, "not set", "wait for the position estimate")
    if (away_m := home_away_m(member.state)) is not None:
        remedy = "the vehicle stays on the ground unless arming moves its home here: restart it where it stands"
        return checks.warned(member.vehicle_id, checks.HOME, f"{away_m:.0f} m from where it stands", remedy)
    return checks.passed(member.vehicle_id, checks.HOME, "set")


def _check_battery(member: Member) -> PreflightCheck:
    fraction = member.state.battery_fraction
    text = "unknown" if fraction is None else f"{100 * fraction:.0f} %"
    if fraction is None or fraction < MIN_START_BATTERY_FRACTION:
        remedy = f"replace the battery: a search needs {100 * MIN_START_BATTERY_FRACTION:.0f} % or more"
        return checks.failed(member.vehicle_id, checks.BATTERY, text, remedy)
    reported_at_s, heard_at_s = member.state.battery_at_s, member.state.heard_at_s
    age_s = 0.0 if reported_at_s is None or heard_at_s is None else heard_at_s - reported_at_s
    if age_s > MAX_BATTERY_AGE_S:
        text += f", reported {age_s:.0f} s ago"
        return checks.failed(member.vehicle_id, checks.BATTERY, text, "check its battery monitor")
    return checks.passed(member.vehicle_id, checks.BATTERY, text)


def _check_ready(member: Member) -> PreflightCheck:
    state = member.state
    if state.ready_to_arm is True:
        return checks.passed(member.vehicle_id, checks.READY_TO_ARM, "yes")
    remedy = state.text or "wait for its own checks, or read its messages"
    return checks.failed(member.vehicle_id, checks.READY_TO_ARM, "the autopilot is not ready", remedy)


def _check_launch_points(roster: Roster, members: Sequence[Member], launch_distance_m: float) -> list[PreflightCheck]:
    """Return the check of every vehicle's distance to the nearest other one; a large fleet has thousands of pairs."""
    errors_m = {m.vehicle_id: beside_errors_m(accuracy_of(m.state)) for m in members}
    places = {m.vehicle_id: place for m in members if (place := roster.position_enu_m(m)) is not None}
    ids, places_enu_m = list(places), np.array(list(places.values())).reshape(-1, 3)[:, :2]
    distances_m = np.linalg.norm(places_enu_m[:, None] - places_enu_m, axis=-1)
    np.fill_diagonal(distances_m, np.inf)
    nearest = {
        vehicle_id: (ids[int(np.argmin(row_m))], float(np.min(row_m)))
        for vehicle_id, row_m in zip(ids, distances_m, strict=True)
    }
    return [
        _check_launch_point(m.vehicle_id, nearest.get(m.vehicle_id), launch_distance_m + errors_m[m.vehicle_id])
        for m in members
    ]


def _check_launch_point(vehicle_id: int, nearest: tuple[int, float] | None, launch_distance_m: float) -> PreflightCheck:
    if nearest is None:
        return checks.failed(vehicle_id, checks.LAUNCH_POINT, "unknown position", "wait for its position")
    nearest_id, distance_m = nearest
    if nearest_id == vehicle_id:
        return checks.passed(vehicle_id, checks.LAUNCH_POINT, "alone")
    text = f"{distance_m:.1f} m from vehicle {nearest_id}"
    if distance_m < launch_distance_m:
        return checks.failed(vehicle_id, checks.LAUNCH_POINT, text, f"place them {launch_distance_m:.1f} m apart")
    return checks.passed(vehicle_id, checks.LAUNCH_POINT, text)


def _flown_height_m(roster: Roster, member: Member) -> float:
    """Return the height above the reference surface at which a vehicle flies; NaN on the ground, and in its layer.

    There it occupies the layer and no other, whatever its position errs by.
    """
    position_enu_m = roster.position_enu_m(member) if member.airborne and not roster.is_in_layer(member) else None
    if position_enu_m is None or roster.layers.surface is None:
        return np.nan
    return float(position_enu_m[2]) - roster.layers.surface.at(position_enu_m)


def _check_layer(roster: Roster, member: Member, takers: list[Member], limits: SafetyLimits | None) -> PreflightCheck:
    vehicle_id, layer_m = member.vehicle_id, member.layer_height_m
    if layer_m is None:
        return checks.failed(vehicle_id, checks.ALTITUDE_LAYER, "none yet", "wait until all homes are known")
    text = f"{layer_m:g} m"
    if roster.layers.surface is None:
        remedy = "the layers follow the ground: correct the elevation model"
        return checks.failed(vehicle_id, checks.ALTITUDE_LAYER, f"{text}, its height is not known", remedy)
    lowest_m, highest_m = layer_m + roster.layers.surface.lowest_m, layer_m + roster.layers.surface.highest_m
    if limits is not None and not limits.floor_m <= lowest_m <= highest_m <= limits.ceiling_m:
        text += f", outside of {limits.floor_m:g} to {limits.ceiling_m:g} m"
        remedy = "raise the ceiling, lower the layers, or fly fewer vehicles"
        return checks.failed(vehicle_id, checks.ALTITUDE_LAYER, text, remedy)
    if takers:
        taker = takers[0]
        age_s = roster.link_age_s(taker) or 0.0
        if all(other not in roster.chosen() and (roster.link_age_s(other) or 0.0) > MAX_LINK_AGE_S for other in takers):
            remedy = f"vehicle {taker.vehicle_id} flew in it when last heard {age_s:.0f} s ago: look for it"
            return checks.warned(vehicle_id, checks.ALTITUDE_LAYER, text, remedy)
        remedy = f"vehicle {taker.vehicle_id} has it or flies in it: land that vehicle first"
        return checks.failed(vehicle_id, checks.ALTITUDE_LAYER, text, remedy)
    return checks.passed(vehicle_id, checks.ALTITUDE_LAYER, text)
