"""Conduct of a sweep: frames are taken in flight, round after round, and the line flies on while they are analysed."""

from __future__ import annotations

from collections.abc import Sequence

from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.search.frames.sampling import Sampler
from aos_gcs.mission.search.frames.vision import Vision
from aos_gcs.mission.search.in_flight.camera_pace import CameraPace
from aos_gcs.mission.search.in_flight.commands import SweepCommands, places_to_stop
from aos_gcs.mission.search.in_flight.exposing import Exposures, exposing
from aos_gcs.mission.search.in_flight.frames import FramesInFlight
from aos_gcs.mission.search.step_work import StepWork
from aos_gcs.mission.suspending import SuspensionState


class Sweeping:
    """Flies sweeps, and stops them.

    Args:
        context: context of the flight.
        vision: takes in the frames.
        sampler: places them.
        work: works on them.
        pace: pace of the cameras in flight.
        suspension: whether to stop before the next step.
    """

    def __init__(
        self,
        context: FlightContext,
        vision: Vision,
        sampler: Sampler,
        work: StepWork,
        *,
        pace: CameraPace,
        suspension: SuspensionState,
    ) -> None:
        self._context = context
        self._vision = vision
        self._sampler = sampler
        self._work = work
        self._pace = pace
        self._suspension = suspension
        self.is_under_way = False
        """Whether vehicles may still fly to waypoints of a sweep."""
        self.frames = FramesInFlight(context.settings, context.journal)
        """Whether the search may sweep, by the frames that come."""

    async def fly(self, waypoints: Sequence[WaypointRecord]) -> Phase:
        """Fly a sweep from its first waypoints on, until something ends it; return the phase that follows.

        Where that is the scan, all vehicles hover.
        """
        following = Phase.SCAN
        if self._suspension.is_on:
            return following
        self.is_under_way = True
        async with exposing(self._context, self._sampler, self._pace) as exposures:
            flight = SweepCommands(self._context, exposures, self._swarm)
            flight.send(waypoints)
            watch = exposures.start(flight.watch(lambda: self._work.step))
            while self.is_under_way and following is Phase.SCAN and not self._suspension.is_on:
                following = await self._make_step(flight, exposures)
            watch.cancel()
            flight.give_way()
        if following is Phase.SCAN:
            await self.stop()
        return following

    async def stop(self) -> None:
        """Have the vehicles hover where they come to a stop, if they sweep; one that must not be sent there holds."""
        if not self.is_under_way:
            return
        self.is_under_way = False
        waypoints = places_to_stop(self._context, self._swarm())
        await self._context.flight.send(waypoints)
        await self._work.await_arrival(waypoints)

    def sent_elsewhere(self) -> None:
        """Note that all vehicles have been sent elsewhere, so that none needs to be stopped."""
        self.is_under_way = False

    def _swarm(self) -> list[Member]:
        return self._context.roster.members(Task.SWARM)

    async def _end(self, flight: SweepCommands) -> None:
        """Have the vehicles hover, and send no more of the sweep."""
        flight.give_way()
        await self.stop()

    async def _make_step(self, flight: SweepCommands, exposures: Exposures) -> Phase:
        """Make a step by the next round of frames; where there is none, the sweep stops."""
        context, work = self._context, self._work
        if len(swarm := self._swarm()) < context.settings.fewest_vehicles:
            await self._end(flight)
            return Phase.SCAN
        exposures.follow(swarm)
        if (taken := await exposures.round()) is None:
            trouble = exposures.trouble
            self.frames.note_silence(f"No frame has come in flight for {exposures.blind_s:g} s ({trouble})")
            await self._end(flight)
            return Phase.SCAN
        self.frames.note_round()
        work.begin_step()
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
