"""A vehicle on the ground joins the swarm in mid-mission: it is checked, given a free layer, and flown there."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass

from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.member import FLYING, Member
from aos_gcs.mission.fleet.reinforcements.approach import Approach
from aos_gcs.mission.fleet.reinforcements.launch_place import find_launch_place, moved_home
from aos_gcs.mission.fleet.vehicle_tasks import VehicleTasks
from aos_gcs.mission.model.actions import Refusal
from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.model.vehicles import TASK_NAMES, Task
from aos_gcs.mission.preflight.inspection import Inspector
from aos_gcs.ports import Arm, Disarm, Severity, Takeoff

Check = Callable[[Member], Awaitable[Sequence[PreflightCheck]]]
"""Function that returns the preflight checks of one vehicle, as they are now."""
_NOT_STARTED = frozenset({Task.JOINING, Task.LOST})
Order = Callable[[], bool]
"""Function that returns whether an order to join still holds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Replacement:
    """Purpose of a vehicle that joins for the relay."""

    relieved: Member | None
    """Vehicle whose place it takes; None: it fills a gap."""
    may_start: Callable[[], bool]
    """Returns whether it may still take off, once its checks are done."""
    on_joined: Callable[[], Awaitable[None]]
    """Called as soon as it is part of the swarm."""


