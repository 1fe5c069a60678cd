"""What an operator's *Resume* needs: a swarm to go on with."""

from __future__ import annotations

from aos_gcs.errors import MissionError
from aos_gcs.mission.fleet.roster import Member, Roster
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import MIN_SWARM


def check_resume(roster: Roster) -> None:
    """Check that a suspended search has a swarm to go on with: without one it would end, and land all.

    Raises:
        MissionError: too few vehicles can be resumed now; those that come back can be later.
    """
    members = roster.members(Task.SWARM, Task.HELD, Task.LOST)
    unable = {member.vehicle_id: _why_unable(member) for member in members}
    able = sum(not reason for reason in unable.values())
    if able >= MIN_SWARM:
        return
    reasons = "; ".join(f"vehicle {vehicle_id}: {reason}" for vehicle_id, reason in unable.items() if reason)
    raise MissionError(
        f"Cannot resume: a swarm needs {MIN_SWARM} vehicles that follow the station, and has {able}"
        f"{reasons and f' ({reasons})'}. Return or land the vehicles, or resume when enough of them follow again."
    )


def _why_unable(member: Member) -> str:
    """Return why a vehicle cannot go on in the swarm; empty if it can, as from the ground before its take-off."""
    if member.task is Task.LOST:
        return "link lost"
    return member.why_not_ours if member.airborne else ""
