"""The latest rasters of a mission, ready to show."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

from aos_gcs.imaging.model import StepAnalysis
from aos_gcs.imaging.pictures import RasterPicture, render_pictures
from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.model import EventKind, Picture, PictureKind, PicturesRecord


class Gallery:
    """Renders a step's rasters in a worker thread and keeps the latest of each kind."""

    def __init__(self, context: MissionContext) -> None:
        self._context = context
        self._pictures: dict[PictureKind, Picture] = {}

    async def hang(self, step: int, analysis: StepAnalysis, bands: tuple[str, ...]) -> None:
        """Render the rasters of a step and show them."""
        await self.show(step, await asyncio.to_thread(render_pictures, analysis, bands))

    async def show(self, step: int, rasters: Sequence[RasterPicture]) -> None:
        """Keep rasters that share their bounds, tell everybody that they are there, and record them."""
        pictures = [
            Picture(
                PictureKind(raster.kind), step, raster.png, raster.west_m, raster.south_m, raster.east_m, raster.north_m
            )
            for raster in rasters
        ]
        self._pictures |= {picture.kind: picture for picture in pictures}
        first, journal = pictures[0], self._context.journal
        journal.publish(
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
        async with journal.patience(f"pictures of step {step}"):
            for picture in pictures:
                await self._context.recorder.record_picture(picture)

    def latest(self, kind: PictureKind) -> Picture | None:
        """Return the latest raster of a kind, if there is one."""
        return self._pictures.get(kind)
