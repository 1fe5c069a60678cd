"""Vehicles on the ground that may take the places of others: those that are confirmed, each for one take-off."""

from __future__ import annotations

from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.model.actions import Refusal
from aos_gcs.mission.model.vehicles import TASK_NAMES, Task
from aos_gcs.ports import Severity


class Replacements:
    """Knows which vehicles on the ground may take off: people walk up to them.

    Args:
        context: context of the flight.
        trusts_names: whether vehicles that the plan names count as confirmed until they have flown; not after a
            restart.
    """

    def __init__(self, context: FlightContext, *, trusts_names: bool = True) -> None:
        self._context = context
        self._trusts_names = trusts_names
        self._down_since_s: dict[int, float] = {}

    @property
    def is_on(self) -> bool:
        """Whether any vehicle may take the place of another."""
        return self._context.settings.relay.enabled or any(
            member.is_ready is not None for member in self._context.roster.members()
        )

    @property
    def _is_simulated(self) -> bool:
        settings = self._context.settings
        return settings.any_vehicles and settings.relay.enabled

    def is_ready(self, member: Member) -> bool:
        """Return whether a vehicle on the ground is confirmed: a new battery, and nobody near it."""
        if member.task not in {Task.IDLE, Task.LANDED} or member.airborne:
            return False
        if member.is_ready is not None:
            return member.is_ready
        is_named = self._is_simulated or member.vehicle_id in self._context.settings.relay.vehicle_ids
        return member.task is Task.IDLE and not member.is_chosen and self._trusts_names and is_named

    def is_waited_for(self, member: Member) -> bool:
        """Return whether the relay waits for a vehicle on the ground, or for the confirmation that it is ready."""
        waits = member.task in {Task.IDLE, Task.LANDED} and not member.airborne
        return waits and self.is_on and (member.task is Task.LANDED or not member.is_chosen)

    def may_any_take_off(self) -> bool:
        """Return whether a vehicle on the ground may take off for the swarm, now or with another battery."""
        return any(self.is_ready(member) or self.is_waited_for(member) for member in self._context.roster.members())

    def confirm(self, member: Member, *, is_ready: bool) -> Refusal | None:
        """Confirm that a vehicle may take off for the relay, or take that back."""
        if is_ready and (member.airborne or member.state.armed):
            return Refusal("is not on the ground with stopped motors")
        if is_ready and member.task not in {Task.IDLE, Task.LANDED}:
            return Refusal(f"is part of the mission already ({TASK_NAMES[member.task]})")
        if not is_ready and (member.airborne or member.task is Task.JOINING):
            return Refusal("has taken off, or is about to: hold, return or land it")
        member.is_ready = is_ready
        return None

    def use(self, member: Member) -> None:
        """Let the confirmation of a vehicle count for the take-off that it begins, and for no other."""
        member.is_ready = False

    def note_flights(self) -> None:
        """Let each confirmation count for one take-off; in a simulation batteries are changed after a time."""
        now_s, relay = self._context.clock.now_s(), self._context.settings.relay
        for member in self._context.roster.members():
            if member.airborne or member.task is Task.JOINING:
                if member.is_ready or self.is_on:
                    self.use(member)
                self._down_since_s.pop(member.vehicle_id, None)
            elif (
                member.task is Task.LANDED
                and self._is_simulated
                and not member.is_ready
                and now_s - self._down_since_s.setdefault(member.vehicle_id, now_s) >= relay.swap_s
            ):
                member.is_ready = True
                text = "has another battery, and is ready to relieve others (simulated)"
                self._context.journal.notice(Severity.INFO, text, member.vehicle_id)