class Joining:
    """Flies replacements to the swarm: up in a column of their own, then in an altitude layer of their own."""

    def __init__(self, context: FlightContext, vehicle_tasks: VehicleTasks, inspector: Inspector, check: Check) -> None:
        self._context = context
        self._vehicle_tasks = vehicle_tasks
        self._inspector = inspector
        self._check = check
        self._approach = Approach(context)
        self._one_at_a_time = asyncio.Lock()
        self._calls_off = 0

    def candidates(self) -> list[Member]:
        """Return the vehicles of the mission on the ground that could join; any other has to be named."""
        members = self._context.roster.chosen(Task.IDLE, Task.LANDED)
        return [member for member in members if not member.airborne]

    def call_off(self) -> None:
        """Let no vehicle start that is ordered to join but has not taken off, such as after a hold of all."""
        self._calls_off += 1

    def order(self, is_allowed: Callable[[], bool]) -> Order:
        """Return the order to join that is given now, to one vehicle or several: it holds until it is called off.

        Args:
            is_allowed: returns whether the mission is in a state in which vehicles may take off.
        """
        calls_off = self._calls_off
        return lambda: self._calls_off == calls_off and is_allowed()

    async def join(self, member: Member, order: Order, replacement: Replacement | None = None) -> Refusal | None:
        """Have a vehicle take off and fly to the swarm; that goes on in the background.

        It does not start when ``order``, which was given before any vehicle was waited for, holds no longer.
        """
        async with self._one_at_a_time:
            # Two that are checked at the same time would be given the same layer.
            return await self._join(member, order, replacement)

    async def _join(self, member: Member, order: Order, replacement: Replacement | None) -> Refusal | None:
        if not order():
            return Refusal("was called off before it started")
        if member.task not in {Task.IDLE, Task.LANDED} or member.airborne:
            return Refusal(f"is part of the mission already ({TASK_NAMES[member.task]})")
        roster, former_enu_m, former_ground = self._context.roster, member.home_enu_m, self._context.roster.ground
        refusal = self._find_place(member) or await self._clear(member, order, replacement)
        if refusal is not None:
            # It is still where it landed, away from the launch point that it had.
            member.move_home(former_enu_m)
            roster.ground = former_ground
            return refusal
        roster.assign(member, Task.JOINING)
        text = f"joins the swarm: it climbs to its layer at {member.layer_height_m:.0f} m and flies there"
        self._context.journal.notice(Severity.INFO, text, member.vehicle_id)
        self._vehicle_tasks.start(member.vehicle_id, self._bring(member, order, replacement))
        return None

    async def _clear(self, member: Member, order: Order, replacement: Replacement | None) -> Refusal | None:
        """Return why a vehicle with a launch point and a layer must not start; None if it may."""
        await self._inspector.settle(member)
        blocking = [check for check in await self._check(member) if check.blocks]
        if not order() or not (replacement is None or replacement.may_start()):
            return Refusal("was called off before it started")
        if blocking:
            return Refusal(blocking[0].describe())
        return self._why_no_climb(member)

    def _find_place(self, member: Member) -> Refusal | None:
        """Give the vehicle its launch point and the lowest free layer."""
        context, limits, roster = self._context, self._context.bounds.limits, self._context.roster
        home_enu_m = find_launch_place(context, member)
        if isinstance(home_enu_m, Refusal):
            return home_enu_m
        if limits is None:
            return Refusal("its home position is not known yet")
        if roster.layers.surface is None:
            return Refusal("the elevation model that its altitude layer follows is not loaded")
        for boundary in limits.boundaries():
            if boundary.depth_m(home_enu_m[:2]) <= 0.0:
                return Refusal(f"its launch point lies on the wrong side of {boundary.name}")
        layer_height_m = self._free_layer_m(member, limits.ceiling_m - roster.layers.surface.highest_m)
        if layer_height_m is None:
            return Refusal(f"no altitude layer is free below the ceiling at {limits.ceiling_m:.0f} m")
        for other in context.roster.members(Task.IDLE, Task.LANDED):
            if other is not member and not other.airborne and other.layer_height_m == layer_height_m:
                other.give_up_layer()
        member.take_place(home_enu_m, layer_height_m)
        roster.settle_altitudes()
        return None

    def _free_layer_m(self, member: Member, highest_m: float) -> float | None:
        """Return the lowest layer, up to a height, that no vehicle in the air has, such as one that left the swarm."""
        flight = self._context.settings.flight
        taken_m = [
            other.layer_height_m
            for other in self._context.roster.members(*FLYING, Task.LOST)
            if other is not member and other.layer_height_m is not None
        ]
        layer_height_m = flight.lowest_layer_m
        while layer_height_m <= highest_m:
            if all(abs(layer_height_m - other_m) > 0.5 * flight.layer_spacing_m for other_m in taken_m):
                return layer_height_m
            layer_height_m += flight.layer_spacing_m
        return None

    def _why_no_climb(self, member: Member) -> Refusal | None:
        """Return why a vehicle must not climb to its layer from where it stands now; None if it may."""
        here_enu_m = self._context.roster.position_enu_m(member)
        top_enu_m = self._context.roster.layers.at(member, here_enu_m)
        if here_enu_m is None or top_enu_m is None:
            raise RuntimeError(f"vehicle {member.vehicle_id} has no position or no altitude layer")
        if (other_id := self._context.flight.blocks_path(member, here_enu_m, top_enu_m)) is not None:
            return Refusal(f"vehicle {other_id} is or may come above its launch point: try again when it has passed")
        return self._context.flight.vet_climbs([member]).get(member.vehicle_id)

    async def _bring(self, member: Member, order: Order, replacement: Replacement | None) -> None:
        """Start, climb, fly to the swarm and become part of it; a vehicle that does not get there holds where it is."""
        context, assumed_offset_m = self._context, member.altitude_offset_m
        if not order():
            text = "stays on the ground: it was called off before it started"
            context.journal.notice(Severity.WARNING, text, member.vehicle_id)
            self._release(member)
            return
        if await context.flight.command(member, Arm()) is not None:
            self._release(member)
            return
        refusal = await moved_home(context, member, assumed_offset_m) or self._why_no_climb(member)
        if not order():
            refusal = Refusal("it was called off before it started")
        if refusal is not None or member.task is not Task.JOINING:
            await self._stay(member, refusal)
            return
        if (height_m := context.roster.layers.above_home_m(member)) is None:
            raise RuntimeError(f"vehicle {member.vehicle_id} has no altitude layer")
        refusal = await context.flight.command(member, Takeoff(height_m), context.settings.deadlines.takeoff_s)
        if refusal is not None and not member.airborne:
            await self._stay(member)
            return

        def those_ahead() -> list[Member]:
            """Return the vehicle that is to be relieved while it is part of the swarm, or else all of that."""
            swarm = context.roster.members(Task.SWARM)
            return [other for other in swarm if replacement is not None and other is replacement.relieved] or swarm

        has_come = await self._approach.fly(member, those_ahead)
        if member.task is not Task.JOINING:
            return
        context.roster.assign(member, Task.SWARM if has_come else Task.HELD)
        if has_come and replacement is not None:
            await replacement.on_joined()
        severity, text = (
            (Severity.INFO, "has joined the swarm")
            if has_come
            else (Severity.WARNING, "did not reach the swarm in time. Resume it to have it follow, or return it")
        )
        context.journal.notice(severity, text, member.vehicle_id)

    async def _stay(self, member: Member, refusal: Refusal | None = None) -> None:
        """Stop the motors of a vehicle that has not taken off; report why where that is not known yet."""
        if refusal is not None:
            self._context.journal.notice(Severity.WARNING, f"stays on the ground: {refusal.text}", member.vehicle_id)
        if member.task in _NOT_STARTED:
            await self._context.flight.command(member, Disarm())
        self._release(member)

    def _release(self, member: Member) -> None:
        """Let a vehicle that has not taken off wait again, unless it has got another task meanwhile."""
        if member.task in _NOT_STARTED:
            self._context.roster.assign(member, Task.IDLE)
