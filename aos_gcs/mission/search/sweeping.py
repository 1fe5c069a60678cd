"""Conduct of a sweep: frames are taken in flight, round after round, and the line flies on while they are analysed."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence

import numpy as np

from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.search.exposing import Exposures, exposing
from aos_gcs.mission.search.sampling import Sample, Sampler
from aos_gcs.mission.search.step_work import StepWork
from aos_gcs.mission.search.vision import Vision
from aos_gcs.planning.settings import SearchMode
from aos_gcs.ports import Goto, Hold, Severity

_SAME_PLACE_M = 0.05
_GIVE_WAY_S = 1.0
"""Longest time that other waypoints wait for the confirmation of those of a sweep."""


class Sweeping:
    """Flies sweeps, and stops them.

    Args:
        context: context of the flight.
        vision: takes in the frames.
        sampler: places them.
        work: works on them.
    """

    def __init__(self, context: FlightContext, vision: Vision, sampler: Sampler, work: StepWork) -> None:
        self._context = context
        self._vision = vision
        self._sampler = sampler
        self._work = work
        self.is_paused = False
        """Whether to stop before the next step."""
        self.is_under_way = False
        """Whether vehicles may still fly to waypoints of a sweep."""
        self.is_allowed = context.settings.search.mode is SearchMode.CONTINUOUS
        """Whether the search may sweep; no longer once frames did not come in flight."""

    async def fly(self, waypoints: Sequence[WaypointRecord]) -> Phase:
        """Fly a sweep from its first waypoints on, until something ends it; return the phase that follows.

        Where that is the scan, all vehicles hover.
        """
        following = Phase.SCAN
        if self.is_paused:
            return following
        self.is_under_way = True
        async with exposing(self._context, self._sampler) as exposures:
            flight = _Flight(self._context, exposures)
            flight.send(waypoints)
            while self.is_under_way and following is Phase.SCAN and not self.is_paused:
                following = await self._make_step(flight, exposures)
        if following is Phase.SCAN:
            await self.stop()
        return following

    async def stop(self) -> None:
        """Have the vehicles hover where they come to a stop, if they sweep; who must not be sent there holds."""
        if not self.is_under_way:
            return
        self.is_under_way = False
        flight, roster = self._context.flight, self._context.roster
        situation = flight.situation([member.vehicle_id for member in roster.members(Task.SWARM)])
        stops_enu_m = {
            one.vehicle_id: one.position_enu_m if one.stop_enu_m is None else one.stop_enu_m
            for one in situation.movable
        }
        waypoints = flight.vet(stops_enu_m)
        await flight.send(waypoints)
        unsent_ids = [one.vehicle_id for one in waypoints if one.sent_enu_m is None]
        await flight.command_each(roster.select(unsent_ids), lambda _: Hold())
        await self._work.await_arrival(waypoints)

    async def _make_step(self, flight: _Flight, exposures: Exposures) -> Phase:
        """Make a step by the next round of frames; where there is none, the sweep stops."""
        context, work = self._context, self._work
        if len(swarm := context.roster.members(Task.SWARM)) < context.settings.fewest_vehicles:
            await self.stop()
            return Phase.SCAN
        exposures.follow(swarm)
        if (taken := await exposures.round()) is None:
            self.is_allowed = False
            silence = f"No frame has come in flight for {exposures.blind_s:g} s ({exposures.trouble})"
            text = f"{silence}: the search goes on with stops"
            context.journal.notice(Severity.WARNING, text)
            await self.stop()
            return Phase.SCAN
        work.step += 1
        context.journal.set_message(f"Step {work.step}: searching in flight.")
        async with self._vision.intake(work.step) as intake:
            for capture in taken.captures:
                intake.add(capture, taken.speeds_mps[capture.vehicle_id])
        following, decision = await work.work_on(
            Phase.SCAN, swarm, intake, taken, may_sweep=self.is_allowed, sweep=flight
        )
        if decision is None:
            await self.stop()
        elif not decision.is_sweep:
            # Their waypoints are others now; where there are none, the next phase sends them.
            self.is_under_way = following not in {Phase.SCAN, Phase.CONVERGE}
        return following


class _Flight:
    """See :class:`aos_gcs.mission.search.step_work.SweepFlight`. One sending at a time; what differs is sent next."""

    def __init__(self, context: FlightContext, exposures: Exposures) -> None:
        self._context = context
        self._exposures = exposures
        self._sending: asyncio.Task[None] | None = None
        self._unconfirmed: frozenset[int] = frozenset()

    @property
    def is_behind(self) -> bool:
        return self._exposures.is_behind

    def leave_out(self, step: int, taken: Sample, reasons: Mapping[int, str]) -> Sample:
        return self._exposures.leave_out(step, taken, reasons)

    def send(self, waypoints: Sequence[WaypointRecord]) -> None:
        changed = [one for one in waypoints if one.vehicle_id in self._unconfirmed or not self._is_followed(one)]
        if changed and (self._sending is None or self._sending.done()):
            self._sending = self._exposures.start(self._send(changed))

    def _is_followed(self, waypoint: WaypointRecord) -> bool:
        """Return whether a vehicle flies to a waypoint already, at its speed."""
        (member,) = self._context.roster.select([waypoint.vehicle_id])
        command = member.last_command
        if waypoint.sent_enu_m is None or member.waypoint_enu_m is None or not isinstance(command, Goto):
            return False
        is_there = bool(np.allclose(member.waypoint_enu_m, waypoint.sent_enu_m, atol=_SAME_PLACE_M))
        return is_there and command.speed_mps == waypoint.speed_mps

    async def give_way(self) -> None:
        if self._sending is not None:
            await asyncio.wait([self._sending], timeout=_GIVE_WAY_S)

    async def finish(self) -> None:
        await self._exposures.finish()

    async def _send(self, waypoints: Sequence[WaypointRecord]) -> None:
        results = await self._context.flight.send(waypoints)
        self._unconfirmed = frozenset(vehicle_id for vehicle_id, refusal in results.items() if refusal is not None)
