"""Return and landing: the phases RETURN and LAND, and single vehicles that leave the swarm."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.landing.descents import blocks_descent, clear_columns, stands_below, to_clear
from aos_gcs.mission.fleet.landing.landing_places import LandingPlaces
from aos_gcs.mission.fleet.landing.landing_report import report_landings, report_pilots
from aos_gcs.mission.fleet.landing.launch_columns import in_launch_columns
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.motion import is_told_to_land
from aos_gcs.mission.fleet.vehicle_tasks import VehicleTasks
from aos_gcs.mission.fleet.watches.jumps import DOUBT_LASTS_S
from aos_gcs.mission.model.actions import Refusal
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Arm, Command, Disarm, FlightMode, Land, ReturnToLaunch, Severity

_COMING_DOWN = frozenset({FlightMode.RETURN, FlightMode.LAND})
REPEAT_S = 5.0
"""Time between two attempts to have a vehicle return or land that does not."""
_LAND_ATTEMPTS = 3
_POLL_S = 0.2
_LOOK_AGAIN_S = 1.0
_HOVER_S = 15.0
"""Time for which a vehicle hovers above its launch point, by its autopilot's own return, before it is landed."""
_HOVER_MPS = 0.3
_NEAR_HOME_M = 3.0


class ReturnAndLand:
    """The phases RETURN and LAND. Every handler can be entered again after an interruption."""

    def __init__(self, context: FlightContext, vehicle_tasks: VehicleTasks) -> None:
        self._context = context
        self._vehicle_tasks = vehicle_tasks
        self._places = LandingPlaces(context)
        self._hovering_since_s: dict[int, float] = {}
        """Time since which a vehicle hovers at the end of its autopilot's own return, by id."""
        self.is_for_all = False
        """Whether the whole swarm returns or lands, so that no vehicle does so on its own."""
        self.goes_home = False
        """Whether the whole swarm returns, also while it lands behind that; not where it is to land where it is."""
        self._left_at_order: dict[int, Command] = {}
        """Hold by which an operator has stopped a vehicle on its way down, as reported, by id."""
        self.is_landing_all = False
        """Whether the whole swarm is landed now, so that no landing is repeated on its own."""

    @property
    def context(self) -> FlightContext:
        """Context of the flight."""
        return self._context

    async def return_home(self) -> Phase:
        """Fly all vehicles to where they land, each in its own altitude layer, before any of them descends.

        Paths in different layers do not cross; the autopilots' own return would let early vehicles descend through the
        layers of those still on their way. A vehicle below its layer climbs straight up first. One that cannot be flown
        home like that is handed to its autopilot; one that is descending already or is flown by a pilot is left alone.
        Vehicles that have not left the columns above their launch points land there at once.
        """
        context = self._context
        self._take_over_all()
        self.goes_home = True
        context.journal.set_message("Returning: flying home in the altitude layers.")
        await self._land_in_launch_columns()
        to_fly = [m for m in self._still_flying() if not m.position_doubt_m and not is_told_to_land(m)]
        for member in (able := [member for member in to_fly if self._can_fly_home(member)]):
            context.roster.assign(member, Task.RETURNING)
        await self._fly_above_home(able, left_out=self._vehicle_tasks.is_running)
        await self._return_held()
        if any(self._can_fly_home(member) for member in self._astray()):
            await self._land_in_turn()
        astray = self._astray()
        for member in astray:
            text = "returns by its autopilot, at the autopilot's own height"
            context.journal.notice(Severity.WARNING, text, member.vehicle_id)
        await context.flight.command_each(astray, lambda _: ReturnToLaunch())
        return Phase.LAND

    async def land(self) -> Phase:
        """Land all vehicles where they are, none above another, and wait until their motors have stopped."""
        self.is_landing_all = True
        try:
            return await self._land_all()
        finally:
            self.is_landing_all = False

    async def _land_all(self) -> Phase:
        context = self._context
        self.is_for_all = True
        if not self.goes_home:
            self._vehicle_tasks.stop_all()
        context.journal.set_message("Landing.")
        left = self.left_alone() if self.goes_home else []
        await self._land_in_launch_columns(left)
        await clear_columns(context, [member for member in to_clear(context) if member not in left])
        for member in self._still_flying():
            if member.obeys_return and not (self.goes_home and member in self.left_alone()):
                context.roster.assign(member, Task.LANDING)
        report_pilots(context, self._still_flying())
        await self._bring_down()
        if await self._is_any_heard_again():
            await self._bring_down()
        report_landings(context, self._not_landed())
        return Phase.DONE

    def land_here(self) -> None:
        """Note that all vehicles are to land where they are, whatever was ordered before."""
        self.goes_home = False

    def left_alone(self) -> list[Member]:
        """Return the vehicles that do not come down with the others: held by an operator, or on ways of their own."""
        return [member for member in self._still_flying() if self._is_left_alone(member)]

    def _is_left_alone(self, member: Member) -> bool:
        is_held = member.task is Task.HELD and member.is_held_by_order and member.follows_us
        return member.airborne and (is_held or self.is_busy(member))

    def _report_held(self) -> bool:
        """Report the vehicles that the landing of all waits for; return whether there are any."""
        left = self.left_alone()
        held = {one.vehicle_id: one.last_command for one in left if one.last_command and not self.is_busy(one)}
        for vehicle_id, hold in held.items():
            if self._left_at_order.get(vehicle_id) is not hold:
                text = "hovers, as an operator has ordered: resume, return or land it"
                self._context.journal.notice(Severity.WARNING, text, vehicle_id)
        self._left_at_order = held
        waiting = ", ".join(str(member.vehicle_id) for member in left)
        self._context.journal.set_message(f"Landing: waiting for vehicle {waiting}." if left else "Landing.")
        return bool(left)

    async def _land_in_launch_columns(self, left: Sequence[Member] = ()) -> None:
        """Land the vehicles that have not left the columns above their launch points; others climb and fly home."""
        low = [member for member in in_launch_columns(self._context) if member not in left]
        for member in low:
            self._context.roster.assign(member, Task.LANDING)
        await self._context.flight.command_each(low, lambda _: Land())

    async def _bring_down(self) -> None:
        """Command all vehicles to land until all have landed or the deadline has passed.

        One that begins to wait for a command, such as at the end of a return of its own, gets it at once; one that does
        not follow gets it again after a while, a third of the time at most.
        """
        context, now_s = self._context, self._context.clock.now_s
        began_s, land_s = now_s(), context.settings.deadlines.land_s
        again_s = min(land_s / _LAND_ATTEMPTS, context.settings.deadlines.command_s + REPEAT_S)
        commanded_at_s: dict[int, float] = {}
        while self._not_landed() and now_s() - began_s < land_s:
            if self._report_held():
                began_s = now_s()
            due = []
            for member in self._still_flying():
                # Motors that run on after the touchdown stop by themselves, as a rule.
                is_new = member.airborne or not commanded_at_s
                last_s = commanded_at_s.get(member.vehicle_id, -math.inf if is_new else began_s)
                is_due = now_s() - last_s >= again_s and not self._is_left_alone(member)
                if is_due and self._waits_for_us(member):
                    due.append(member)
            commanded_at_s |= dict.fromkeys((member.vehicle_id for member in due), now_s())
            await context.flight.command_each(due, self._down)
            await context.flight.wait_until(self._not_landed, lambda _: False, _LOOK_AGAIN_S)
            self._take_over_hovering()

    def _take_over_hovering(self) -> None:
        """Land vehicles that hover above their launch points at the end of their autopilots' own return."""
        roster, now_s = self._context.roster, self._context.clock.now_s()
        for member in self._still_flying():
            if member.task is Task.LANDING or not self._hovers_at_home(member):
                self._hovering_since_s.pop(member.vehicle_id, None)
            elif now_s - self._hovering_since_s.setdefault(member.vehicle_id, now_s) >= _HOVER_S and (
                blocks_descent(self._context, member) is None and stands_below(self._context, member) is None
            ):
                roster.assign(member, Task.LANDING)

    def _hovers_at_home(self, member: Member) -> bool:
        position_enu_m, velocity_enu_mps = self._context.roster.position_enu_m(member), member.state.velocity_enu_mps
        if position_enu_m is None or velocity_enu_mps is None or member.home_enu_m is None or not member.airborne:
            return False
        is_near = float(np.linalg.norm((position_enu_m - member.home_enu_m)[:2])) <= _NEAR_HOME_M
        return member.state.mode is FlightMode.RETURN and is_near and math.hypot(*velocity_enu_mps) <= _HOVER_MPS

    async def _is_any_heard_again(self) -> bool:
        """Return whether a lost vehicle is heard again soon. When all are lost, the monitor ends the mission first."""
        roster = self._context.roster
        lost = roster.members(Task.LOST)
        timeout_s = 2 * self._context.settings.deadlines.all_lost_s
        left = await self._context.flight.wait_until(lambda: roster.members(Task.LOST), lambda _: False, timeout_s)
        return len(left) < len(lost)

    async def send_home(self, member: Member, reason: str, severity: Severity = Severity.WARNING) -> Refusal | None:
        """Have one vehicle leave the swarm and return on its own.

        It flies home in its own layer, and lands once the column below is free; otherwise its autopilot returns it.
        """
        self._context.journal.notice(severity, f"returns on its own: {reason}", member.vehicle_id)
        if self._can_fly_home(member):
            self._context.roster.assign(member, Task.RETURNING)
            self._vehicle_tasks.start(member.vehicle_id, self._fly_home(member))
            return None
        self._vehicle_tasks.stop(member.vehicle_id)
        return await self._hand_over(member)

    async def land_again(self, member: Member, *, is_first: bool) -> None:
        """Repeat the landing of a vehicle that has not begun it, once nobody is below it; the first time, report it."""
        context = self._context
        if is_first:
            text = "has not begun to land: it is told again until it does"
            context.journal.notice(Severity.WARNING, text, member.vehicle_id)
        if (standing := stands_below(context, member)) is not None:
            await self.send_home(member, f"vehicle {standing} stands on the ground below it")
        elif (other_id := blocks_descent(context, member)) is not None:
            member.keep_back(f"held: vehicle {other_id} is or may come below it")
        else:
            await context.flight.command(member, Land(), is_repeated=True)

    def stop(self, member: Member) -> None:
        """Fly a vehicle no further on its own; its last command stays in force."""
        self._vehicle_tasks.stop(member.vehicle_id)

    def is_busy(self, member: Member) -> bool:
        """Return whether a vehicle has a procedure of its own, such as its return."""
        return self._vehicle_tasks.is_running(member.vehicle_id)

    def _take_over_all(self) -> None:
        self.is_for_all = True
        self._vehicle_tasks.stop_all()

    async def _fly_home(self, member: Member) -> None:
        """Fly one vehicle home and land it, unless it gets another task or is taken over on its way."""
        context = self._context
        if member in in_launch_columns(context):
            context.roster.assign(member, Task.LANDING)
            await context.flight.command(member, Land())
            return
        while True:
            await self._until_located([member])
            await self._fly_above_home([member])
            if member.task is not Task.RETURNING or not member.follows_us:
                return
            if self._is_astray(member):
                await self._hand_over(member)
                return
            while (other_id := blocks_descent(context, member)) is not None:
                member.keep_back(f"held: vehicle {other_id} is or may come below it")
                await context.clock.sleep(_POLL_S)
            if not self._places.leave_occupied(member):
                break
        if member.task is Task.RETURNING and member.follows_us:
            context.roster.assign(member, Task.LANDING)
            await context.flight.command(member, Land())

    async def _hand_over(self, member: Member) -> Refusal | None:
        """Hand a vehicle to its autopilot's own return."""
        roster = self._context.roster
        roster.assign(member, Task.RETURNING)
        command = ReturnToLaunch()
        refusal = await self._context.flight.command(member, command)
        if refusal is not None and member.last_command in (None, command):
            roster.assign(member, Task.HELD)
        return refusal

    async def _return_held(self) -> None:
        """Fly vehicles home that were held on their way, such as for the separation, once the others are there."""
        await self._until_located(self._context.roster.members(Task.HELD))
        held = [m for m in self._context.roster.members(Task.HELD) if self._can_fly_home(m) and not m.is_held_by_order]
        for member in held:
            self._context.roster.assign(member, Task.RETURNING)
        await self._fly_above_home(held, left_out=self._vehicle_tasks.is_running)

    async def _until_located(self, members: Sequence[Member]) -> None:
        """Wait while positions are in doubt: from there, the vetted path would be another one in the air."""
        await self._context.flight.wait_until(
            lambda: [member for member in members if member.airborne], lambda m: not m.position_doubt_m, DOUBT_LASTS_S
        )

    async def _land_in_turn(self) -> None:
        """Land vehicles that are home, then fly and land the others one by one, those near their launch points first.

        Where positions are inaccurate, launch points may be too near to each other for two vehicles to hover there.
        """
        astray = self._astray()
        await self._bring_down_here([member for member in self._still_flying() if member not in astray])
        for member in sorted(filter(self._can_fly_home, astray), key=self._way_home_m):
            if member.task is Task.RETURNING:
                self._places.leave_occupied(member)
                await self._fly([member], self._above_home)
                await self._bring_down_here([member])

    async def _bring_down_here(self, members: list[Member]) -> None:
        """Land those vehicles above their landing places whose columns are free, and wait until they are down."""
        flight = self._context.flight
        down = [
            member
            for member in members
            if member.task is Task.RETURNING
            and self._can_fly_home(member)
            and not self._is_astray(member)
            and blocks_descent(self._context, member) is None
            and stands_below(self._context, member) is None
        ]
        for member in down:
            self._context.roster.assign(member, Task.LANDING)
        await flight.command_each(down, lambda _: Land())
        landing_s = self._context.settings.deadlines.land_s
        await flight.wait_until(lambda: down, lambda one: not one.airborne or one.task is not Task.LANDING, landing_s)

    def _way_home_m(self, member: Member) -> float:
        position_enu_m, place_enu_m = self._context.roster.position_enu_m(member), self._places.of(member)
        if position_enu_m is None or place_enu_m is None:
            return math.inf
        return float(np.linalg.norm((position_enu_m - place_enu_m)[:2]))

    def _astray(self) -> list[Member]:
        """Return the airborne vehicles that are not above their landing places."""
        left = self.left_alone()
        flying = [member for member in self._still_flying() if member.airborne and member not in left]
        return [member for member in flying if self._is_astray(member)]

    def _still_flying(self) -> list[Member]:
        return [
            member
            for member in self._context.roster.members()
            if member.takes_part
            and member.task is not Task.LOST
            and (member.task is not Task.LANDED or member.airborne)
            # A vehicle that was commanded to arm may be about to.
            and (member.state.armed or isinstance(member.last_command, Arm))
        ]

    def _not_landed(self) -> list[Member]:
        """Return the vehicles that fly, or have stopped their motors without reporting yet that they landed."""
        coming_down = self._context.roster.members(Task.HELD, Task.RETURNING, Task.LANDING)
        return list({member.vehicle_id: member for member in (*self._still_flying(), *coming_down)}.values())

    @staticmethod
    def _waits_for_us(member: Member) -> bool:
        """Return whether a vehicle needs a command: it has landed with running motors, or does not land on its own."""
        is_told_to_land = member.task is Task.LANDING and member.state.mode is FlightMode.RETURN
        # Motors of a vehicle that a pilot has landed are the pilot's.
        has_landed = member.state.mode in _COMING_DOWN and not member.airborne and not member.taken_over
        return not member.has_pilot and (member.obeys_return or is_told_to_land or has_landed)

    def _can_fly_home(self, member: Member) -> bool:
        has_place = self._context.roster.layers.at(member, member.home_enu_m) is not None
        return member.airborne and member.follows_us and has_place

    def _is_astray(self, member: Member) -> bool:
        """Return whether a vehicle obeys a return but hovers elsewhere than above its landing place."""
        place_enu_m = self._above_home(member)
        is_there = place_enu_m is not None and self._context.flight.is_at(member, place_enu_m)
        return member.obeys_return and not is_there and not is_told_to_land(member)

    async def _fly(
        self,
        members: list[Member],
        place_of: Callable[[Member], NDArray[np.float64] | None],
        left_out: Callable[[int], bool] = lambda _: False,
    ) -> None:
        requests = {m.vehicle_id: place_enu_m for m in members if (place_enu_m := place_of(m)) is not None}
        tasks = frozenset({Task.RETURNING})
        await self._context.flight.transfer(requests, tasks, returning=True, left_out=left_out)

    async def _fly_above_home(self, members: list[Member], left_out: Callable[[int], bool] = lambda _: False) -> None:
        """Fly vehicles straight up or down into their layers, then above landing places where nobody stands."""
        await self._fly(members, self._climb, left_out)
        for member in members:
            if member.task is Task.RETURNING:
                self._places.leave_occupied(member)
        await self._fly(members, self._above_home, left_out)

    def _climb(self, member: Member) -> NDArray[np.float64] | None:
        roster = self._context.roster
        return None if roster.is_in_layer(member) else roster.own_column_enu_m(member)

    def _above_home(self, member: Member) -> NDArray[np.float64] | None:
        """Return the position in a vehicle's layer above its landing place; None if that is not known."""
        return self._context.roster.layers.at(member, self._places.of(member))

    @staticmethod
    def _down(member: Member) -> Command:
        """Return the command that brings a vehicle down.

        On the ground with running motors, such as after an abort while arming, that is to disarm. A vehicle that was
        lost while the others flew to where they land is somewhere else, and returns.
        """
        if not member.airborne:
            return Disarm()
        return Land() if member.task is Task.LANDING else ReturnToLaunch()
