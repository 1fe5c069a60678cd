"""The checks that every vehicle passes before its motors start."""

from __future__ import annotations

import numpy as np

from aos_gcs.mission.model import PreflightCheck
from aos_gcs.mission.roster import Member, Roster

MIN_GPS_FIX = 3
"""A 3D fix."""
MIN_START_BATTERY_FRACTION = 0.5
MAX_LINK_AGE_S = 3.0
MIN_HOME_DISTANCE_M = 2.0


def check_all(roster: Roster, expected: int, min_home_distance_m: float) -> tuple[PreflightCheck, ...]:
    """Return the matrix vehicle x check, in the order of the ids.

    Args:
        roster: the vehicles heard.
        expected: how many the mission waits for.
        min_home_distance_m: smallest distance between two launch points, for vertical take-offs side by side.
    """
    members = roster.members()
    checks = [check for member in members for check in _check_vehicle(roster, member)]
    checks += [_check_home_distance(roster, member, members, min_home_distance_m) for member in members]
    if len(members) < expected:
        text = f"{len(members)} of {expected} vehicles are heard; switch the others on or lower the number"
        checks.append(PreflightCheck(0, "vehicles", passed=False, text=text))
    return tuple(sorted(checks, key=lambda check: check.vehicle_id))


def _check_vehicle(roster: Roster, member: Member) -> list[PreflightCheck]:
    state = member.state
    link_age_s = roster.link_age_s(member)
    fix, battery = state.gps_fix, state.battery_fraction
    return [
        _check(
            member,
            "autopilot",
            state.autopilot != "unknown",
            state.autopilot,
            "unknown autopilot: it is shown but not commanded; use ArduCopter or PX4",
        ),
        _check(
            member,
            "link",
            link_age_s is not None and link_age_s <= MAX_LINK_AGE_S,
            f"heard {link_age_s or 0.0:.1f} s ago",
            "silent: check its radio and the link's address",
        ),
        _check(
            member,
            "position",
            state.position is not None and fix is not None and fix >= MIN_GPS_FIX,
            f"fix type {fix}, {state.satellites} satellites",
            "no 3D position fix: wait, or move it away from obstacles",
        ),
        _check(member, "home", state.home is not None, "set", "no home position: wait for the position estimate"),
        _check(
            member,
            "battery",
            battery is not None and battery >= MIN_START_BATTERY_FRACTION,
            f"{100 * (battery or 0.0):.0f} %",
            f"below {100 * MIN_START_BATTERY_FRACTION:.0f} % or unknown: change the battery",
        ),
        _check(
            member,
            "ready to arm",
            state.ready_to_arm is True,
            "yes",
            f"the autopilot is not ready{': ' + state.text if state.text else ''}",
        ),
    ]


def _check(member: Member, name: str, passed: bool, value: str, remedy: str) -> PreflightCheck:
    return PreflightCheck(member.vehicle_id, name, passed, value if passed else remedy)


def _check_home_distance(
    roster: Roster, member: Member, members: list[Member], min_home_distance_m: float
) -> PreflightCheck:
    position_enu_m = roster.position_enu_m(member)
    nearest_m, nearest_id = np.inf, None
    for other in members:
        other_enu_m = roster.position_enu_m(other)
        if other is member or position_enu_m is None or other_enu_m is None:
            continue
        distance_m = float(np.linalg.norm((position_enu_m - other_enu_m)[:2]))
        if distance_m < nearest_m:
            nearest_m, nearest_id = distance_m, other.vehicle_id
    return _check(
        member,
        "launch point",
        position_enu_m is not None and nearest_m >= min_home_distance_m,
        "alone" if nearest_id is None else f"{nearest_m:.1f} m from vehicle {nearest_id}",
        f"only {nearest_m:.1f} m from vehicle {nearest_id}: put them {min_home_distance_m:.1f} m apart"
        if nearest_id is not None
        else "unknown position",
    )
