"""Analysis of one step: from the vehicles' frames to the visibility, the leader and the target's position."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeAlias

from aos_gcs.imaging.focal_plane import choose_grid
from aos_gcs.imaging.model import (
    NOTHING_KNOWN,
    AnomalySource,
    FocalGrid,
    Frame,
    KeptView,
    KnownPlaces,
    StepAnalysis,
)
from aos_gcs.imaging.step.examination import ExaminedFrame, examine
from aos_gcs.imaging.step.frame_checks import usable_frames
from aos_gcs.imaging.step.integration import integrate
from aos_gcs.imaging.step.judgement import judge
from aos_gcs.imaging.step.marking import MarkedFrame, ProjectedFrame, cover, mark, mark_in_integral
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.imaging.views import grid_view
from aos_gcs.imaging.workers import parallel_map

_Mark: TypeAlias = Callable[[Sequence[ProjectedFrame], FocalGrid], list[MarkedFrame]]


def analyse_step(
    frames: Sequence[Frame],
    settings: ImagingSettings,
    history: Sequence[KeptView] = (),
    known: Callable[[Frame], ExaminedFrame] | None = None,
    places: KnownPlaces = NOTHING_KNOWN,
) -> StepAnalysis:
    """Examine frames, mark anomalies, and judge which blob is the largest and which vehicle leads.

    Blocks for tens of milliseconds: call it by a ``Worker``.

    Args:
        frames: at least one; sizes, altitudes and attitudes may differ. Of several frames of one vehicle the last
            stands for its present position; the others only mark and cover. Frames that cannot be used, or do not see
            the focal plane, are skipped, and the result says why.
        settings: see :class:`~aos_gcs.imaging.step.settings.ImagingSettings`.
        history: views of the previous step's ``StepAnalysis.history``. They enlarge blobs that the frames mark, too; a
            blob of theirs alone is none. Leader, fitness and views of blobs are of the frames only.
        known: a cached :func:`~aos_gcs.imaging.step.examination.examine` of these very frames, for callers that analyse
            them on several planes: it does not depend on the plane.
        places: places that have been looked at, and those of what may be a person.

    Raises:
        UnusableFramesError: if no frame can be used; it gives the reasons.
        ImagingError: if there is no frame, or they lack a band that the detector needs.
    """
    examined = parallel_map(partial(examine, settings=settings) if known is None else known, frames)
    if settings.anomaly_source is AnomalySource.MASKS:
        return analyse_examined(examined, settings, history, places)
    frame_of = dict(zip(map(id, examined), frames, strict=True))

    def mark_anomalies(projected: Sequence[ProjectedFrame], grid: FocalGrid) -> list[MarkedFrame]:
        integral = integrate([frame_of[id(one.frame)] for one in projected], grid)
        return mark_in_integral(projected, integral, settings)

    return _analyse(examined, settings, history, places, mark_anomalies)


def analyse_examined(
    frames: Sequence[ExaminedFrame],
    settings: ImagingSettings,
    history: Sequence[KeptView] = (),
    places: KnownPlaces = NOTHING_KNOWN,
) -> StepAnalysis:
    """Return what :func:`analyse_step` does, for frames that have been examined and are marked one by one."""
    return _analyse(frames, settings, history, places, lambda projected, _: mark(projected))


def _analyse(
    frames: Sequence[ExaminedFrame],
    settings: ImagingSettings,
    history: Sequence[KeptView],
    places: KnownPlaces,
    mark_frames: _Mark,
) -> StepAnalysis:
    usable = usable_frames(frames, settings.plane_height_m)
    grid = choose_grid(usable.frames, settings.plane_height_m, settings.resolution_m, settings.max_cells)
    view = grid_view(grid)
    projected = [ProjectedFrame(frame, view.project(frame)) for frame in usable.frames]
    marked = mark_frames(projected, grid)
    coverage = cover(projected, view.shape)
    judgement = judge(marked, grid, history, settings, places, coverage=coverage)
    return StepAnalysis(
        grid=grid,
        coverage=coverage,
        anomaly_count=judgement.anomaly_count,
        blob=judgement.blob,
        vehicle_ids=judgement.vehicle_ids,
        fitness=judgement.fitness,
        leader_id=judgement.leader_id,
        masks=judgement.masks,
        sightings=judgement.sightings,
        skipped=usable.skipped,
        present_m2=judgement.present_m2,
        history=judgement.history,
        mark_digests={one.frame.vehicle_id: one.marks.digest() for one in marked},
    )
