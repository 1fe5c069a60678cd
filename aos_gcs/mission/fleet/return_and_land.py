"""Bringing everybody down: the phases RETURN and LAND, and single vehicles that leave the swarm."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.spacing import landing_spots, spread_apart
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.roster import Member
from aos_gcs.mission.fleet.vehicle_tasks import Errands
from aos_gcs.mission.model import Outcome, Phase, Task
from aos_gcs.ports import Arm, Command, Disarm, FlightMode, Land, ReturnToLaunch, Severity

_COMING_DOWN = frozenset({FlightMode.RETURN, FlightMode.LAND})
_LAND_ATTEMPTS = 3
_POLL_S = 0.2
_SPOTS_APART = 2.0
"""Distance of two landing spots about a return point, in separations: both may err by half of one."""


class Homing:
    """The way down. Every handler can be entered again after an interruption."""

    def __init__(self, context: FlightContext, errands: Errands) -> None:
        self._context = context
        self._errands = errands
        self.leads_all = False
        """Whether the whole mission is on its way down, so that nobody is led alone."""

    async def return_home(self) -> Phase:
        """Fly all to where they land, each in its own altitude layer, before anyone descends.

        In the layers nobody's way crosses another's; the autopilots' own return would let early ones descend through
        the layers of those still on the way. Who is below its layer climbs straight up first. Who cannot be led home
        like that is handed to its autopilot; who is coming down already or is flown by a pilot is left alone.
        """
        context = self._context
        self._lead_all()
        context.message = "Returning: flying home in the altitude layers."
        led = [member for member in self._still_flying() if self._can_be_led(member)]
        for member in led:
            context.roster.assign(member, Task.RETURNING)
        await self._fly(led, self._climb)
        await self._fly(led, self._above_home)
        await self._fetch_the_held()
        astray = [member for member in self._still_flying() if member.airborne and self._is_astray(member)]
        for member in astray:
            context.journal.notice(Severity.WARNING, "handed to its autopilot's own return", member.vehicle_id)
        await context.flight.command_each(astray, lambda _: ReturnToLaunch())
        return Phase.LAND

    async def land(self) -> Phase:
        """Land all where they are, once nobody hovers above another, and wait until their motors stand still."""
        context = self._context
        self._lead_all()
        context.message = "Landing."
        await self._clear_columns()
        for member in self._still_flying():
            if member.follows_us:
                context.roster.assign(member, Task.LANDING)
        self._name_pilots()
        await self._bring_down()
        if await self._lost_ones_come_back():
            await self._bring_down()
        self._account()
        return Phase.DONE

    async def _bring_down(self) -> None:
        """Command everybody down, again where that was not done, until all have landed or the deadline has passed."""
        context = self._context
        for _ in range(_LAND_ATTEMPTS):
            hovering = [member for member in self._still_flying() if self._waits_for_us(member)]
            await context.flight.command_each(hovering, self._down)
            timeout_s = context.settings.deadlines.land_s / _LAND_ATTEMPTS
            if not await context.flight.wait_until(self._not_landed, lambda _: False, timeout_s):
                break

    async def _lost_ones_come_back(self) -> bool:
        """Return whether a lost vehicle is heard again soon. When all are lost, the monitor ends the mission first."""
        roster = self._context.roster
        lost = roster.members(Task.LOST)
        patience_s = 2 * self._context.settings.deadlines.all_lost_s
        left = await self._context.flight.wait_until(lambda: roster.members(Task.LOST), lambda _: False, patience_s)
        return len(left) < len(lost)

    async def send_home(self, member: Member, reason: str) -> str | None:
        """Have one vehicle leave the swarm; return why it does not, if so.

        It is led home in its own layer, where nobody else flies, and lands once the column below it is free. Who cannot
        be led is handed to its autopilot's own return.
        """
        self._context.journal.notice(Severity.WARNING, f"returns alone: {reason}", member.vehicle_id)
        if self._can_be_led(member):
            self._context.roster.assign(member, Task.RETURNING)
            self._errands.start(member.vehicle_id, self._lead_home(member))
            return None
        return await self._hand_over(member)

    def let_go(self, member: Member) -> None:
        """Lead a vehicle no further; what it was told last remains."""
        self._errands.stop(member.vehicle_id)

    def is_led(self, member: Member) -> bool:
        """Whether a vehicle is on an errand of its own, such as the way home."""
        return self._errands.is_out(member.vehicle_id)

    def _lead_all(self) -> None:
        self.leads_all = True
        self._errands.stop_all()

    async def _lead_home(self, member: Member) -> None:
        """Fly one vehicle home and land it, unless it is told something else or is taken over on the way."""
        context = self._context
        await self._fly([member], self._climb)
        await self._fly([member], self._above_home)
        if member.task is not Task.RETURNING or not member.follows_us:
            return
        if self._is_astray(member):
            await self._hand_over(member)
            return
        while (other_id := context.flight.in_the_way_down(member)) is not None:
            member.refusal = f"held: vehicle {other_id} may come below it"
            await context.clock.sleep(_POLL_S)
        if member.task is Task.RETURNING and member.follows_us:
            context.roster.assign(member, Task.LANDING)
            await context.flight.command(member, Land())

    async def _hand_over(self, member: Member) -> str | None:
        roster = self._context.roster
        roster.assign(member, Task.RETURNING)
        command = ReturnToLaunch()
        refusal = await self._context.flight.command(member, command)
        if refusal is not None and member.last_command in (None, command):
            roster.assign(member, Task.HELD)
        return refusal

    async def _fetch_the_held(self) -> None:
        """Lead home who was held on the way, such as for the sake of the separation, once the others are there."""
        held = [m for m in self._context.roster.members(Task.HELD) if self._can_be_led(m)]
        for member in held:
            self._context.roster.assign(member, Task.RETURNING)
        await self._fly(held, self._climb)
        await self._fly(held, self._above_home)

    def _still_flying(self) -> list[Member]:
        return [
            member
            for member in self._context.roster.members()
            if member.task not in {Task.LOST, Task.LANDED}
            # Who was told to arm may be about to.
            and (member.state.armed or isinstance(member.last_command, Arm))
        ]

    def _not_landed(self) -> list[Member]:
        """Return who still flies, or has stopped its motors but has not said yet that it stands on the ground."""
        coming_down = self._context.roster.members(Task.HELD, Task.RETURNING, Task.LANDING)
        return list({member.vehicle_id: member for member in (*self._still_flying(), *coming_down)}.values())

    @staticmethod
    def _waits_for_us(member: Member) -> bool:
        """Whether a vehicle that has come down, or would not come down by itself, is ours to command."""
        return member.follows_us or (member.state.mode in _COMING_DOWN and not member.airborne)

    @staticmethod
    def _can_be_led(member: Member) -> bool:
        has_place = member.home_enu_m is not None and member.layer_height_m is not None
        return member.airborne and member.follows_us and has_place

    def _is_astray(self, member: Member) -> bool:
        """Whether a vehicle follows us and hovers anywhere but above its launch point, such as one heard again."""
        place_enu_m = self._above_home(member)
        return member.follows_us and (place_enu_m is None or not self._context.flight.is_at(member, place_enu_m))

    async def _fly(self, members: list[Member], place_of: Callable[[Member], NDArray[np.float64] | None]) -> None:
        requests = {m.vehicle_id: place_enu_m for m in members if (place_enu_m := place_of(m)) is not None}
        await self._context.flight.transfer(requests, frozenset({Task.RETURNING}), homing=True)

    def _climb(self, member: Member) -> NDArray[np.float64] | None:
        roster = self._context.roster
        return None if roster.is_in_layer(member) else roster.own_column_enu_m(member)

    def _above_home(self, member: Member) -> NDArray[np.float64] | None:
        """Return the place in its layer above where a vehicle is to land; None if that is not known."""
        place_enu_m = self._landing_place(member)
        if place_enu_m is None or member.layer_height_m is None:
            return None
        return np.array([*place_enu_m[:2], member.layer_height_m])

    def _landing_place(self, member: Member) -> NDArray[np.float64] | None:
        """Return a vehicle's launch point, or else its own spot about the mission's return point."""
        context, home_enu_m = self._context, member.home_enu_m
        centre_enu_m, limits = context.settings.return_enu_m, context.flight.limits
        if centre_enu_m is None or home_enu_m is None or limits is None:
            return home_enu_m
        if member.landing_enu_m is None:
            members = context.roster.members()
            taken = [tuple(m.landing_enu_m[:2]) for m in members if m.landing_enu_m is not None]
            spacing_m = _SPOTS_APART * limits.separation_m
            spots_m = landing_spots(centre_enu_m, len(members), spacing_m)
            free_m = next(spot_m for spot_m in spots_m if tuple(spot_m) not in taken)
            member.landing_enu_m = np.array([*free_m, home_enu_m[2]])
        return member.landing_enu_m

    def _name_pilots(self) -> None:
        for member in self._still_flying():
            if not member.follows_us and member.state.mode not in _COMING_DOWN:
                mode = member.state.mode_name or member.state.mode
                self._context.journal.notice(
                    Severity.WARNING,
                    f"is flown by its pilot (mode {mode}) and has to be landed by them",
                    member.vehicle_id,
                )

    @staticmethod
    def _down(member: Member) -> Command:
        """On the ground with running motors, such as after an abort while arming, landing means disarming.

        Who was lost when the others were led to where they land is somewhere else, and is sent home.
        """
        if not member.airborne:
            return Disarm()
        return Land() if member.task is Task.LANDING else ReturnToLaunch()

    async def _clear_columns(self) -> None:
        """Move vehicles that hover above one another apart, in their layers, before they descend."""
        context = self._context
        limits = context.flight.limits
        members = [member for member in context.roster.airborne() if member.follows_us]
        located = [(m, p) for m in members if (p := context.roster.position_enu_m(m)) is not None]
        if limits is None or len(located) < 2:
            return
        positions_enu_m = np.array([position for _, position in located])
        apart_enu_m = spread_apart(positions_enu_m, limits.separation_m)
        if np.array_equal(apart_enu_m, positions_enu_m):
            return
        context.message = "Landing: moving apart first."
        for member, _ in located:
            context.roster.assign(member, Task.LANDING)
        requests = {member.vehicle_id: target for (member, _), target in zip(located, apart_enu_m, strict=True)}
        await context.flight.transfer(requests, frozenset({Task.LANDING}), homing=True)

    def _account(self) -> None:
        context = self._context
        for member in self._not_landed():
            context.journal.notice(Severity.CRITICAL, "has not reported that it landed", member.vehicle_id)
        lost = context.roster.members(Task.LOST)
        for member in lost:
            context.journal.notice(Severity.CRITICAL, "is lost; its own failsafe brings it down", member.vehicle_id)
        if context.outcome is Outcome.OPEN:
            context.outcome = Outcome.NOT_FOUND
        landed = len(context.roster.members(Task.LANDED))
        context.message = f"Mission over: {landed} of {len(context.roster.members())} vehicles landed."
