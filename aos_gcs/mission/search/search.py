"""The search: form the line, then step after step sample, see, decide, act, publish."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.mission.context import FlightContext, MissionContext
from aos_gcs.mission.fleet.layers import in_layers
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.handler_watch import WORK_S, sign_of_life
from aos_gcs.mission.model.decisions import LeftPlace
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.search.decisions.decider import Decider
from aos_gcs.mission.search.frames.sampling import Sampler
from aos_gcs.mission.search.frames.vision import Vision
from aos_gcs.mission.search.gallery import Gallery
from aos_gcs.mission.search.ground.covered_ground import CoveredGround
from aos_gcs.mission.search.ground.mapping import GroundMapping
from aos_gcs.mission.search.in_flight.camera_pace import CameraPace
from aos_gcs.mission.search.in_flight.splitting import Splitting
from aos_gcs.mission.search.in_flight.sweeping import Sweeping
from aos_gcs.mission.search.scan.gap_flights import GapFlights
from aos_gcs.mission.search.scan.progress import time_on_legs_s
from aos_gcs.mission.search.step_work import StepWork
from aos_gcs.mission.search.strength import SwarmStrength
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.planning.detection.mixed_line import mixed_formation
from aos_gcs.planning.legs import ScanLeg, leg_formation, scan_legs
from aos_gcs.planning.plan import plan_of
from aos_gcs.ports import Capture, Severity


class Search:
    """The phases LINE, SCAN, CONVERGE and FOUND.

    Args:
        context: context of the flight.
        mission: records the steps, measures the event loop, and knows whether it is suspended.
        gallery: publishes the pictures.
        vision: analyses the frames.
        findings: findings of the mission.
        ground: map of the searched ground.
        may_be_relieved: returns whether a vehicle on the ground may take off for the swarm, now or later.
        left_for_later: places that were left for a later look before.
    """

    def __init__(
        self,
        context: FlightContext,
        mission: MissionContext,
        gallery: Gallery,
        vision: Vision,
        findings: Findings,
        *,
        ground: GroundMapping,
        may_be_relieved: Callable[[], bool],
        left_for_later: Sequence[LeftPlace] = (),
    ) -> None:
        self._context = context
        self._vision = vision
        self._ground = ground
        self._sampler = Sampler(context)
        self.covered_ground = CoveredGround(context, gallery, ground)
        self.decider = Decider(
            context.settings,
            context.journal,
            findings,
            left_for_later=left_for_later,
            forget=vision.forget,
            covered_fraction=lambda: self.covered_ground.usable_fraction,
        )
        self._work = StepWork(
            context,
            mission,
            gallery,
            vision,
            findings,
            decider=self.decider,
            sampler=self._sampler,
            covered_ground=self.covered_ground,
        )
        pace, suspension = CameraPace(context.settings.imaging, context.journal), mission.suspension
        self._sweeping = Sweeping(context, vision, self._sampler, self._work, pace=pace, suspension=suspension)
        self._splitting = Splitting(
            context, vision, self._sampler, self._work, decider=self.decider, pace=pace, suspension=suspension
        )
        self._strength = SwarmStrength(
            context,
            covered_fraction=lambda: self.covered_ground.covered_fraction,
            may_be_relieved=may_be_relieved,
        )
        self._on_legs_s, self._steps_counted = 0.0, 0
        self._gaps = GapFlights(context, ground, self.decider.progress)

    @property
    def step(self) -> int:
        """Number of the latest step."""
        return self._work.step

    @property
    def flies_on(self) -> bool:
        """Whether vehicles may still fly to waypoints far along the leg."""
        return self._sweeping.is_under_way or self._splitting.is_under_way

    async def rest(self) -> None:
        """Have vehicles that scan on hover: the mission is paused, and nothing leads them."""
        await self._splitting.stop()

    def time_left_s(self) -> float | None:
        """Return how long the rest of the search takes at the pace so far; None while that is not known."""
        steps, first = self._context.journal.steps, max(0, self._steps_counted - 1)
        # Each pair of steps is looked at once: a search of hours has tens of thousands.
        self._on_legs_s += time_on_legs_s(steps[first:])
        self._steps_counted = len(steps)
        return self.decider.progress.time_left_s(self._on_legs_s) if steps else None

    # --- LINE ---------------------------------------------------------------------------------------------------------

    async def line(self) -> Phase:
        """Form the line at the present place of the present leg."""
        context, progress = self._context, self.decider.progress
        swarm = await self._strength.gather()
        if not swarm:
            return Phase.RETURN
        if not self.decider.choice.is_look_leg and self._gaps.is_enough and not self.decider.goes_on_to_looks():
            return Phase.RETURN
        if not progress.legs:
            progress.plan(await self._plan_legs(swarm))
        leg = progress.remaining_leg
        context.journal.set_message(f"Forming the line for leg {progress.leg + 1} of {len(progress.legs)}.")
        places_enu_m = self._formation(leg, swarm)
        late = await context.flight.transfer(
            in_layers(swarm, places_enu_m, context.roster.layers.known_surface()), frozenset({Task.SWARM})
        )
        self._sweeping.sent_elsewhere()
        self._splitting.sent_elsewhere()
        for member in late:
            context.journal.notice(Severity.WARNING, "did not reach its place in the line in time", member.vehicle_id)
        self.decider.begin_line(leg)
        self._work.log.note_line(leg)
        return Phase.SCAN

    def _formation(self, leg: ScanLeg, swarm: list[Member]) -> NDArray[np.float64]:
        """Return the places of the line at the start of a leg; where a probability is wanted its layers are mixed."""
        positions_enu_m = self._context.roster.positions_enu_m(swarm)[:, :2]
        layers_m = [one.layer_height_m for one in swarm if one.layer_height_m is not None]
        wants_views = self._context.settings.search.pod is not None and not self.decider.choice.is_look_leg
        if wants_views and len(layers_m) == len(swarm):
            return mixed_formation(leg, positions_enu_m, layers_m, self.decider.line_spacing_m)
        return leg_formation(leg, positions_enu_m, self.decider.line_spacing_m)

    async def _plan_legs(self, swarm: list[Member]) -> tuple[ScanLeg, ...]:
        """Plan the legs for the vehicles that fly, those first by which the person is likely to be noticed soonest."""
        settings = self._context.settings
        lowest_m = min(member.layer_height_m or settings.flight.lowest_layer_m for member in swarm)
        widest_m = settings.search.leg_spacing_m
        middle_m = self._context.roster.positions_enu_m(swarm)[:, :2].mean(axis=0)
        legs = scan_legs(
            settings.area_enu_m,
            middle_m,
            np.array(settings.scan_direction_enu),
            n=len(swarm),
            spacing_m=self.decider.line_spacing_m,
            footprint_m=2 * (lowest_m - settings.imaging.plane_height_m) * np.tan(settings.planning_fov_rad / 2),
            # A shorter line sees a narrower strip as well as the whole one sees its own.
            leg_spacing_m=None if widest_m is None else widest_m * len(swarm) / max(settings.vehicles, len(swarm)),
        )
        sign_of_life(WORK_S)
        plan = replace(plan_of(settings), vehicles=len(swarm))
        return await self._ground.order_legs(plan, legs, (float(middle_m[0]), float(middle_m[1])))

    # --- SCAN, CONVERGE, FOUND ----------------------------------------------------------------------------------------

    async def make_step(self, phase: Phase) -> Phase:
        """Make one step: sample, see, decide, act, publish; return the phase of the next one.

        Where the decision is to sweep, the steps of the whole sweep are made; where the swarm is split, those of both
        groups as long as the look is in this phase.
        """
        await self._sweeping.stop()
        if not (swarm := await self._strength.gather()):
            return Phase.RETURN
        if self._splitting.is_on:
            following = await self._splitting.make_steps(phase)
        else:
            following = await self._make_step(phase, swarm)
        middle_m = self._context.roster.positions_enu_m(swarm)[:, :2].mean(axis=0)
        return await self._gaps.after(following, len(swarm), middle_m)

    async def _make_step(self, phase: Phase, swarm: list[Member]) -> Phase:
        """Make a step of the whole swarm, and those of the sweep that it begins."""
        work = self._work
        work.begin_step()
        self._context.journal.set_message(f"Step {work.step}: capturing images.")
        clock, took_s = self._context.clock, dict[int, float]()
        begun_s = clock.now_s()

        def take_in(capture: Capture) -> None:
            took_s[capture.vehicle_id] = clock.now_s() - begun_s
            intake.add(capture)

        async with self._vision.intake(work.step) as intake:
            taken = await self._sampler.take(work.step, swarm, take_in)
        self._sweeping.frames.look_at_rest(taken, took_s)
        may_sweep = self._sweeping.frames.is_sweep_allowed and phase is Phase.SCAN
        following, decision = await work.work_on(phase, swarm, intake, taken, may_sweep=may_sweep)
        if decision is not None and decision.is_sweep and following is Phase.SCAN:
            following = await self._sweeping.fly(decision.waypoints)
        return following
