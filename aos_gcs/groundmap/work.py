"""Work on the searched ground for a worker: functions that open the map of a folder, add frames and report.

A worker remembers the map that it has opened. One that replaces another finds it as it was written last.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

from aos_gcs.errors import ImagingError, RecordingError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.groundmap.figures import GroundFigures, Polygon, ViewRaster, ground_figures, view_raster
from aos_gcs.groundmap.ground_map import GroundMap, open_map
from aos_gcs.groundmap.segments import segment_figures, success_of
from aos_gcs.groundmap.shading import ground_pictures
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.pictures import RasterPicture
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.prior.model import AreaPrior
from aos_gcs.prior.segments import Segment


@dataclass(frozen=True, slots=True)
class GroundSource:
    """Identity of a map."""

    folder: Path
    origin: GeodeticPosition
    direction_step: float
    carried: Path | None
    """Folder of the former sortie's map; None: there is none."""


@dataclass(frozen=True, slots=True)
class SearchedArea:
    """What figures and pictures are made for."""

    area_enu_m: Polygon
    occlusion: float | None
    """Share of the ground that one image does not see; None where the forest is not described."""
    prior: AreaPrior | None = None
    """Probability by place in the area; None: all places are as likely."""
    segments: tuple[Segment, ...] = ()
    """Parts of the ground whose figures are told one by one."""


@dataclass(frozen=True, slots=True)
class GroundReport:
    """State of the map after some work."""

    figures: GroundFigures
    """Figures in which these frames alone are left out that could not be used."""
    pictures: tuple[RasterPicture, ...]
    """Pictures of the map; empty where none were asked for, or nothing was searched."""
    floor: RasterPicture | None
    """Picture of the forest floor; None where none was asked for, or nothing was searched."""
    is_floor_whole: bool
    """Whether that has all tiles; the next one has more of them."""
    unwritten: str
    """Why the map on the disk lacks something; empty otherwise."""
    has_parts: bool
    """Whether the figures have segments and the probability of success: not for every batch, as they take longer."""


@lru_cache(maxsize=1)
def opened_map(source: GroundSource) -> GroundMap:
    """Return a map, which this worker opens once."""
    return open_map(source.folder, source.origin, source.direction_step, source.carried)


def add_frames(
    source: GroundSource,
    frames: Sequence[tuple[Frame, FocalSurface, float]],
    area: SearchedArea,
    *,
    pictures: bool,
    flush: bool,
    since_s: float | None = None,
) -> GroundReport:
    """Add frames to a map, each on its surface, and report on it.

    Args:
        source: map.
        frames: frames with their surfaces and the UTC times at which they were taken; may be empty.
        area: search area of the mission.
        pictures: whether to render the map.
        flush: whether to write it.
        since_s: UTC time from which on views count; None: all count.

    Raises:
        InputDataError: its folder holds another map, or a damaged one.
        RecordingError: a former map cannot be copied.
    """
    ground, left_out, unwritten = opened_map(source), 0, ""
    for frame, surface, utc_s in frames:
        try:
            ground.add(frame, surface, utc_s, since_s)
        except ImagingError:
            left_out += 1
        except RecordingError as error:
            left_out, unwritten = left_out + 1, str(error)
    try:
        if flush:
            ground.flush()
    except RecordingError as error:
        unwritten = str(error)
    raster = view_raster(ground.views_since(since_s), area.area_enu_m)
    figures = ground_figures(raster, area.area_enu_m, area.occlusion, ground.header.frames, left_out)
    has_parts = flush or not frames
    if has_parts:
        figures = with_parts(figures, raster, area)
    rendered = ground_pictures(raster, area.occlusion) if pictures and ground.views else ()
    floor = ground.floor() if pictures else None
    return GroundReport(
        figures=figures,
        pictures=rendered,
        floor=None if floor is None else floor.picture(),
        is_floor_whole=floor is None or not floor.stale,
        unwritten=unwritten,
        has_parts=has_parts,
    )


def with_parts(figures: GroundFigures, raster: ViewRaster, area: SearchedArea) -> GroundFigures:
    """Return figures with those of segments, and with the probability of success."""
    return replace(
        figures,
        success=success_of(raster, area.occlusion, area.prior),
        segments=segment_figures(raster, area.segments, area.occlusion, area.prior),
    )
