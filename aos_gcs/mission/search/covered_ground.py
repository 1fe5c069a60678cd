"""Coverage of the ground by the frames of the search, per camera and on the map of the area."""

from __future__ import annotations

from aos_gcs.airspace.polygon import Polygon
from aos_gcs.errors import WorkerError
from aos_gcs.imaging.model import StepAnalysis
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.handler_watch import WORK_S, sign_of_life
from aos_gcs.mission.search.cameras import CameraLog, footprint_enu_m
from aos_gcs.mission.search.coverage import CoverageMap, add_footprints
from aos_gcs.mission.search.gallery import Gallery
from aos_gcs.mission.search.sampling import Sample, to_frame
from aos_gcs.ports import Severity


class CoveredGround:
    """Notes the footprints of each step's frames and publishes the map of what has been covered."""

    def __init__(self, context: FlightContext, gallery: Gallery) -> None:
        self._context = context
        self._gallery = gallery
        self._coverage: CoverageMap | None = None
        self._uncounted: list[Polygon] = []
        """Footprints that are not on the map yet."""
        self.cameras = CameraLog()

    @property
    def covered_fraction(self) -> float | None:
        """Share of the search area that was in a frame; None before the first step."""
        return None if self._coverage is None else self._coverage.covered_fraction

    async def note(self, step: int, taken: Sample, analysis: StepAnalysis) -> None:
        """Note what the frames of a step show of the area, and publish the map."""
        context = self._context
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
