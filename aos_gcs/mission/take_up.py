"""Taking up a former flight: its vehicles are attached in the air, and an operator decides what follows."""

from __future__ import annotations

import asyncio
from typing import Protocol

import numpy as np

from aos_gcs.airspace.reference_surface import LEVEL
from aos_gcs.errors import ConfigurationError
from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.former_flight import FormerFlight
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.phases import BEFORE_START
from aos_gcs.mission.preflight.terrain import survey_terrain
from aos_gcs.mission.sortie import Sortie, TakenUp
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Severity

_POLL_S = 0.5


class TakingUp(Protocol):
    """The coordinator as a former flight sees it."""

    phase: Phase

    @property
    def sortie(self) -> Sortie:
        """The sortie by the present plan."""
        ...

    def go_on_held(self, settings: MissionSettings, taken_up: TakenUp) -> None:
        """Go on with a flight in the air by these settings, held."""
        ...


class TakeUp:
    """Takes up a former flight as soon as one of its vehicles is heard in the air before the start.

    Args:
        context: the mission's context.
        flow: the sequence of phases that takes the flight up.
        former: flight to be taken up; None: there is none.
    """

    def __init__(self, context: MissionContext, flow: TakingUp, former: FormerFlight | None) -> None:
        self._context = context
        self._flow = flow
        self._former = former

    async def run(self) -> None:
        """Take the flight up, then attach its vehicles as they are heard, until cancelled; end where it is none."""
        former, context = self._former, self._context
        while former is not None and not former.flying(context.roster):
            if self._flow.phase not in BEFORE_START:
                return
            await context.clock.sleep(_POLL_S)
        if former is None or not self._take_up(former):
            return
        await self._survey_terrain(former)
        while True:
            await context.clock.sleep(_POLL_S)
            self._attach(former)

    async def _survey_terrain(self, former: FormerFlight) -> None:
        """Limit the heights above the ground, too; a model that cannot be used any more is reported."""
        context, roster = self._flow.sortie.context, self._context.roster
        terrain, limits, frame = context.settings.terrain, context.bounds.limits, roster.frame
        if terrain is None or limits is None or frame is None:
            return
        homes_enu_m = {key: np.array(one.home_enu_m) for key, one in former.vehicles.items()}
        found = await asyncio.to_thread(survey_terrain, context.settings, terrain, frame.origin, limits, homes_enu_m)
        context.bounds.set(found.limits, found.ground)
        roster.layers.surface = found.surface
        for check in found.checks:
            self._context.journal.notice(Severity.WARNING, f"terrain: {check.text}")
        if found.ground is None:
            text = "Heights above the ground are not checked: the elevation model cannot be used"
            if terrain.follow:
                text += ". The altitude layers follow it: the vehicles cannot go on. Return or land them"
            self._context.journal.notice(Severity.CRITICAL, text)

    def _attach(self, former: FormerFlight) -> None:
        for member in former.attach(self._context.roster):
            text = f"taken up in the air, in its layer at {member.layer_height_m:g} m"
            if member.former_takeover:
                text += f"; it was taken over before: {member.former_takeover}. Resume this vehicle alone"
            self._context.journal.notice(Severity.WARNING, text, member.vehicle_id)

    def _take_up(self, former: FormerFlight) -> bool:
        """Go on with the former flight, held; return whether it can be."""
        journal, mission_id = self._context.journal, former.last.mission_id
        try:
            settings = former.settings(self._flow.sortie.context.settings)
            limits = former.limits(settings)
        except ConfigurationError:
            limits = None
        origin = former.last.origin
        if limits is None or origin is None or self._flow.phase not in BEFORE_START:
            text = f"Mission {mission_id} cannot be taken up: the plan has changed. Return or land its vehicles"
            journal.notice(Severity.CRITICAL, text)
            return False
        self._context.roster.move_origin(origin)
        self._context.roster.ground = former.ground()
        self._context.roster.layers.surface = None if settings.layers_follow_ground else LEVEL
        self._flow.go_on_held(settings, TakenUp(limits, former.legs, former.last.leg, former.last.left_for_later))
        self._attach(former)
        journal.start_timing(former.last.elapsed_s)
        journal.set_message(f"Mission {mission_id} taken up in the air. Resume, return or land.")
        journal.notice(Severity.CRITICAL, journal.message)
        return True
