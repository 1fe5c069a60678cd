"""Monitors the links: which vehicles are lost, and what those do that are heard again."""

from __future__ import annotations

from typing import Final

from aos_gcs.mission.fleet.roster import FLYING, Member, Roster
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Clock, Severity

REJOIN_S: Final = 30.0
"""Longest silence after which a vehicle goes on in the swarm by itself; by then most failsafes have acted."""

_LATE_S: Final = 2.0
"""Delay of messages from which the station, or the link, is too slow for them."""
_AFTERWARDS_S: Final = 5.0
"""Time before the last message within which a stall of the station may have to do with it."""


class LinkWatch:
    """Reports vehicles that are lost or heard again, and decides about their tasks."""

    def __init__(self, roster: Roster, clock: Clock, journal: Journal) -> None:
        self._roster = roster
        self._clock = clock
        self._journal = journal
        self._silent_since_s: dict[int, float] = {}
        """Time of the last message of each vehicle before it was lost."""

    def look(self, member: Member, lost_s: float) -> None:
        """Note whether a vehicle is heard; ``lost_s`` is the silence after which it is lost."""
        heard_at_s, age_s = member.state.heard_at_s, self._roster.link_age_s(member)
        if heard_at_s is None or age_s is None:
            return
        if age_s > lost_s:
            if member.task in FLYING:
                self._lose(member, heard_at_s, age_s)
        elif member.task is Task.LOST and self._reports_its_mode(member):
            self._hear_again(member, self._clock.now_s() - self._silent_since_s[member.vehicle_id])

    def _lose(self, member: Member, heard_at_s: float, age_s: float) -> None:
        self._silent_since_s[member.vehicle_id] = heard_at_s
        self._roster.assign(member, Task.LOST)
        text = f"link lost for {age_s:.0f} s: its own failsafe flies it now. Check its link"
        if stall_s := self._journal.stalled_s(age_s + _AFTERWARDS_S):
            text += f". This station stood still for {stall_s:.1f} s meanwhile: its own overload may be the cause"
        elif (link := member.state.link) is not None and link.telemetry_delay_s > _LATE_S:
            late_s = link.telemetry_delay_s
            text += f". Its messages arrive {late_s:.0f} s late: this station or the link may be overloaded"
        self._journal.notice(Severity.CRITICAL, text, member.vehicle_id)

    def _reports_its_mode(self, member: Member) -> bool:
        """Return whether a heartbeat has arrived since the loss: until then its mode is the one before it."""
        reported_at_s = member.state.armed_at_s
        return reported_at_s is not None and reported_at_s > self._silent_since_s[member.vehicle_id]

    def _hear_again(self, member: Member, silent_s: float) -> None:
        """Give a vehicle its task again; it rejoins only where nothing else can have flown it meanwhile."""
        task, severity, text = member.task_when_heard_again, Severity.WARNING, "link restored"
        if task is Task.SWARM and not member.follows_us:
            task, severity = Task.HELD, Severity.CRITICAL
            text += f", but it left the swarm: {member.why_not_ours}. It is left alone until it is resumed"
        elif task is Task.SWARM and silent_s > REJOIN_S:
            task = Task.HELD
            text += f" after {silent_s:.0f} s: it waits outside of the swarm. Resume it, or return it"
        elif task is Task.SWARM:
            text += f" after {silent_s:.0f} s: it goes on in the swarm"
        self._roster.assign(member, task)
        self._journal.notice(severity, text, member.vehicle_id)
