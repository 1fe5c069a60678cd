"""Monitors the links: which vehicles are lost, and what those do that are heard again."""

from __future__ import annotations

import math
from typing import Final

from aos_gcs.mission.fleet.member import FLYING, Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.health import Punctuality
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Clock, Severity

REJOIN_S: Final = 30.0
"""Longest silence after which a vehicle goes on in the swarm by itself; by then most failsafes have acted."""

RESTORED_AFTER_S: Final = 3.0
"""Time for which a lost link has to be good before it counts as restored."""
LONGEST_DOUBT_S: Final = 12.0
"""The same at most: it doubles with each loss soon after the link was restored."""
_SOON_S: Final = 60.0
_GAP_S: Final = 2.0
"""Silence that ends a good link: two heartbeats."""

_LATE_S: Final = 2.0
"""Delay of messages from which the station, or the link, is too slow for them."""
_AFTERWARDS_S: Final = 5.0
"""Time before the last message within which a stall of the station may have to do with it."""


class LinkWatch:
    """Reports vehicles that are lost or heard again, and decides about their tasks.

    Args:
        roster: the vehicles.
        clock: the service's clock.
        journal: told what happens to links.
        punctuality: how late this station is itself.
    """

    def __init__(self, roster: Roster, clock: Clock, journal: Journal, punctuality: Punctuality) -> None:
        self._roster = roster
        self._clock = clock
        self._journal = journal
        self._punctuality = punctuality
        self._silent_since_s: dict[int, float] = {}
        """Time of the last message of each vehicle before it was lost."""
        self._restored_at_s: dict[int, float] = {}
        self._doubt_s: dict[int, float] = {}
        """Time for which the link of each lost vehicle has to be good."""

    def look(self, member: Member, lost_s: float, *, is_over: bool = False) -> None:
        """Note whether a vehicle is heard.

        Args:
            member: the vehicle.
            lost_s: silence after which it is lost.
            is_over: the mission has ended: there is no swarm that it could go on in.
        """
        heard_at_s, age_s = member.state.heard_at_s, self._roster.link_age_s(member)
        if heard_at_s is None or age_s is None:
            return
        if age_s > lost_s and member.task in FLYING:
            self._lose(member, heard_at_s, age_s)
        elif member.task is Task.LOST:
            self._watch_lost(member, heard_at_s, age_s, is_over=is_over)
        elif member.heard_again_at_s is not None:  # an operator has commanded it meanwhile
            self._end_loss(member)
            self._journal.notice(Severity.WARNING, "link restored", member.vehicle_id)

    def _watch_lost(self, member: Member, heard_at_s: float, age_s: float, *, is_over: bool) -> None:
        """Give a lost vehicle its task again once it has been heard for long enough."""
        vehicle_id = member.vehicle_id
        if age_s > _GAP_S or not self._reports_its_mode(member):
            member.heard_again_at_s = None
        elif member.heard_again_at_s is None:
            member.heard_again_at_s = heard_at_s
        elif heard_at_s - member.heard_again_at_s >= self._doubt_s[vehicle_id]:
            silent_s = member.heard_again_at_s - self._silent_since_s[vehicle_id]
            self._end_loss(member)
            self._hear_again(member, silent_s, is_over=is_over)

    def _end_loss(self, member: Member) -> None:
        member.heard_again_at_s = None
        self._restored_at_s[member.vehicle_id] = self._clock.now_s()

    def _lose(self, member: Member, heard_at_s: float, age_s: float) -> None:
        vehicle_id, now_s = member.vehicle_id, self._clock.now_s()
        is_again = now_s - self._restored_at_s.get(vehicle_id, -math.inf) <= _SOON_S
        doubt_s = 2.0 * self._doubt_s[vehicle_id] if is_again else RESTORED_AFTER_S
        self._doubt_s[vehicle_id] = min(doubt_s, LONGEST_DOUBT_S)
        self._silent_since_s[vehicle_id] = heard_at_s
        member.heard_again_at_s = None
        self._roster.assign(member, Task.LOST)
        text = f"link lost for {age_s:.0f} s: its own failsafe flies it now. Check its link"
        if stall_s := self._journal.stalled_s(age_s + _AFTERWARDS_S):
            text += f". This station was unresponsive for {stall_s:.1f} s meanwhile: its own overload may be the cause"
        elif self._punctuality.is_poor:
            text += ". This station is overloaded, which may be the cause: close other programs on this computer"
        elif (link := member.state.link) is not None and link.telemetry_delay_s > _LATE_S:
            late_s = link.telemetry_delay_s
            text += f". Its messages arrive {late_s:.0f} s late: this station or the link may be overloaded"
        self._journal.notice(Severity.CRITICAL, text, vehicle_id)

    def _reports_its_mode(self, member: Member) -> bool:
        """Return whether a heartbeat has arrived since the loss: until then its mode is the one before it."""
        reported_at_s = member.state.armed_at_s
        return reported_at_s is not None and reported_at_s > self._silent_since_s[member.vehicle_id]

    def _hear_again(self, member: Member, silent_s: float, *, is_over: bool) -> None:
        """Give a vehicle its task again; it rejoins only where nothing else can have flown it meanwhile."""
        task, severity, text = member.task_when_heard_again, Severity.WARNING, "link restored"
        if task is Task.SWARM and (refusal := member.why_not_ours) is not None:
            task, severity = Task.HELD, Severity.CRITICAL
            text += f", but it left the swarm: {refusal.text}. It is left alone until it is resumed"
        elif is_over and task is Task.HELD and member.is_held_by_order:
            severity = Severity.CRITICAL
            text += (
                f" after {silent_s:.0f} s: it hovers, as an operator has ordered, and the mission is over. Return it"
            )
        elif is_over and task in {Task.SWARM, Task.HELD} and member.follows_us:
            task = Task.HELD
            text += f" after {silent_s:.0f} s: the mission is over, so it is led home"
        elif task is Task.SWARM and silent_s > REJOIN_S:
            task = Task.HELD
            text += f" after {silent_s:.0f} s: it waits outside of the swarm. Resume it, or return it"
        elif task is Task.SWARM:
            text += f" after {silent_s:.0f} s: it goes on in the swarm"
        self._roster.assign(member, task)
        self._journal.notice(severity, text, member.vehicle_id)
