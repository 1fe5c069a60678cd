"""Watches over all vehicles while the procedures fly them: links, take-overs, batteries, distances, landings."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import numpy as np

from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.homing import Homing
from aos_gcs.mission.model import EventKind, MissionSnapshot, Task
from aos_gcs.mission.roster import FLYING, Member
from aos_gcs.mission.separation import minimum_separation
from aos_gcs.ports import Goto, LandedState, Severity

_PERIOD_S = 0.1
_SNAPSHOT_PERIOD_S = 0.2
"""Real seconds between snapshots on the event stream, however fast the clock."""
_REPEAT_S = 5.0
"""Between two attempts to send a vehicle home that does not go."""


class Monitor:
    """Runs beside the procedures for the whole mission."""

    def __init__(
        self,
        context: MissionContext,
        homing: Homing,
        snapshot: Callable[[], MissionSnapshot],
        on_all_lost: Callable[[], None],
    ) -> None:
        self._context = context
        self._homing = homing
        self._snapshot = snapshot
        self._on_all_lost = on_all_lost
        self._too_close: set[tuple[int, int]] = set()
        self._all_lost_since_s: float | None = None
        self._send_home_at_s: dict[int, float] = {}
        """When a vehicle that must leave may be told so again, by id."""
        self.min_separation_m: float | None = None

    async def run(self) -> None:
        """Watch until cancelled."""
        loop = asyncio.get_running_loop()
        next_snapshot_s = loop.time()
        async with asyncio.TaskGroup() as group:
            while True:
                self._context.roster.refresh()
                for member in self._context.roster.members():
                    self._watch_link(member)
                    self._watch_landing(member)
                    if (reason := self._must_leave(member)) is not None:
                        group.create_task(self._homing.send_home(member, reason))
                    self._watch_take_over(member)
                self._watch_all_lost()
                self._watch_separation()
                if loop.time() >= next_snapshot_s:
                    next_snapshot_s = loop.time() + _SNAPSHOT_PERIOD_S
                    self._context.journal.publish(EventKind.SNAPSHOT, self._snapshot())
                await self._context.clock.sleep(_PERIOD_S)

    def _watch_link(self, member: Member) -> None:
        context = self._context
        age_s = context.roster.link_age_s(member)
        silent = age_s is not None and age_s > context.settings.deadlines.lost_s
        if silent and member.task in FLYING:
            member.task_before_loss, member.task = member.task, Task.LOST
            context.journal.notice(
                Severity.CRITICAL, f"link lost for {age_s:.0f} s; its own failsafe flies it now", member.vehicle_id
            )
        elif not silent and member.task is Task.LOST:
            member.task = member.task_before_loss
            context.journal.notice(Severity.WARNING, "heard again", member.vehicle_id)

    def _watch_landing(self, member: Member) -> None:
        state = member.state
        down = not state.armed and state.landed in {LandedState.ON_GROUND, LandedState.UNKNOWN}
        if member.task in {Task.RETURNING, Task.LANDING, Task.HELD} and down:
            member.task = Task.LANDED
            self._context.journal.notice(Severity.INFO, "landed", member.vehicle_id)
        elif member.task is Task.SWARM and down and isinstance(member.last_command, Goto):
            member.task = Task.LANDED
            self._context.journal.notice(
                Severity.CRITICAL, "left the swarm: it is on the ground and its motors have stopped", member.vehicle_id
            )

    def _must_leave(self, member: Member) -> str | None:
        limits, battery = self._context.flight.limits, member.state.battery_fraction
        if limits is None or battery is None or not member.airborne or not member.follows_us:
            return None
        if member.task not in {Task.SWARM, Task.HELD} or battery >= limits.min_battery_fraction:
            return None
        now_s = self._context.clock.now_s()
        if now_s < self._send_home_at_s.get(member.vehicle_id, now_s):
            return None
        self._send_home_at_s[member.vehicle_id] = now_s + _REPEAT_S
        return f"battery at {100 * battery:.0f} %"

    def _watch_take_over(self, member: Member) -> None:
        if member.task is Task.SWARM and member.airborne and not member.follows_us:
            member.task = Task.HELD
            self._context.journal.notice(
                Severity.WARNING,
                f"left the swarm: its mode is {member.state.mode_name or member.state.mode}",
                member.vehicle_id,
            )

    def _watch_all_lost(self) -> None:
        context = self._context
        now_s = context.clock.now_s()
        lost = context.roster.members(Task.LOST)
        if not lost or context.roster.members(*FLYING, Task.LANDED):
            self._all_lost_since_s = None
        elif self._all_lost_since_s is None:
            self._all_lost_since_s = now_s
        elif now_s - self._all_lost_since_s > context.settings.deadlines.all_lost_s:
            self._all_lost_since_s = None
            self._on_all_lost()

    def _watch_separation(self) -> None:
        """Measure the smallest distance in the air, on positions carried forward by their age."""
        context = self._context
        members, positions = [], []
        for member in context.roster.airborne():
            position_enu_m = context.roster.position_enu_m(member)
            if position_enu_m is None:
                continue
            age_s = context.roster.position_age_s(member) or 0.0
            members.append(member)
            positions.append(position_enu_m + age_s * np.array(member.state.velocity_enu_mps or (0.0, 0.0, 0.0)))
        if len(members) < 2:
            return
        distance_m, rows = minimum_separation(np.array(positions))
        if self.min_separation_m is None or distance_m < self.min_separation_m:
            self.min_separation_m = distance_m
        limits = context.flight.limits
        if limits is None or distance_m >= limits.separation_m:
            self._too_close.clear()
            return
        pair = members[rows[0]].vehicle_id, members[rows[1]].vehicle_id
        if pair not in self._too_close:
            self._too_close.add(pair)
            text = f"only {distance_m:.1f} m from vehicle {pair[1]}, below the {limits.separation_m:.1f} m allowed"
            context.journal.notice(Severity.CRITICAL, text, pair[0])
