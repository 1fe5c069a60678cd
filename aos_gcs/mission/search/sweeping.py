"""Conduct of a sweep: frames are taken in flight, round after round, and the line flies on while they are analysed."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Mapping, Sequence

import numpy as np

from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.search.camera_pace import CameraPace
from aos_gcs.mission.search.exposing import Exposures, exposing
from aos_gcs.mission.search.flight_frames import FramesInFlight
from aos_gcs.mission.search.sampling import Sample, Sampler
from aos_gcs.mission.search.step_work import StepWork
from aos_gcs.mission.search.vision import Vision
from aos_gcs.ports import Command, Goto, Hold, Severity

ANALYSIS_S = 1.0
"""Time for a round's analysis. A sweep whose waypoints are older than by this and the longest wait for frames stops:
what was free when they were vetted may no longer be."""
_SAME_PLACE_M = 0.05
_POLL_S = 0.25


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
        self._pace = CameraPace(context.settings.imaging, context.journal)
        self.is_paused = False
        """Whether to stop before the next step."""
        self.is_under_way = False
        """Whether vehicles may still fly to waypoints of a sweep."""
        self.frames = FramesInFlight(context.settings, context.journal)
        """Whether the search may sweep, by the frames that come."""

    async def fly(self, waypoints: Sequence[WaypointRecord]) -> Phase:
        """Fly a sweep from its first waypoints on, until something ends it; return the phase that follows.

        Where that is the scan, all vehicles hover.
        """
        following = Phase.SCAN
        if self.is_paused:
            return following
        self.is_under_way = True
        async with exposing(self._context, self._sampler, self._pace) as exposures:
            flight = _Flight(self._context, exposures)
            flight.send(waypoints)
            watch = exposures.start(self._watch(flight, exposures.blind_s + ANALYSIS_S))
            while self.is_under_way and following is Phase.SCAN and not self.is_paused:
                following = await self._make_step(flight, exposures)
            watch.cancel()
            flight.give_way()
        if following is Phase.SCAN:
            await self.stop()
        return following

    async def stop(self) -> None:
        """Have the vehicles hover where they come to a stop, if they sweep; who must not be sent there holds."""
        if not self.is_under_way:
            return
        self.is_under_way = False
        waypoints = self._stops()
        await self._context.flight.send(waypoints)
        await self._work.await_arrival(waypoints)

    async def _end(self, flight: _Flight) -> None:
        """Have the vehicles hover, and send no more of the sweep."""
        flight.give_way()
        await self.stop()

    def _stops(self) -> tuple[WaypointRecord, ...]:
        """Return the places where the vehicles of the swarm come to a stop, vetted."""
        flight, roster = self._context.flight, self._context.roster
        situation = flight.situation([member.vehicle_id for member in roster.members(Task.SWARM)])
        return flight.vet(
            {
                one.vehicle_id: one.position_enu_m if one.stop_enu_m is None else one.stop_enu_m
                for one in situation.movable
            }
        )

    async def _watch(self, flight: _Flight, longest_s: float) -> None:
        """Stop the vehicles where a step takes longer, as when images are not analysed; its decision sends them on."""
        clock, journal = self._context.clock, self._context.journal
        while True:
            await clock.sleep(_POLL_S)
            unvetted_s = clock.now_s() - flight.vetted_at_s
            if flight.is_on_its_way and unvetted_s > longest_s:
                text = f"Step {self._work.step} takes longer than {unvetted_s:.0f} s: the line stops until it is over"
                journal.notice(Severity.WARNING, text)
                flight.stop(self._stops())

    async def _make_step(self, flight: _Flight, exposures: Exposures) -> Phase:
        """Make a step by the next round of frames; where there is none, the sweep stops."""
        context, work = self._context, self._work
        if len(swarm := context.roster.members(Task.SWARM)) < context.settings.fewest_vehicles:
            await self._end(flight)
            return Phase.SCAN
        exposures.follow(swarm)
        if (taken := await exposures.round()) is None:
            trouble = exposures.trouble
            self.frames.note_silence(f"No frame has come in flight for {exposures.blind_s:g} s ({trouble})")
            await self._end(flight)
            return Phase.SCAN
        self.frames.note_round()
        work.step += 1
        context.journal.set_message(f"Step {work.step}: searching in flight.")
        async with self._vision.intake(work.step) as intake:
            for capture in taken.captures:
                intake.add(capture, taken.speeds_mps[capture.vehicle_id])
        following, decision = await work.work_on(Phase.SCAN, swarm, intake, taken, may_sweep=True, sweep=flight)
        if decision is None:
            await self._end(flight)
        elif not decision.is_sweep:
            # Their waypoints are others now; where there are none, the next phase sends them.
            self.is_under_way = following not in {Phase.SCAN, Phase.CONVERGE}
        return following


class _Flight:
    """See :class:`aos_gcs.mission.search.step_work.SweepFlight`. No vehicle waits for the confirmation of another."""

    def __init__(self, context: FlightContext, exposures: Exposures) -> None:
        self._context = context
        self._exposures = exposures
        self._sending: dict[int, asyncio.Task[None]] = {}
        self._unconfirmed: set[int] = set()
        self.is_on_its_way = False
        """Whether the vehicles fly to waypoints far ahead."""
        self.vetted_at_s = -math.inf
        """Time at which these were vetted."""

    @property
    def is_behind(self) -> bool:
        return self._exposures.is_behind

    def leave_out(self, step: int, taken: Sample, reasons: Mapping[int, str]) -> Sample:
        return self._exposures.leave_out(step, taken, reasons)

    def send(self, waypoints: Sequence[WaypointRecord]) -> None:
        self.is_on_its_way, self.vetted_at_s = True, self._context.clock.now_s()
        self._send_changed(waypoints)

    def stop(self, waypoints: Sequence[WaypointRecord]) -> None:
        """Send vetted places where the vehicles come to a stop."""
        self.is_on_its_way = False
        self._send_changed(waypoints)

    def _send_changed(self, waypoints: Sequence[WaypointRecord]) -> None:
        """Send each vehicle what differs from what it was told last; that is no longer repeated."""
        changed = [one for one in waypoints if one.vehicle_id in self._unconfirmed or not self._is_followed(one)]
        for vehicle_id, command in self._context.flight.orders(changed).items():
            self._call_off(vehicle_id)
            self._unconfirmed.discard(vehicle_id)
            # The task is the command itself: one that began it later would overtake an operator's hold.
            self._sending[vehicle_id] = self._exposures.start(self._send(vehicle_id, command))

    def _is_followed(self, waypoint: WaypointRecord) -> bool:
        """Return whether a vehicle flies, or is being sent, to a waypoint already, at its speed."""
        (member,) = self._context.roster.select([waypoint.vehicle_id])
        command = member.last_command
        if waypoint.sent_enu_m is None or member.waypoint_enu_m is None or not isinstance(command, Goto):
            return False
        is_there = bool(np.allclose(member.waypoint_enu_m, waypoint.sent_enu_m, atol=_SAME_PLACE_M))
        return is_there and command.speed_mps == waypoint.speed_mps

    def _call_off(self, vehicle_id: int) -> None:
        if (sending := self._sending.pop(vehicle_id, None)) is not None:
            sending.cancel()

    def give_way(self) -> None:
        self.is_on_its_way = False
        for vehicle_id in tuple(self._sending):
            self._call_off(vehicle_id)

    async def finish(self) -> None:
        await self._exposures.finish()

    async def _send(self, vehicle_id: int, command: Command) -> None:
        (member,) = self._context.roster.select([vehicle_id])
        if await self._context.flight.command(member, command) is not None and not isinstance(command, Hold):
            self._unconfirmed.add(vehicle_id)
