"""Conduct of a split swarm: some vehicles look closely, step by step, while the others scan on in flight.

Both go on side by side; the group that has the turn of :class:`~aos_gcs.mission.search.step_work.StepWork` numbers a
step, decides and sends.
"""

from __future__ import annotations

import math

import numpy as np

from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.layers import in_layers
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.handler_watch import WORK_S, sign_of_life
from aos_gcs.mission.model.decisions import Group
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.search.decisions.decider import Decider
from aos_gcs.mission.search.decisions.split import Split
from aos_gcs.mission.search.frames.sampling import Sample, Sampler
from aos_gcs.mission.search.frames.vision import Vision
from aos_gcs.mission.search.in_flight.camera_pace import CameraPace
from aos_gcs.mission.search.in_flight.commands import SweepCommands, places_to_stop
from aos_gcs.mission.search.in_flight.exposing import Exposures, exposing
from aos_gcs.mission.search.step_work import StepWork, Worked
from aos_gcs.mission.suspending import SuspensionState
from aos_gcs.planning.legs import ScanLeg, leg_formation
from aos_gcs.planning.search_settings import MIN_SWARM
from aos_gcs.ports import Goto, Severity

NEAR_M = 10.0
"""Distance behind the line of the others from which both form one."""
_AIM_S = 1.0
"""Time after which the vehicles that fly after it are aimed anew."""
_SHARE = 0.8
"""Share of the cruise speed that this counts with: accelerating takes its time."""
_POLL_S = 0.2
_GOES_ON = frozenset({Phase.SCAN, Phase.CONVERGE, Phase.FOUND})
"""Phases in which a look goes on; in SCAN it looks for a target that was lost."""


