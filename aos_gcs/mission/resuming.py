"""What an operator's *Resume* needs: a swarm to go on with."""

from __future__ import annotations

from aos_gcs.errors import MissionError
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.model.actions import Refusal
from aos_gcs.mission.model.vehicles import Task


def check_resume(roster: Roster, fewest: int) -> None:
    """Check that a suspended search has a swarm to go on with: without one it would end, and land all.

    Args:
        roster: vehicles of the mission.
        fewest: smallest number of vehicles that it goes on with.

    Raises:
        MissionError: too few vehicles can be resumed now, and those that come back can be later; or the heights of
            their layers are not known.
    """
    if roster.layers.surface is None:
        raise MissionError(
            "Cannot resume: the altitude layers follow an elevation model that is not loaded. Return or land the "
            "vehicles."
        )
    members = roster.members(Task.SWARM, Task.HELD, Task.LOST)
    unable = {member.vehicle_id: refusal for member in members if (refusal := _refusal(member)) is not None}
    able = len(members) - len(unable)
    if able >= fewest:
        return
    reasons = "; ".join(f"vehicle {vehicle_id}: {refusal.text}" for vehicle_id, refusal in unable.items())
    raise MissionError(
        f"Cannot resume: the search needs {fewest} vehicles that follow the station, and has {able}"
        f"{reasons and f' ({reasons})'}. Return or land the vehicles, or resume when enough of them follow again."
    )


def doubtful_position(member: Member) -> Refusal | None:
    """Return why a vehicle stays held whose position its own sensors put in doubt; None if they do not."""
    problem = member.position_problem
    return Refusal(f"stays held: {problem}. Return it, land it, or resume it when that is over") if problem else None


def _refusal(member: Member) -> Refusal | None:
    """Return why a vehicle cannot go on in the swarm; None if it can, as from the ground before its take-off."""
    if member.task is Task.LOST:
        return Refusal("link lost")
    if (refusal := doubtful_position(member)) is not None:
        return refusal
    return member.why_not_ours if member.airborne else None


def not_ours(member: Member) -> Refusal:
    """Return why a vehicle cannot be given back to this station, by its present mode."""
    state = member.state
    if state.failsafe:
        return Refusal(f"does not follow this station: its failsafe is active ({state.failsafe})")
    return Refusal(f"does not follow this station: its mode is {state.mode_name or state.mode}")
