"""Judgement of a step's anomalies: its blobs, how much of the largest each vehicle sees, and which vehicle leads."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.detection.marks import Marks
from aos_gcs.imaging.model import (
    MAX_SIGHTINGS,
    NOTHING_KNOWN,
    Blob,
    FocalGrid,
    KeptView,
    KnownPlaces,
    LeaderCriterion,
    Sighting,
    VehicleMasks,
)
from aos_gcs.imaging.persons.warm_bodies import LINK_M
from aos_gcs.imaging.step.agreement import agreeing_frames
from aos_gcs.imaging.step.blobs import BlobCells, find_blobs, joined
from aos_gcs.imaging.step.history import MarkedView, marks_on, views_to_keep
from aos_gcs.imaging.step.marking import MarkedFrame
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.imaging.step.sightings import cells_by_frame, sight
from aos_gcs.imaging.step.visibility import (
    area_in_view_px,
    choose_leader,
    contribution_m2,
    distance_to_centre,
    masks_around,
)

SETTLED_M = 2.0
"""Distance within which a blob is the thing at a settled place: poses displace it by 0.7 m per degree from 40 m."""

SETTLED_BY_FEW_M = 3.0
"""The same for a blob that fewer than ``FEW`` vehicles mark: their errors do not average out."""
FEW = 3
_MOST_WEIGHED = 64
"""Largest number of blobs that are looked at for frames that agree."""


@dataclass(frozen=True, slots=True, eq=False)
class StepJudgement:
    """Result of a step's marks; see the fields of the same names of ``StepAnalysis``."""

    anomaly_count: NDArray[np.uint16]
    sightings: tuple[Sighting, ...]
    vehicle_ids: tuple[int, ...]
    fitness: NDArray[np.float64]
    history: tuple[KeptView, ...]
    leader_id: int | None = None
    masks: VehicleMasks | None = None
    present_m2: float = 0.0
    blob: Blob | None = None


def judge(
    marked: Sequence[MarkedFrame],
    grid: FocalGrid,
    history: Sequence[KeptView],
    settings: ImagingSettings,
    places: KnownPlaces = NOTHING_KNOWN,
    *,
    coverage: NDArray[np.uint16] | None = None,
) -> StepJudgement:
    """Find the blobs that the frames mark, and tell which vehicle sees most of the largest.

    Args:
        marked: frames of the step, with their marks on the grid.
        grid: raster of the focal plane.
        history: views of earlier steps; they enlarge blobs, and are no blob of their own.
        settings: rules for connecting cells and comparing vehicles.
        places: what is known of the ground: see :class:`~aos_gcs.imaging.model.KnownPlaces`.
        coverage: number of frames that see each cell; None: all see every cell.
    """
    past = [MarkedView(view, marks_on(view, grid)) for view in history]
    present_count = _counted((one.marks for one in marked), np.zeros((grid.rows, grid.columns), dtype=np.uint16))
    anomaly_count = _counted((one.marks for one in past), present_count.copy()) if past else present_count
    needed = settings.agreement_of(marked[0].frame.bands) if marked else 1
    most = MAX_SIGHTINGS if needed == 1 and not places.suspected_enu_m else _MOST_WEIGHED
    found = [
        cells
        for cells in find_blobs(anomaly_count, settings.minimum_count, settings.gap_cells, most)
        if present_count[cells.rows, cells.columns].any()
    ]
    suspected, others = _suspected(found, grid, places.suspected_enu_m)
    blobs = [*suspected, *others]
    agreeing = [1 if needed == 1 else agreeing_frames(cells, grid, marked) for cells in blobs]
    # The last frame of a vehicle stands for it.
    present = {one.frame.vehicle_id: one for one in marked}
    seen = [
        (cells, _placed(_with_agreement(sight(cells, own, grid, marked), count), places, rank < len(suspected)))
        for rank, (cells, own, count) in enumerate(
            zip(blobs, cells_by_frame(blobs, grid, marked), agreeing, strict=True)
        )
        if rank < len(suspected) or count >= _needed(cells, needed, len(marked) if coverage is None else coverage)
    ][:MAX_SIGHTINGS]
    seen.sort(key=lambda one: one[1].settled)
    sightings = tuple(sighting for _, sighting in seen)
    if not sightings or sightings[0].settled:
        return StepJudgement(anomaly_count, sightings, tuple(present), np.zeros(len(present)), tuple(history))
    largest, centre_enu_m = seen[0][0], sightings[0].blob.centroid_enu_m
    fitness = np.array([_fitness(one, largest, grid, settings.leader_criterion) for one in present.values()])
    frames = [one.frame for one in present.values()]

    def distance_of(row: int) -> float:
        return distance_to_centre(centre_enu_m, frames[row].camera.ideal(), frames[row].pose)

    shown = present_count[largest.rows, largest.columns] >= settings.minimum_count
    return StepJudgement(
        anomaly_count=anomaly_count,
        sightings=sightings,
        vehicle_ids=tuple(present),
        fitness=fitness,
        history=views_to_keep(largest, grid, marked, past, settings.history_frames),
        leader_id=tuple(present)[choose_leader(fitness, distance_of)],
        masks=masks_around(centre_enu_m, grid, [one.marks for one in present.values()]),
        present_m2=float(np.count_nonzero(shown)) * grid.resolution_m**2,
        blob=sightings[0].blob,
    )