class Splitting:
    """Makes the steps of both groups while the decider has a split.

    Args:
        context: context of the flight.
        vision: sees the frames of the look.
        sampler: takes them.
        work: works on the frames of both groups.
        decider: splits the swarm.
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
        decider: Decider,
        pace: CameraPace,
        suspension: SuspensionState,
    ) -> None:
        self._context = context
        self._vision = vision
        self._sampler = sampler
        self._work = work
        self._decider = decider
        self._pace = pace
        self._suspension = suspension
        self._split: Split | None = None
        """Split whose groups were led last."""
        self._scan_vision = vision
        self._is_formed = False
        """Whether the scanning group has formed its line."""
        self._waits = False
        """Whether the scanning group waits for the others."""
        self.is_under_way = False
        """Whether vehicles may still fly to waypoints far along the leg."""

    @property
    def is_on(self) -> bool:
        """Whether the swarm is split, with enough vehicles left to look."""
        return self._decider.split is not None and len(self._members(Group.LOOK)) >= MIN_SWARM

    async def make_steps(self, phase: Phase) -> Phase:
        """Make the steps of both groups as long as the look is in a phase, and return the one that follows.

        Where the split does not go on, or the look is blind, the scanning group hovers.

        Raises:
            MissionFailedError: the look was blind too often.
        """
        if self._split is not self._decider.split:
            self._split = self._decider.split
            self._is_formed = self._waits = False
            self._scan_vision = self._vision.beside()
        following, blind, progress = phase, list[Sample](), self._decider.progress
        async with exposing(self._context, self._sampler, self._pace) as exposures:
            flight = SweepCommands(self._context, exposures, lambda: self._members(Group.SCAN))
            looks = SweepCommands(self._context, exposures, lambda: self._members(Group.LOOK))
            watch = exposures.start(flight.watch(lambda: self._work.step))
            scan = exposures.start(self._scan(flight, exposures))
            while following is phase and not blind and self.is_on and not self._suspension.is_on:
                worked = await self._look(phase, looks, blind)
                following = phase if worked is None else await self._work.conclude(worked)
            # The others may have ended the last leg meanwhile.
            if following is Phase.LINE and not progress.is_over:
                await self._catch_up(looks)
            sign_of_life(WORK_S)
            async with self._work.turn:
                # No group is in the middle of a decision.
                scan.cancel()
            watch.cancel()
            flight.give_way()
            looks.give_way()
        if following is Phase.LINE and progress.is_over:
            # The scanning group has reached the end of the last leg after the look.
            following = Phase.RETURN
        if following is phase or following not in _GOES_ON or self._suspension.is_on:
            stops = await self.stop()
            if following is phase:
                # All of them may be exposed next.
                await self._work.await_arrival(stops)
        return self._work.count_blind_step(phase, blind[0]) if blind else following

    async def _look(self, phase: Phase, looks: SweepCommands, blind: list[Sample]) -> Worked | None:
        """Decide a step of the close look; where its frames lead to no decision, they are added to those in vain."""
        work, members = self._work, self._members(Group.LOOK)
        count, scanning = len(members), len(self._members(Group.SCAN))
        do = "wait" if self._waits else "scan on"
        self._context.journal.set_message(f"{count} vehicles look closely, {scanning} {do}.")
        taken = await self._sampler.take(work.step + 1, members, lambda _: None)
        sign_of_life(WORK_S)
        async with work.turn:
            work.begin_step()
            async with self._vision.intake(work.step) as intake:
                for capture in taken.captures:
                    intake.add(capture)
            worked = await work.decide_on(
                phase, members, intake, taken, may_sweep=False, group=Group.LOOK, send=looks.send_all
            )
        if worked is None:
            blind.append(taken)
        return worked

    async def _catch_up(self, looks: SweepCommands) -> None:
        """Have the vehicles that looked closely fly after the others, which sweep on, until all form one line."""
        clock, split, leg = self._context.clock, self._decider.split, self._decider.progress.present_leg
        until_s, aim_at_s = clock.now_s() + self._context.settings.deadlines.transfer_s, clock.now_s()
        while split is not None and split.is_catching_up and not self._waits and not self._suspension.is_on:
            sign_of_life()
            behind_m = self._along_m(Group.SCAN, leg) - self._along_m(Group.LOOK, leg)
            if not behind_m > NEAR_M or clock.now_s() >= until_s:
                return
            if clock.now_s() >= aim_at_s:
                aim_at_s = clock.now_s() + _AIM_S
                self._context.journal.set_message("The vehicles that looked closely fly after the line.")
                async with self._work.turn:
                    self._fly_after(looks, behind_m, leg)
            await clock.sleep(_POLL_S)

    def _fly_after(self, looks: SweepCommands, behind_m: float, leg: ScanLeg) -> None:
        """Send the vehicles that looked closely to meet the line of the others on a leg, so far ahead of them now."""
        context = self._context
        members, settings = self._members(Group.LOOK), context.settings.flight
        faster_mps = max(_SHARE * settings.cruise_speed_mps - settings.leg_speed_mps, 1.0)
        meet_m = self._along_m(Group.SCAN, leg) + settings.leg_speed_mps * behind_m / faster_mps
        places_enu_m = leg_formation(
            leg.after(min(meet_m, leg.length_m)),
            context.roster.positions_enu_m(members)[:, :2],
            self._decider.line_spacing_m,
        )
        planned_enu_m = in_layers(members, places_enu_m, context.roster.layers.known_surface())
        looks.send_all(context.flight.vet(planned_enu_m))

    def _along_m(self, group: Group, leg: ScanLeg) -> float:
        """Return how far along a leg a group is; NaN where no vehicle is left of it."""
        if not (members := self._members(group)):
            return math.nan
        offsets_m = self._context.roster.positions_enu_m(members)[:, :2] - np.array(leg.start_enu_m)
        return float((offsets_m @ np.array(leg.direction_enu)).mean())

    async def _scan(self, flight: SweepCommands, exposures: Exposures) -> None:
        """Make the steps of the scanning group, from where its line has formed, until something has it wait."""
        if not self._is_formed:
            await self._context.flight.wait_until(
                lambda: [one for one in self._members(Group.SCAN) if isinstance(one.last_command, Goto)],
                self._context.flight.has_arrived,
                self._context.settings.deadlines.move_s,
            )
            self._is_formed = True
        while not self._waits:
            self._waits = not await self._scan_once(flight, exposures)
        flight.give_way()
        exposures.follow(())
        await self.stop()

    async def _scan_once(self, flight: SweepCommands, exposures: Exposures) -> bool:
        """Make a step of the scanning group; return whether it flies on."""
        work, members = self._work, self._members(Group.SCAN)
        if len(members) < MIN_SWARM:
            return False
        exposures.follow(members)
        if (taken := await exposures.round()) is None:
            text = f"The vehicles that scan on stop and wait for the close look: no frames ({exposures.trouble})"
            self._context.journal.notice(Severity.WARNING, text)
            return False
        async with work.turn:
            self.is_under_way = True
            work.begin_step()
            async with self._scan_vision.intake(work.step) as intake:
                for capture in taken.captures:
                    intake.add(capture, taken.speeds_mps[capture.vehicle_id])
            worked = await work.decide_on(
                Phase.SCAN,
                members,
                intake,
                taken,
                may_sweep=True,
                sweep=flight,
                group=Group.SCAN,
                vision=self._scan_vision,
            )
            if worked is None:
                return False
            # What may be a person is known of the next frames; without that, a record would not lead to them again.
            judged = await self._scan_vision.learn(worked.step, worked.analysis, {})
        return worked.decision.is_sweep and judged is not None

    async def stop(self) -> tuple[WaypointRecord, ...]:
        """Have the scanning group hover where it stops, and return where; vehicles that must not be sent there hold."""
        if not self.is_under_way:
            return ()
        stops = places_to_stop(self._context, self._members(Group.SCAN))
        await self._context.flight.send(stops)
        self.is_under_way = False
        return stops

    def sent_elsewhere(self) -> None:
        """Note that all vehicles have been sent elsewhere, so that none needs to be stopped."""
        self.is_under_way = False

    def _members(self, group: Group) -> list[Member]:
        """Return the vehicles of a group, as they are now."""
        swarm, split = self._context.roster.members(Task.SWARM), self._decider.split
        look_ids = frozenset[int]() if split is None else split.look_ids
        return [member for member in swarm if (member.vehicle_id in look_ids) is (group is Group.LOOK)]
