"""Monitors all vehicles while the procedures fly them: links, take-overs, batteries, distances, landings."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from dataclasses import replace

from aos_gcs.airspace.accuracy import Accuracy
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.accuracies import accuracy_of
from aos_gcs.mission.fleet.energy import time_home_s
from aos_gcs.mission.fleet.landing.return_and_land import REPEAT_S, ReturnAndLand
from aos_gcs.mission.fleet.member import FLYING, Member
from aos_gcs.mission.fleet.standing_hold import StandingHold
from aos_gcs.mission.fleet.watches.accuracy import AccuracyWatch
from aos_gcs.mission.fleet.watches.altitude import AltitudeWatch
from aos_gcs.mission.fleet.watches.condition import MAX_BATTERY_AGE_S, ConditionWatch
from aos_gcs.mission.fleet.watches.ground import GroundWatch
from aos_gcs.mission.fleet.watches.jumps import JumpWatch
from aos_gcs.mission.fleet.watches.links import LinkWatch
from aos_gcs.mission.fleet.watches.proximity import ProximityWatch
from aos_gcs.mission.fleet.watches.ways import WayWatch
from aos_gcs.mission.health import CatchingUp, Punctuality
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Hold, Land, ReturnToLaunch, Severity

_PERIOD_S = 0.1
_SNAPSHOT_PERIOD_S = 0.2
"""Real seconds between snapshots on the event stream, however fast the clock."""
_STOPPED_S = 3.0
"""Time for which a vehicle in flight has to report stopped motors: one wrong heartbeat changes nothing."""
_STOPPED_IF_LOST = frozenset({Task.SWARM, Task.JOINING})
"""Tasks of vehicles that are held when their positions cannot be trusted; others are on their way down."""


class Monitor:
    """Runs beside the procedures for the whole mission.

    Args:
        returning: returns the procedure that sends vehicles home by the present plan.
        publish: called a few times per second.
        on_all_lost: called when no vehicle has been heard for too long.
    """

    def __init__(
        self,
        returning: Callable[[], ReturnAndLand],
        publish: Callable[[], None],
        on_all_lost: Callable[[], None],
        standing_hold: StandingHold,
    ) -> None:
        self._returning = returning
        self._standing_hold = standing_hold
        self._publish = publish
        self._on_all_lost = on_all_lost
        context = self._context
        self._punctuality = Punctuality(_PERIOD_S)
        self._links = LinkWatch(context.roster, context.clock, context.journal, self._punctuality)
        self._proximity = ProximityWatch(context.roster, context.clock, context.journal, self._accuracy)
        self._ways = WayWatch(context.roster, context.clock, context.journal)
        self._altitudes = AltitudeWatch(context.roster, context.clock, context.journal)
        self._accuracies = AccuracyWatch(context.roster, context.clock, context.journal)
        self._heights = GroundWatch(context.roster, context.clock, context.journal)
        self._wrong_altitudes: dict[int, str] = {}
        """Reason to leave by vehicle, for those that are or may be at another height than reported."""
        self._condition = ConditionWatch(context.roster, context.clock, context.journal)
        self._jumps = JumpWatch(context.clock, context.journal)
        self._catching_up = CatchingUp()
        self._is_over = False
        self._all_lost_since_s: float | None = None
        self._stopped_at_s: dict[int, float] = {}
        """Time since which a vehicle reports stopped motors without reporting that it landed, by id; then infinite."""
        self._send_home_at_s: dict[int, float] = {}
        """Time from which a vehicle that has to leave may be commanded to again, by id."""
        self._land_at_s: dict[int, float] = {}
        """Time from which a vehicle that has not begun to land may be commanded to again, by id."""

    @property
    def _context(self) -> FlightContext:
        return self._returning().context

    @property
    def min_separation_m(self) -> float | None:
        """The smallest 3-D distance measured between two vehicles in the air so far."""
        return self._proximity.min_separation_m

    def end(self) -> None:
        """Note that the mission is over: whoever is in the air then, or is heard again, is led home on its own."""
        self._is_over = True

    async def run(self) -> None:
        """Watch until cancelled."""
        loop = asyncio.get_running_loop()
        next_snapshot_s = loop.time()
        async with asyncio.TaskGroup() as group:
            while True:
                is_catching_up = self._catching_up.look(self._context.clock.now_s())
                self._punctuality.look(self._context.clock.now_s())
                self._take_in_newcomers()
                self._context.roster.settle_altitudes()
                self._watch_altitudes()
                for member in self._context.roster.members():
                    if not is_catching_up:
                        self._links.look(member, self._context.settings.deadlines.lost_s, is_over=self._is_over)
                    self._watch_landing(member)
                    member.turn.look(member.state.heading_rad, self._context.clock.now_s())
                    self._measure_battery(member)
                    if (reason := self._must_leave(member)) is not None:
                        group.create_task(self._returning().send_home(member, reason))
                    if (is_first := self._must_land_again(member)) is not None:
                        group.create_task(self._returning().land_again(member, is_first=is_first))
                    self._watch_take_over(member)
                    if self._is_lost_in_space(member) and member.task in _STOPPED_IF_LOST and member.follows_us:
                        group.create_task(self._hold(member))
                for member in self._standing_hold.take_due(
                    self._context.roster.airborne(), self._context.clock.now_s()
                ):
                    group.create_task(self._hold_found(member))
                self._watch_all_lost()
                for member in self._proximity.look(self._context.bounds.limits):
                    group.create_task(self._hold(member))
                for member in self._ways.look(self._context.flight):
                    group.create_task(self._context.flight.command(member, member.safety_hold or Hold()))
                if loop.time() >= next_snapshot_s:
                    next_snapshot_s = loop.time() + _SNAPSHOT_PERIOD_S
                    self._publish()
                await self._context.clock.sleep(_PERIOD_S)

    def _take_in_newcomers(self) -> None:
        """Take in vehicles that are first heard during the mission: they can join, and preflight needs their home."""
        context = self._context
        found, is_started = context.roster.refresh(), context.journal.elapsed_s() > 0.0
        if not is_started:
            return
        for member in found:
            context.journal.notice(Severity.INFO, "first heard during the mission: it can join", member.vehicle_id)
        for member in context.roster.members(Task.IDLE):
            if member.home_enu_m is None:
                member.move_home(context.roster.launch_point_enu_m(member))

    def _watch_landing(self, member: Member) -> None:
        roster = self._context.roster
        if member.task is Task.LANDED:
            if member.airborne:
                roster.assign(member, Task.HELD)
                text = "airborne again after its landing. Hold it, return it or land it"
                self._context.journal.notice(Severity.CRITICAL, text, member.vehicle_id)
        elif member.task in {Task.RETURNING, Task.LANDING, Task.HELD} and roster.is_landed(member):
            roster.assign(member, Task.LANDED)
            self._context.journal.notice(Severity.INFO, "landed", member.vehicle_id)
        elif member.task in {Task.SWARM, Task.HELD} and member.waypoint_enu_m is not None:
            self._watch_motors(member)

    def _watch_motors(self, member: Member) -> None:
        """Report a vehicle whose motors have stopped away from its landing place, and take it out of the swarm."""
        context, vehicle_id = self._context, member.vehicle_id
        now_s = context.clock.now_s()
        if member.state.armed or not context.roster.is_fresh(member.state.armed_at_s):
            self._stopped_at_s.pop(vehicle_id, None)
        elif context.roster.is_landed(member):
            context.roster.assign(member, Task.LANDED)
            text = "left the swarm: it is on the ground and its motors have stopped. Check it on site"
            context.journal.notice(Severity.CRITICAL, text, vehicle_id)
        elif now_s - self._stopped_at_s.setdefault(vehicle_id, now_s) > _STOPPED_S:
            self._stopped_at_s[vehicle_id] = math.inf
            context.roster.assign(member, Task.HELD)
            text = "reports that its motors have stopped, but not that it is on the ground. Check it on site"
            context.journal.notice(Severity.CRITICAL, text, vehicle_id)

    def _accuracy(self, member: Member) -> Accuracy:
        """Return the accuracy of a measured position; one that has jumped must not hold all others about it."""
        return replace(self._context.flight.accuracy(member), horizontal_m=accuracy_of(member.state).horizontal_m)

    def _watch_altitudes(self) -> None:
        context = self._context
        if (limits := context.bounds.limits) is not None:
            spacing_m = context.settings.flight.layer_spacing_m
            inaccurate = self._accuracies.look(limits.separation_m, spacing_m)
            self._wrong_altitudes = inaccurate | self._altitudes.look(limits.separation_m, spacing_m)
        self._heights.look(limits, context.bounds.ground)

    def _measure_battery(self, member: Member) -> None:
        if not member.airborne:
            member.battery.reset()
        elif member.state.battery_fraction is not None:
            member.battery.take(self._context.clock.now_s(), member.state.battery_fraction)

    def _is_lost_in_space(self, member: Member) -> bool:
        """Return whether a vehicle's position cannot be trusted from now on."""
        has_jumped = self._jumps.look(member)
        return self._condition.look(member) or has_jumped

    def _must_leave(self, member: Member) -> str | None:
        """Return the reason why a vehicle has to return now; None if it has none."""
        is_on_its_way = self._returning().is_busy(member) and member.task is not Task.JOINING
        if not member.airborne or not member.obeys_return or is_on_its_way:
            return None
        reason = self._why_home(member)
        now_s = self._context.clock.now_s()
        if reason is None or now_s < self._send_home_at_s.get(member.vehicle_id, now_s):
            return None
        self._send_home_at_s[member.vehicle_id] = now_s + REPEAT_S
        return reason

    def _why_home(self, member: Member) -> str | None:
        if self._is_over and self._is_told_down(member):
            return None
        if member.task is Task.RETURNING and not member.is_held_by_order:
            is_led = self._returning().is_for_all and not self._is_over
            return None if is_led else "it has not arrived yet"
        if member.task not in {Task.SWARM, Task.HELD, Task.JOINING, Task.RETURNING}:
            return None
        if self._is_over and member.task is Task.HELD and not member.is_held_by_order:
            return "the mission is over"
        # A hold by order, also one of all on their ways home, does not outlast the battery.
        problem = self._battery_problem(member)
        if member.task is not Task.RETURNING:
            member.left_for_battery = problem or ""
        return self._wrong_altitudes.get(member.vehicle_id) or problem

    def _is_told_down(self, member: Member) -> bool:
        """Return whether telemetry may not show yet that a vehicle was told to land or to return by its autopilot."""
        told_s = self._context.clock.now_s() - member.sent_at_s
        is_recent = told_s < self._context.settings.deadlines.command_s + REPEAT_S
        return isinstance(member.last_command, Land | ReturnToLaunch) and is_recent

    def _must_land_again(self, member: Member) -> bool | None:
        """Return whether the landing of a vehicle has to be repeated for the first time; None if not at all now."""
        returning, vehicle_id = self._returning(), member.vehicle_id
        if member.task is not Task.LANDING or returning.is_landing_all:
            self._land_at_s.pop(vehicle_id, None)
            return None
        if not member.airborne or not member.obeys_return or returning.is_busy(member):
            return None
        if member.is_held_by_order and self._battery_problem(member) is None:
            return None
        command_s, now_s = self._context.settings.deadlines.command_s, self._context.clock.now_s()
        # A command that is not refused may be on its way yet.
        due_s = member.sent_at_s + REPEAT_S + (command_s if isinstance(member.last_command, Land) else 0.0)
        if now_s < max(due_s, self._land_at_s.get(vehicle_id, now_s)):
            return None
        is_first = vehicle_id not in self._land_at_s
        self._land_at_s[vehicle_id] = now_s + REPEAT_S
        return is_first

    def _battery_problem(self, member: Member) -> str | None:
        limits, battery = self._context.bounds.limits, member.state.battery_fraction
        if limits is None or battery is None:
            return None
        silence_s = self._condition.battery_silence_s(member)
        if silence_s is not None and silence_s > MAX_BATTERY_AGE_S:
            return f"its battery has not been reported for {silence_s:.0f} s, last at {battery:.0%}"
        battery_home = self._battery_home(member)
        if battery >= limits.min_battery_fraction + battery_home:
            return None
        if battery < limits.min_battery_fraction:
            return f"battery at {battery:.0%}"
        reserve = limits.min_battery_fraction
        return f"battery at {battery:.0%}: the return takes {battery_home:.0%}, and {reserve:.0%} must be left"

    def _battery_home(self, member: Member) -> float:
        """Return the battery fraction that the return takes at the measured rate; 0 while that is not known."""
        position_enu_m, per_s = self._context.roster.position_enu_m(member), member.battery.per_s
        if per_s is None or position_enu_m is None or member.home_enu_m is None:
            return 0.0
        settings, column_enu_m = self._context.settings, self._context.roster.own_column_enu_m(member)
        return per_s * time_home_s(
            position_enu_m,
            member.home_enu_m,
            settings.flight.cruise_speed_mps,
            layer_up_m=-math.inf if column_enu_m is None else float(column_enu_m[2]),
            wind_mps=settings.relay.wind_mps,
        )

    async def _hold(self, member: Member) -> None:
        """Stop one of two vehicles that are too close, whatever it was doing; the operator resumes it."""
        self._returning().stop(member)
        self._context.roster.assign(member, Task.HELD)
        await self._context.flight.command(member, member.hold_for_safety())

    async def _hold_found(self, member: Member) -> None:
        """Hold a vehicle that was found in the air after an operator's hold of all."""
        self._context.journal.notice(
            Severity.WARNING, "airborne when first heard: holding, like all vehicles", member.vehicle_id
        )
        await self._context.flight.command(member, Hold())

    def _watch_take_over(self, member: Member) -> None:
        """Leave a vehicle alone that a pilot, another station or its failsafe flies, and say so."""
        refusal = member.why_not_ours
        if not member.airborne or refusal is None or not self._is_flown_against_us(member):
            return
        self._returning().stop(member)
        self._context.roster.assign(member, Task.HELD)
        text = f"left the swarm: {refusal.text}. It is left alone until it is resumed"
        self._context.journal.notice(Severity.CRITICAL, text, member.vehicle_id)

    @staticmethod
    def _is_flown_against_us(member: Member) -> bool:
        if member.task is Task.SWARM:
            return True
        # These return or land in modes that are the autopilot's own, by our command.
        return member.task in {Task.JOINING, Task.RETURNING, Task.LANDING} and bool(member.state.taken_over)

    def _watch_all_lost(self) -> None:
        context = self._context
        now_s = context.clock.now_s()
        lost = context.roster.members(Task.LOST)
        is_any_heard = any(member.is_reachable for member in lost)
        if not lost or is_any_heard or context.roster.members(*FLYING, Task.LANDED):
            self._all_lost_since_s = None
        elif self._all_lost_since_s is None:
            self._all_lost_since_s = now_s
        elif now_s - self._all_lost_since_s > context.settings.deadlines.all_lost_s:
            self._all_lost_since_s = None
            self._on_all_lost()
