"""Whether enough vehicles are left for the search: which ones it waits for, and how it ends with too few."""

from __future__ import annotations

from collections.abc import Callable

from aos_gcs.errors import MissionFailedError
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.handler_watch import sign_of_life
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Severity

TAKE_OFF_S = 60.0
"""Time beside a change of batteries that a replacement has until it takes off, before the search ends without it."""
_POLL_S = 0.5


class SwarmStrength:
    """Gathers the swarm before each step, and ends a search whose vehicles have left because of their batteries.

    Args:
        context: context of the flight.
        covered_fraction: returns the share of the area that was in a frame.
        may_be_relieved: returns whether a vehicle on the ground may take off for the swarm, now or with another
            battery.
    """

    def __init__(
        self,
        context: FlightContext,
        *,
        covered_fraction: Callable[[], float | None],
        may_be_relieved: Callable[[], bool],
    ) -> None:
        self._context = context
        self._covered_fraction = covered_fraction
        self._may_be_relieved = may_be_relieved

    async def gather(self) -> list[Member]:
        """Return the swarm; with too few left, wait for lost vehicles, for replacements, and for those that are held.

        When all are lost, the monitor ends the mission. Empty where the batteries or the time have ended the search,
        which is reported: all vehicles return then.

        Raises:
            MissionFailedError: too few are left, and not because of their batteries.
        """
        context, began_s = self._context, self._context.clock.now_s()
        fewest = context.settings.fewest_vehicles
        while len(swarm := context.roster.members(Task.SWARM)) < fewest:
            if (awaited := self._awaited(swarm, context.clock.now_s() - began_s)) is None:
                return self._end(swarm, fewest)
            context.journal.set_message(awaited)
            sign_of_life()
            await context.clock.sleep(_POLL_S)
        return swarm

    def _awaited(self, swarm: list[Member], waited_s: float) -> str | None:
        """Return which vehicles a swarm that is too small waits for, in words; None if for none any more."""
        roster, settings = self._context.roster, self._context.settings
        lost = roster.members(Task.LOST)
        if lost and (not swarm or waited_s <= settings.deadlines.all_lost_s):
            return f"Waiting for {len(lost)} lost vehicles."
        # Somebody stopped them for a reason: they are not to be moved because they are missing.
        held = [member for member in roster.members(Task.HELD) if member.airborne and member.follows_us]
        if held and not self._is_time_over:
            return f"Waiting for {len(held)} held vehicles: resume them, or return all."
        if not swarm:
            return None  # a replacement flies to those that it joins
        is_in_time = waited_s <= settings.relay.swap_s + TAKE_OFF_S
        if roster.members(Task.JOINING) or (is_in_time and self._may_be_relieved()):
            return f"Waiting for a replacement: {len(swarm)} left in the swarm."
        return None

    @property
    def _is_time_over(self) -> bool:
        return self._context.journal.elapsed_s() > self._context.settings.deadlines.search_s

    def _end(self, swarm: list[Member], fewest: int) -> list[Member]:
        """Report that the search ends for its time or its batteries, and return nobody.

        Raises:
            MissionFailedError: the batteries are not what it lacks vehicles for.
        """
        roster = self._context.roster
        if self._is_time_over:
            self._context.journal.notice(Severity.WARNING, "Maximum search time reached: all vehicles return")
            return []
        empty = [one for one in roster.members() if one.left_for_battery and one.task is not Task.SWARM]
        if len(swarm) + len(empty) < fewest:
            lost = len(roster.members(Task.LOST))
            raise MissionFailedError(f"The swarm needs {fewest} vehicles, but has {len(swarm)} left and {lost} lost.")
        covered = self._covered_fraction() or 0.0
        reasons = "; ".join(f"vehicle {one.vehicle_id}: {one.left_for_battery}" for one in empty)
        self._context.journal.notice(
            Severity.WARNING,
            f"Search ended by the batteries: {len(swarm)} left in the swarm, {fewest} needed ({reasons}). "
            f"{100 * covered:.0f} % of the area was in a frame. All vehicles return",
        )
        return []
