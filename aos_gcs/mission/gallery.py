"""The latest rasters of a mission, ready to show."""

from __future__ import annotations

import asyncio

from aos_gcs.imaging.model import StepAnalysis
from aos_gcs.imaging.pictures import render_pictures
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model import EventKind, Picture, PictureKind, PicturesRecord


class Gallery:
    """Renders a step's rasters in a worker thread and keeps the latest of each kind."""

    def __init__(self, journal: Journal) -> None:
        self._journal = journal
        self._pictures: dict[PictureKind, Picture] = {}

    async def hang(self, step: int, analysis: StepAnalysis, bands: tuple[str, ...]) -> None:
        """Render the rasters of a step and tell everybody that they are there."""
        rasters = await asyncio.to_thread(render_pictures, analysis, bands)
        for raster in rasters:
            kind = PictureKind(raster.kind)
            self._pictures[kind] = Picture(
                kind, step, raster.png, raster.west_m, raster.south_m, raster.east_m, raster.north_m
            )
        first = rasters[0]
        self._journal.publish(
            EventKind.PICTURES,
            PicturesRecord(
                step,
                tuple(PictureKind(raster.kind) for raster in rasters),
                first.west_m,
                first.south_m,
                first.east_m,
                first.north_m,
            ),
        )

    def latest(self, kind: PictureKind) -> Picture | None:
        """Return the latest raster of a kind, if there is one."""
        return self._pictures.get(kind)
