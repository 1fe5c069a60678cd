"""Map of the searched ground: fed with frames as they are used, in a process of its own, for which nothing waits.

Buffered: yes, ``MAX_WAITING`` frames, or those of one step of a larger swarm; when full: the oldest are left out and
counted.
"""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from aos_gcs.airspace.terrain import GroundRaster
from aos_gcs.errors import AosError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.groundmap.directions import USUAL_STEP, direction_step
from aos_gcs.groundmap.figures import GroundFigures
from aos_gcs.groundmap.shading import prior_picture
from aos_gcs.groundmap.work import GroundReport, GroundSource, SearchedArea, add_frames
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.search.gallery import Gallery
from aos_gcs.mission.search.ground.known_prior import KnownPrior
from aos_gcs.planning.gaps import GapLegs, legs_for_gaps
from aos_gcs.planning.leg_order import chances_of, order_legs, ordered_on_map
from aos_gcs.planning.legs import ScanLeg, in_passes
from aos_gcs.planning.plan import MissionPlan, plan_of
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.planning.terrain.viewed_ground import viewed_ground
from aos_gcs.ports import Severity, Worker
from aos_gcs.prior.model import AreaPrior

_log = logging.getLogger(__name__)

MAX_WAITING: Final = 32
"""Frames that may wait; one of 512 x 512 pixels and four bands takes 4 MiB."""
_BATCH: Final = 10
"""Frames that are added with one call."""
_PICTURE_S: Final = 1.0
"""Least time between two pictures of the map, real seconds."""
_FLUSH_S: Final = 5.0
"""Time after which what has changed is written, real seconds."""
_AGE_S: Final = 10.0
"""Time after which figures are told anew where views are forgotten, real seconds."""
_POLL_S: Final = 0.5
LOOK_AHEAD_S: Final = 600.0
"""Time of flight whose gain is told."""
_FINISH_S: Final = 5.0
"""Time limit for the last frames, real seconds."""


@dataclass(frozen=True, slots=True)
class GroundPlace:
    """Folder and worker of a mission's map."""

    worker: Worker
    folder: Path
    carried: Path | None = None
    """Folder of the former sortie's map, which goes on; None: there is none."""
    interrupted: Path | None = None
    """Folder of the map of a flight that may be taken up; it goes on when it is."""


