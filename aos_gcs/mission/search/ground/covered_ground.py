"""Coverage of the ground by the frames of the search, per camera and on the map of the area."""

from __future__ import annotations

from collections.abc import Sequence

from aos_gcs.airspace.polygon import Polygon
from aos_gcs.errors import WorkerError
from aos_gcs.geometry.projection import Plane
from aos_gcs.imaging.model import Frame, StepAnalysis
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.handler_watch import WORK_S, sign_of_life
from aos_gcs.mission.search.frames.cameras import CameraLog, footprint_enu_m
from aos_gcs.mission.search.frames.ground_in_view import ground_in_view
from aos_gcs.mission.search.frames.sampling import Sample, to_frame
from aos_gcs.mission.search.gallery import Gallery
from aos_gcs.mission.search.ground.coverage import CoverageMap, add_footprints
from aos_gcs.mission.search.ground.mapping import GroundMapping
from aos_gcs.ports import Severity


class CoveredGround:
    """Notes the footprints of each step's frames and publishes the map of what has been covered.

    Args:
        context: context of the flight.
        gallery: publishes the pictures.
        ground: map of the searched ground, which gets the frames, too.
    """

    def __init__(self, context: FlightContext, gallery: Gallery, ground: GroundMapping) -> None:
        self._context = context
        self._gallery = gallery
        self._ground = ground
        self._coverage: CoverageMap | None = None
        self._uncounted: list[Polygon] = []
        """Footprints that are not on the map yet."""
        self.cameras = CameraLog()

    @property
    def covered_fraction(self) -> float | None:
        """Share of the search area that was in a frame; None before the first step."""
        return None if self._coverage is None else self._coverage.covered_fraction

    @property
    def usable_fraction(self) -> float | None:
        """The same, but what the map of searched ground shows where most frames could not be put on it."""
        covered, figures = self.covered_fraction, self._ground.figures
        if covered is None or figures is None or figures.left_out <= figures.frames:
            return covered
        return min(covered, figures.seen_fraction)

    async def note(self, step: int, taken: Sample, analysis: StepAnalysis, placed: Sequence[Frame]) -> None:
        """Note what the frames of a step show of the area, and publish the map.

        Args:
            step: number of the step.
            taken: its frames.
            analysis: their analysis.
            placed: frames that took part in it, with the poses by which they were placed.
        """
        context = self._context
        self._map(step, analysis, placed)
        frame = context.roster.local_frame()
        frames = [to_frame(capture, frame) for capture in taken.captures]
        footprints = [footprint_enu_m(one, analysis.grid.height_m) for one in frames]
        self.cameras.note(step, frames, footprints, taken.missing)
        if self._coverage is None:
            forest = context.settings.forest
            self._coverage = CoverageMap(context.settings.area_enu_m, None if forest is None else forest.occlusion)
        self._uncounted += footprints
        sign_of_life(WORK_S)
        try:
            counts, pictures = await context.imaging.run(
                add_footprints, self._coverage, self._uncounted, pictures=self._gallery.is_open
            )
        except WorkerError as error:
            context.journal.notice(Severity.WARNING, f"Step {step}: the map of coverage is not up to date: {error}")
            return
        self._coverage.set_counts(counts)
        self._uncounted = []
        await self._gallery.publish(step, pictures)

    def _map(self, step: int, analysis: StepAnalysis, placed: Sequence[Frame]) -> None:
        """Hand frames over to the map of the searched ground."""
        if self._ground.is_on:
            ground = ground_in_view(self._context.settings, self._context.bounds.ground, analysis.grid)
            self._ground.offer(step, placed, Plane(analysis.grid.height_m) if ground is None else ground)