def _suspected(
    blobs: Sequence[BlobCells], grid: FocalGrid, places_enu_m: Sequence[tuple[float, float]]
) -> tuple[list[BlobCells], list[BlobCells]]:
    """Return the blobs at suspected places, those around each as one, and the others.

    Where poses err and leaves hide most of a body, each frame marks another piece of it beside those of the others.
    """
    suspected, others = list[BlobCells](), list(blobs)
    for place_enu_m in places_enu_m:
        near = [cells for cells in others if math.dist(cells.centroid_enu_m(grid)[:2], place_enu_m) <= LINK_M]
        if near:
            suspected.append(joined(near))
            others = [cells for cells in others if cells not in near]
    return suspected, others


def _needed(cells: BlobCells, frames: int, seeing: NDArray[np.uint16] | int) -> int:
    """Return how many frames must agree on a blob: no more than see it."""
    seen_by = seeing if isinstance(seeing, int) else int(seeing[cells.rows, cells.columns].max())
    return min(frames, seen_by)


def _with_agreement(sighting: Sighting, agreeing: int) -> Sighting:
    """Return a sighting whose frames agree where they mark ground beside each other's marks."""
    blob = sighting.blob
    return replace(sighting, blob=replace(blob, max_count=max(blob.max_count, agreeing)))


def _placed(sighting: Sighting, places: KnownPlaces, is_suspected: bool) -> Sighting:
    """Return a sighting with what is known of its place."""
    centre_enu_m = sighting.blob.centroid_enu_m[:2]
    is_of_few = len({view.vehicle_id for view in sighting.views}) < FEW
    reach_m = SETTLED_BY_FEW_M if is_of_few else SETTLED_M
    is_settled = any(math.dist(centre_enu_m, place_enu_m) <= reach_m for place_enu_m in places.settled_enu_m)
    return replace(sighting, settled=is_settled, suspected=is_suspected)


def _counted(marks: Iterable[Marks], count: NDArray[np.uint16]) -> NDArray[np.uint16]:
    """Add marks to the number of frames that mark each cell; changes the array and returns it."""
    for own in marks:
        count[own.rows, own.columns] += 1
    return count


def _fitness(marked: MarkedFrame, cells: BlobCells, grid: FocalGrid, criterion: LeaderCriterion) -> float:
    if criterion is LeaderCriterion.CONTRIBUTION:
        return contribution_m2(cells, grid, marked.marks)
    return area_in_view_px(cells, grid, marked.frame.camera.ideal(), marked.frame.pose)