class GroundMapping:
    """Keeps the map of the searched ground and publishes it.

    Args:
        place: where it is kept; None: there is no such map.
        context: its roster knows the origin of the mission's frame, its journal tells operators what is missing.
        gallery: publishes the pictures.
        settings: returns the settings that the mission flies by.
        ground: returns the ground of the elevation model, as the vehicles see it; None: it counts as level.
    """

    def __init__(
        self,
        place: GroundPlace | None,
        context: MissionContext,
        gallery: Gallery,
        *,
        settings: Callable[[], MissionSettings],
        ground: Callable[[], GroundRaster | None],
    ) -> None:
        self._place = place
        self._clock = context.clock
        self._roster = context.roster
        self._journal = context.journal
        self._gallery = gallery
        self._settings = settings
        self._ground = ground
        self._prior = KnownPrior(settings, context.journal)
        self._waiting: deque[tuple[int, tuple[Frame, FocalSurface, float]]] = deque()
        """Steps, and their frames with surface and UTC time."""
        self._is_offered = asyncio.Event()
        self._is_added = asyncio.Event()
        """Set while no offered frame is still to be added."""
        self._is_added.set()
        self._known: tuple[GroundSource, SearchedArea] | None = None
        """Map and area of the latest figures."""
        self._figures: GroundFigures | None = None
        self._soon: float | None = None
        self._left_out = 0
        self._step = 0
        """Step of the latest frame on the map."""
        self._shown_prior: AreaPrior | None = None
        self._is_pictured = self._is_flushed = True
        self._pictured_at_s = self._flushed_at_s = self._told_at_s = -_FLUSH_S
        self._problem = ""

    @property
    def is_on(self) -> bool:
        """Whether there is such a map."""
        return self._place is not None

    @property
    def figures(self) -> GroundFigures | None:
        """Latest figures; None before the first ones, and where there is no map."""
        if self._figures is None:
            return None
        return replace(self._figures, left_out=self._left_out, soon=self._soon)

    async def order_legs(
        self, plan: MissionPlan, legs: Sequence[ScanLeg], from_m: tuple[float, float]
    ) -> tuple[ScanLeg, ...]:
        """Return legs, in all passes, in the order in which the person is likely to be noticed soonest.

        Where that cannot be found out, they stay as they are, and operators are told.

        Args:
            plan: plan of the mission, with the vehicles that fly.
            legs: legs of one pass to and fro.
            from_m: place that the swarm comes from.
        """
        frame, height_m = self._roster.frame, self._settings().imaging.plane_height_m
        if frame is None:
            return in_passes(legs, plan.passes)
        try:
            area = await self._area(frame.origin)
            if self._place is None:
                return await asyncio.to_thread(
                    lambda: order_legs(legs, plan, chances_of(plan, height_m, area.prior), from_m)
                )
            source = self._source(self._place, frame.origin)
            return await self._place.worker.run(
                ordered_on_map, source, area, plan, height_m, legs=tuple(legs), from_m=from_m, since_s=self._since_s
            )
        except Exception as error:  # whatever it is: a defect of the order must not end the flight
            if not isinstance(error, AosError):
                _log.exception("a defect of the order of legs")
            self._report(f"The legs are flown to and fro, not in the order of their chances: {error}")
            return in_passes(legs, plan.passes)

    async def find_gaps(self, plan: MissionPlan, from_m: tuple[float, float], within_s: float) -> GapLegs | None:
        """Return the stretches whose views gain most until the plan's wanted probability of detection is reached.

        Waits for the frames that are still to be added, for some seconds.

        Args:
            plan: plan of the mission, with the vehicles that fly.
            from_m: place that the swarm comes from.
            within_s: time that they may take.

        Returns:
            None where there is no map, or it cannot be asked.
        """
        with suppress(TimeoutError):
            async with asyncio.timeout(_FINISH_S):
                await self._is_added.wait()
        return await self._ask_for_gaps(plan, from_m, within_s)

    async def _ask_for_gaps(self, plan: MissionPlan, from_m: tuple[float, float], within_s: float) -> GapLegs | None:
        if self._place is None or self._known is None:
            return None
        pod = 1.0 if plan.pod is None else plan.pod
        settings = self._settings()
        ground = self._ground() if settings.focus_follows_ground else None
        try:
            return await self._place.worker.run(
                legs_for_gaps,
                *self._known,
                plan,
                settings.imaging.plane_height_m,
                from_m=from_m,
                within_s=within_s,
                pod=pod,
                ground=viewed_ground(plan.area_enu_m, ground, self._roster.layers.surface),
                since_s=self._since_s,
            )
        except Exception as error:  # whatever it is: a defect of the map must not end the flight
            if not isinstance(error, AosError):
                _log.exception("a defect of the search for gaps")
            self._report(f"The gaps of the search are not known: {error}")
            return None

    def take_up(self) -> None:
        """Go on with the map of the flight that is taken up."""
        if self._place is not None and self._place.interrupted is not None:
            self._place = replace(self._place, carried=self._place.interrupted)

    def offer(self, step: int, frames: Sequence[Frame], surface: FocalSurface) -> None:
        """Have frames of a step added; nobody waits for it.

        Args:
            step: number of the step.
            frames: frames with the best poses that are known.
            surface: ground that they show.
        """
        if self._place is None:
            return
        # By one clock for all, as the age of what they show is counted by it.
        utc_s = self._clock.utc_s()
        self._waiting += [(step, (frame, surface, utc_s)) for frame in frames]
        # A step's own frames are in memory anyway: a large swarm must not lose some of each step.
        while len(self._waiting) > max(MAX_WAITING, len(frames)):
            self._waiting.popleft()
            self._left_out += 1
            self._report("The map of searched ground cannot keep up: frames are left out and their views not counted")
        self._is_offered.set()
        self._is_added.clear()

    async def run(self) -> None:
        """Add frames as they are offered, until cancelled."""
        while self._place is not None:
            with suppress(TimeoutError):
                async with asyncio.timeout(_POLL_S):
                    await self._is_offered.wait()
            await self._work(self._place, is_last=False)

    async def finish(self) -> None:
        """Add what still waits and write the map; gives up where that takes too long."""
        if self._place is None or self._known is None:
            return
        with suppress(TimeoutError):
            async with asyncio.timeout(_FINISH_S):
                await self._work(self._place, is_last=True)
                while self._waiting:
                    await self._work(self._place, is_last=True)

    async def _work(self, place: GroundPlace, *, is_last: bool) -> None:
        """Do what is due: add a batch of frames, open the map, draw it, write it."""
        frame, now_s = self._roster.frame, asyncio.get_running_loop().time()
        if frame is None:
            return
        known = self._source(place, frame.origin), await self._area(frame.origin)
        await self._show_prior(known[1].prior)
        batch = [self._waiting.popleft() for _ in range(min(_BATCH, len(self._waiting)))]
        if not self._waiting:
            self._is_offered.clear()
        if not batch:
            self._is_added.set()
        if batch or known != self._known:
            self._is_pictured = False
        self._is_flushed = self._is_flushed and not batch
        draws = (
            self._gallery.is_open and not self._is_pictured and (is_last or now_s >= self._pictured_at_s + _PICTURE_S)
        )
        writes = not self._is_flushed and (is_last or now_s >= self._flushed_at_s + _FLUSH_S)
        since_s = self._since_s
        ages = since_s is not None and now_s >= self._told_at_s + _AGE_S
        if not (batch or draws or writes or ages or known != self._known):
            return
        self._step = max([self._step, *(step for step, _ in batch)])
        frames = [frame for _, frame in batch]
        self._known, self._is_pictured, self._told_at_s = known, self._is_pictured or draws, now_s
        if draws:
            self._pictured_at_s = now_s
        if writes:
            self._is_flushed, self._flushed_at_s = True, now_s
        try:
            report = await place.worker.run(
                add_frames, known[0], frames, known[1], pictures=draws, flush=writes, since_s=since_s
            )
        except Exception as error:  # whatever it is: a defect of the map must not end the flight
            self._left_out += len(batch)
            if not isinstance(error, AosError):
                _log.exception("a defect of the map of searched ground")
            self._report(f"The map of searched ground is not up to date: {error}")
            return
        self._take(report, len(batch))
        if (writes or ages) and not is_last:
            await self._look_ahead()
        if report.pictures:
            await self._gallery.publish(self._step, report.pictures)
        if report.floor is not None:
            self._is_pictured = self._is_pictured and report.is_floor_whole
            # Apart from the others: it has bounds of its own.
            await self._gallery.publish(self._step, (report.floor,))

    async def _show_prior(self, prior: AreaPrior | None) -> None:
        """Publish the picture of a prior that has not been shown yet."""
        if prior is None or prior is self._shown_prior or not self._gallery.is_open:
            return
        self._shown_prior = prior
        await self._gallery.publish(self._step, (await asyncio.to_thread(prior_picture, prior),))

    async def _look_ahead(self) -> None:
        """Find out what ten more minutes would gain."""
        settings = self._settings()
        if settings.forest is None:
            self._soon = None
            return
        plan = replace(plan_of(settings), pod=None)
        found = await self._ask_for_gaps(plan, settings.area_enu_m[0], LOOK_AHEAD_S)
        self._soon = None if found is None else found.detection_after

    def _take(self, report: GroundReport, added: int) -> None:
        """Take over a report on the map with so many frames more."""
        figures, former = report.figures, self._figures
        self._left_out += figures.left_out
        expected = 0 if former is None else former.frames + added - figures.left_out
        if figures.frames < expected:
            self._left_out += expected - figures.frames
            self._report("The map of searched ground has lost frames with its process: their views are not counted")
        if report.unwritten:
            self._is_flushed = False
            self._report(report.unwritten)
        if former is not None and not report.has_parts:
            figures = replace(figures, segments=former.segments, success=former.success)
        if former is not None and not added and figures.mean_views != former.mean_views:
            self._is_pictured = False  # views were forgotten
        self._figures = figures

    @property
    def _since_s(self) -> float | None:
        """UTC time from which on views count; None: all count."""
        return self._settings().search.views_since_s(self._clock.utc_s())

    def _report(self, problem: str) -> None:
        """Tell operators a problem, once for as long as it is the latest one."""
        if problem != self._problem:
            self._problem = problem
            self._journal.notice(Severity.WARNING, problem)

    def _source(self, place: GroundPlace, origin: GeodeticPosition) -> GroundSource:
        forest = self._settings().forest
        step = USUAL_STEP
        if forest is not None:
            step = direction_step(forest.crown_base_m, forest.canopy_height_m, forest.occluder_size_m)
        return GroundSource(place.folder, origin, step, place.carried)

    async def _area(self, origin: GeodeticPosition) -> SearchedArea:
        settings = self._settings()
        occlusion = None if settings.forest is None else settings.forest.occlusion
        prior, segments = await self._prior.over(origin), await self._prior.segments(origin)
        return SearchedArea(settings.area_enu_m, occlusion, prior, segments)
