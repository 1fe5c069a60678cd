"""Latest pictures of a mission, ready to show."""

from __future__ import annotations

from collections.abc import Sequence

from aos_gcs.errors import WorkerError
from aos_gcs.imaging.model import Frame, StepAnalysis
from aos_gcs.imaging.pictures import RasterPicture, render_pictures
from aos_gcs.mission.journal import Journal, Recorder
from aos_gcs.mission.model.events import EventKind, PicturesRecord
from aos_gcs.mission.model.steps import Picture, PictureKind
from aos_gcs.ports import Severity, Worker


class Gallery:
    """Has a step's rasters rendered and keeps the latest of each kind; one that is not open does nothing."""

    def __init__(self, journal: Journal, recorder: Recorder, imaging: Worker, *, is_open: bool = True) -> None:
        self.is_open = is_open
        self._imaging = imaging
        self._journal = journal
        self._recorder = recorder
        self._pictures: dict[PictureKind, Picture] = {}

    async def render(self, step: int, frames: Sequence[Frame], analysis: StepAnalysis) -> None:
        """Render the rasters of a step, of the frames that took part in its analysis, and publish them."""
        if not self.is_open:
            return
        try:
            rasters = await self._imaging.run(render_pictures, frames, analysis)
        except WorkerError as error:
            self._journal.notice(Severity.WARNING, f"Step {step}: no pictures: {error}")
            return
        await self.publish(step, rasters)

    async def publish(self, step: int, rasters: Sequence[RasterPicture]) -> None:
        """Keep rasters that share their bounds, announce them on the event stream, and record them."""
        if not self.is_open:
            return
        pictures = [
            Picture(
                PictureKind(raster.kind), step, raster.png, raster.west_m, raster.south_m, raster.east_m, raster.north_m
            )
            for raster in rasters
        ]
        self._pictures |= {picture.kind: picture for picture in pictures}
        first = pictures[0]
        self._journal.publish(
            EventKind.PICTURES,
            PicturesRecord(
                step,
                tuple(picture.kind for picture in pictures),
                first.west_m,
                first.south_m,
                first.east_m,
                first.north_m,
            ),
        )
        async with self._journal.with_disk_timeout(f"pictures of step {step}"):
            for picture in pictures:
                await self._recorder.record_picture(picture)

    def latest(self, kind: PictureKind) -> Picture | None:
        """Return the latest raster of a kind, if there is one."""
        return self._pictures.get(kind)
