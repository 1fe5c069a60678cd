"""Relay: vehicles on the ground take the places of those whose batteries run low, while the others fly on.

Only vehicles that are confirmed as ready take off, once per confirmation: people walk up to those on the ground.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.energy import CLIMB_MPS, time_home_s
from aos_gcs.mission.fleet.landing.return_and_land import ReturnAndLand
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.reinforcements.joining import Joining, Replacement
from aos_gcs.mission.fleet.reinforcements.relief_plan import relief_times_s
from aos_gcs.mission.fleet.reinforcements.replacements import Replacements
from aos_gcs.mission.model.actions import Refusal
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Severity

APART_S = 20.0
"""Shortest time between two planned reliefs."""
MARGIN_S = 20.0
"""Time before a vehicle has to leave at which it is to be relieved."""
_CHECKS_S = 15.0
"""Time that checks, arming and meeting the line take beside the flight."""
_AGAIN_S = 10.0
"""Time before a vehicle that could not take off is tried again."""
_ENDS_SOON_S = 60.0
"""Time by which a battery has to outlast the rest of the search for its vehicle to stay to the end."""
_ON_THE_WAY_BACK = (Task.RETURNING, Task.LANDING, Task.LANDED)
_PLANNED = (Task.SWARM, Task.JOINING, Task.HELD)
"""Tasks of vehicles whose places in the swarm are not free: those that are held may come back, as may lost ones that
had one of these tasks."""


class Relay:
    """Decides which vehicle is relieved when, and by which one.

    Args:
        context: context of the flight.
        joining: brings replacements.
        returning: sends relieved vehicles home.
        replacements: knows which vehicles on the ground may take off.
        search_left_s: returns how long the rest of the search takes; None while that is not known.
    """

    def __init__(
        self,
        context: FlightContext,
        joining: Joining,
        returning: ReturnAndLand,
        replacements: Replacements,
        *,
        search_left_s: Callable[[], float | None],
    ) -> None:
        self._context = context
        self._joining = joining
        self._returning = returning
        self._replacements = replacements
        self._search_left_s = search_left_s
        self._relieved: dict[int, Member] = {}
        """Vehicle that each replacement on its way is to relieve, by the replacement's id."""
        self._again_at_s: dict[int, float] = {}
        self._refused: dict[int, str] = {}
        """Reason that was reported last why a vehicle could not take off, by id."""

    def confirm(self, member: Member, *, is_ready: bool) -> Refusal | None:
        """Confirm that a vehicle may take off for the relay, or take that back."""
        if (refusal := self._replacements.confirm(member, is_ready=is_ready)) is not None:
            return refusal
        if not is_ready:
            # It may be among those that are being checked.
            self._joining.call_off()
        self._again_at_s.pop(member.vehicle_id, None)
        self._refused.pop(member.vehicle_id, None)
        return None

    # --- which one is relieved when -----------------------------------------------------------------------------------

    async def look(self, may_relieve: Callable[[], bool]) -> None:
        """Plan the reliefs, and begin one that is due.

        Args:
            may_relieve: returns whether the search goes on, so that vehicles may take off for it.
        """
        self._replacements.note_flights()
        roster = self._context.roster
        for vehicle_id in [key for key, _ in self._relieved.items() if not self._is_on_its_way(key)]:
            del self._relieved[vehicle_id]
        ready = [member for member in roster.members() if self._replacements.is_ready(member)]
        plan_s = self._plan_s(ready)
        for member in roster.members():
            member.leaves_in_s = plan_s.get(member.vehicle_id)
        now_s = self._context.clock.now_s()
        able = [member for member in ready if self._again_at_s.get(member.vehicle_id, now_s) <= now_s]
        if not may_relieve() or not able:
            return
        replacement = max(able, key=lambda member: member.state.battery_fraction or 0.0)
        coming_back = [one for one in roster.members(Task.LOST) if one.task_when_heard_again in _PLANNED]
        taken_places = len(roster.members(*_PLANNED)) + len(coming_back) - len(self._relieved)
        if taken_places < self._context.settings.vehicles:
            await self._begin(replacement, None, may_relieve)
            return
        due = [vehicle_id for vehicle_id, time_s in plan_s.items() if time_s <= self._way_out_s(vehicle_id)]
        taken = {member.vehicle_id for member in self._relieved.values()}
        if waiting := [vehicle_id for vehicle_id in due if vehicle_id not in taken]:
            (relieved,) = roster.select(waiting[:1])
            await self._begin(replacement, relieved, may_relieve)

    def _is_on_its_way(self, vehicle_id: int) -> bool:
        (member,) = self._context.roster.select([vehicle_id])
        return member.task is Task.JOINING and self._relieved[vehicle_id].task is Task.SWARM

    def _plan_s(self, ready: list[Member]) -> dict[int, float]:
        """Return the time until each vehicle of the swarm is to leave, by id; those that stay to the end are absent."""
        lasts_s = {
            member.vehicle_id: lasts_s
            for member in self._context.roster.members(Task.SWARM)
            if (lasts_s := self.lasts_s(member)) is not None
        }
        left_s = self._time_left_s()
        if left_s is not None:
            lasts_s = {key: last_s for key, last_s in lasts_s.items() if last_s < 1.1 * left_s + _ENDS_SOON_S}
        if not self._replacements.is_on:
            return relief_times_s(lasts_s, 0, 0.0, 0.0)
        back = [
            member
            for member in self._context.roster.members(*_ON_THE_WAY_BACK)
            if member.takes_part and not self._replacements.is_ready(member)
        ]
        replacements = len(ready) + len(back) + len(self._relieved)
        wanted_s = {key: last_s - MARGIN_S for key, last_s in lasts_s.items()} if replacements else lasts_s
        return relief_times_s(wanted_s, replacements, self._turnaround_s(), APART_S)

    def _time_left_s(self) -> float | None:
        """Return how long the search goes on: to the end of its legs, or of its time."""
        legs_s, journal = self._search_left_s(), self._context.journal
        until_s = max(0.0, self._context.settings.deadlines.search_s - journal.elapsed_s())
        return None if legs_s is None else min(legs_s, until_s)

    def lasts_s(self, member: Member) -> float | None:
        """Return how long a vehicle can stay before it has to leave for home; None while its discharge is not known."""
        limits, battery, per_s = self._context.bounds.limits, member.state.battery_fraction, member.battery.per_s
        if limits is None or battery is None or per_s is None:
            return None
        if per_s <= 0.0:
            return math.inf
        return max(0.0, (battery - limits.min_battery_fraction) / per_s - self.way_home_s(member))

    def way_home_s(self, member: Member) -> float:
        """Return the time that a vehicle's return takes, against the wind that is planned for; 0 if not known."""
        roster, settings = self._context.roster, self._context.settings
        position_enu_m, column_enu_m = roster.position_enu_m(member), roster.own_column_enu_m(member)
        if position_enu_m is None or member.home_enu_m is None:
            return 0.0
        return time_home_s(
            position_enu_m,
            member.home_enu_m,
            settings.flight.cruise_speed_mps,
            layer_up_m=-math.inf if column_enu_m is None else float(column_enu_m[2]),
            wind_mps=settings.relay.wind_mps,
        )

    def _way_out_s(self, vehicle_id: int) -> float:
        """Return the time from a take-off until a vehicle's place in the line is taken over."""
        (member,) = self._context.roster.select([vehicle_id])
        position_enu_m = self._context.roster.position_enu_m(member)
        if position_enu_m is None or member.home_enu_m is None:
            return _CHECKS_S
        flight = self._context.settings.flight
        up_m = float(position_enu_m[2] - member.home_enu_m[2])
        beside_m = float(np.hypot(*(position_enu_m - member.home_enu_m)[:2]))
        # Those that fly away at the search speed are met later.
        closing_mps = max(0.25 * flight.cruise_speed_mps, flight.cruise_speed_mps - flight.leg_speed_mps)
        return _CHECKS_S + up_m / CLIMB_MPS + beside_m / closing_mps

    def _turnaround_s(self) -> float:
        members = self._context.roster.members(Task.SWARM)
        home_s = max(map(self.way_home_s, members), default=0.0)
        out_s = max((self._way_out_s(member.vehicle_id) for member in members), default=0.0)
        return home_s + self._context.settings.relay.swap_s + out_s

    # --- a replacement ------------------------------------------------------------------------------------------------

    async def _begin(self, member: Member, relieved: Member | None, may_relieve: Callable[[], bool]) -> None:
        """Have a confirmed vehicle take off, to relieve another one or to fill a gap."""
        if relieved is not None:
            self._relieved[member.vehicle_id] = relieved
        replacement = Replacement(
            relieved=relieved,
            may_start=lambda: may_relieve() and self._replacements.is_ready(member),
            on_joined=lambda: self._hand_over(member),
        )
        refusal = await self._joining.join(member, self._joining.order(may_relieve), replacement)
        if refusal is None:
            self._replacements.use(member)
            self._refused.pop(member.vehicle_id, None)
            return
        self._relieved.pop(member.vehicle_id, None)
        self._again_at_s[member.vehicle_id] = self._context.clock.now_s() + _AGAIN_S
        if self._refused.get(member.vehicle_id) != refusal.text:
            self._refused[member.vehicle_id] = refusal.text
            text = f"cannot take off for the relay: {refusal.text}"
            self._context.journal.notice(Severity.WARNING, text, member.vehicle_id)

    async def _hand_over(self, member: Member) -> None:
        """Send the vehicle home whose place another one has just taken."""
        relieved = self._relieved.pop(member.vehicle_id, None)
        if relieved is not None and relieved.task is Task.SWARM and relieved.follows_us:
            reason = f"vehicle {member.vehicle_id} takes its place"
            await self._returning.send_home(relieved, reason, Severity.INFO)
