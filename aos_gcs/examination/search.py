"""Anomalies on which the frames of a window agree, and what each is taken for.

A drone that takes frames along its way sees what as many vehicles would see at once: every frame counts as one of a
vehicle of its own, and the decision is that of missions.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from aos_gcs.errors import ImagingError
from aos_gcs.imaging.geolocation import Geolocation, Uncertainty
from aos_gcs.imaging.integral import ViewIntegral
from aos_gcs.imaging.model import Frame, GroundRaster
from aos_gcs.imaging.persons.decision import ENOUGH, FindingKind, Verdict
from aos_gcs.imaging.step.examination import ExaminedFrame, examine_all
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.imaging.surfaces.ground import choose_raster
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.mission.search.persons import PersonWatch
from aos_gcs.surveys.anomalies import MapBlob, map_blobs
from aos_gcs.surveys.integration import add_marks
from aos_gcs.surveys.tiles import map_tiles

HEIGHT_STEP_M = 0.5
"""Heights of the ground that are judged as one: half of it displaces by 0.1 m at 25 degrees off nadir."""
FINEST_CELL_M = 0.1
"""Smallest cell of the map on which frames have to agree."""
MAX_CELLS = 16_000_000
"""Largest map of a window; cells become coarser to keep it."""
MAX_JUDGED = 200
"""Anomalies of a window that are judged: those on which most frames agree. More are a detector that does not fit."""


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """What counts as an anomaly, and how well places are known."""

    imaging: ImagingSettings
    minimum_count: int
    """Frames that must mark a cell of the map."""
    minimum_area_m2: float
    """Area from which an anomaly without temperatures counts."""
    uncertainty: Uncertainty


@dataclass(frozen=True, slots=True)
class Candidate:
    """An anomaly and the decision about it."""

    position_enu_m: tuple[float, float, float]
    """Position of the ground below it."""
    verdict: Verdict
    place: Geolocation | None
    """Place of what the decision rests on; None where nothing has one."""
    frames: int
    """Number of frames that agree on it."""


@dataclass(frozen=True, slots=True)
class WindowFound:
    """What the frames of a window show."""

    candidates: tuple[Candidate, ...]
    """What may be a person, or is warm; the clearest first."""
    anomalies: int
    """Number of all anomalies that enough frames agree on."""
    largest_m2: float
    """Area of the largest."""
    left_out: Mapping[int, str]
    """Reason why a frame took no part, by its ``vehicle_id``."""


def search_window(frames: Sequence[Frame], surface: FocalSurface, settings: SearchSettings) -> WindowFound:
    """Return what the frames of a window show. Takes seconds: call it in a thread.

    Args:
        frames: frames in an east-north-up world, each of a vehicle of its own.
        surface: ground.
        settings: see :class:`SearchSettings`.

    Raises:
        ImagingError: if no frame sees the surface, or the detector cannot be applied to any.
    """
    examined = examine_all(frames, settings.imaging)
    left_out = {one.vehicle_id: one.fault or one.undetectable for one in examined if one.fault or one.undetectable}
    usable = [frame for frame in frames if frame.vehicle_id not in left_out]
    if not usable:
        raise ImagingError(f"No frame can be examined: {next(iter(left_out.values()))}.")
    blobs = _agreed(usable, [one for one in examined if one.vehicle_id not in left_out], surface, settings)
    chosen = sorted(blobs, key=lambda blob: -blob.max_count)[:MAX_JUDGED]
    return WindowFound(
        candidates=_judged(usable, chosen, settings),
        anomalies=len(blobs),
        largest_m2=max((blob.area_m2 for blob in blobs), default=0.0),
        left_out=left_out,
    )


def _agreed(
    frames: Sequence[Frame], examined: Sequence[ExaminedFrame], surface: FocalSurface, settings: SearchSettings
) -> list[MapBlob]:
    """Return the anomalies that enough frames mark, the largest first."""
    raster = _raster(frames, surface)
    coverage = np.zeros((raster.rows, raster.columns), dtype=np.uint16)
    count = np.zeros_like(coverage)
    masks = [
        replace(frame, image=one.mask()[:, :, np.newaxis], bands=("anomaly",))
        for frame, one in zip(frames, examined, strict=True)
    ]
    for tile in map_tiles(raster, masks, surface):
        view = tile.view(surface)
        seen = ViewIntegral(view, ("anomaly",), exact=False)
        for mask in (masks[index] for index in tile.images):
            if seen.add(mask) and mask.image.any():
                add_marks(count[tile.window], mask, view, tile.cell_m, surface)
        coverage[tile.window] = seen.coverage
    return map_blobs(count, coverage, raster, surface, minimum_count=settings.minimum_count)


def _raster(frames: Sequence[Frame], surface: FocalSurface) -> GroundRaster:
    views = [(frame.camera, frame.pose) for frame in frames]
    raster = choose_raster(views, surface, FINEST_CELL_M)
    excess = raster.rows * raster.columns / MAX_CELLS
    return raster if excess <= 1.0 else choose_raster(views, surface, FINEST_CELL_M * math.sqrt(excess) * 1.01)


def _judged(frames: Sequence[Frame], blobs: Sequence[MapBlob], settings: SearchSettings) -> tuple[Candidate, ...]:
    """Return what anomalies are taken for; without those that are nothing but unlike their surroundings."""
    by_height: dict[float, dict[int, MapBlob]] = {}
    for index, blob in enumerate(blobs):
        height_m = HEIGHT_STEP_M * round(blob.position_m[2] / HEIGHT_STEP_M)
        by_height.setdefault(height_m, {})[index] = blob
    if not by_height:
        return ()
    found: list[Candidate] = []
    # Finding what stands out of frames takes most of the time, and does not depend on the height.
    seen_at_m = next(iter(by_height))
    seen = PersonWatch().look(frames, seen_at_m)
    for height_m, group in by_height.items():
        places = {index: np.array(blob.position_m[:2]) for index, blob in group.items()}
        watch = seen.on_plane(seen_at_m, height_m)
        for index, judgement in watch.judge(places, height_m, settings.uncertainty).items():
            candidate = _candidate(group[index], judgement.verdict, judgement.place)
            if _counts(candidate, group[index], settings):
                found.append(candidate)
    return tuple(sorted(found, key=lambda one: (-(one.verdict.probability or 0.0), -one.frames)))


def _candidate(blob: MapBlob, verdict: Verdict, place: Geolocation | None) -> Candidate:
    east_m, north_m, up_m = blob.position_m if place is None else map(float, place.position_enu_m)
    return Candidate((east_m, north_m, up_m), verdict, place, blob.max_count)


def _counts(candidate: Candidate, blob: MapBlob, settings: SearchSettings) -> bool:
    """Tell whether searchers should know of it: something warm, or without temperatures what is large enough.

    What nothing but the marks tells of, as in colour pictures, needs as many frames as the decision asks for elsewhere.
    """
    kind = candidate.verdict.kind
    if kind is not FindingKind.ANOMALY:
        return kind is not FindingKind.OBJECT
    return blob.area_m2 >= settings.minimum_area_m2 and (candidate.place is not None or blob.max_count >= ENOUGH)
