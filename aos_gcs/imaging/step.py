"""One step of the mission: from the vehicles' frames to the visibility, the leader and the target's position."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.blobs import BlobCells, find_blobs
from aos_gcs.imaging.detection.detectors import detect
from aos_gcs.imaging.detection.marks import NO_MARKS, Marks, covered_marks, project_marks
from aos_gcs.imaging.focal_plane import DEFAULT_MAX_CELLS, choose_grid
from aos_gcs.imaging.frame_checks import usable_frames
from aos_gcs.imaging.history import marks_on, views_to_keep
from aos_gcs.imaging.integral import BATCH_FRAMES, ViewIntegral
from aos_gcs.imaging.model import AnomalySource, Detector, FocalGrid, Frame, KeptView, LeaderCriterion, StepAnalysis
from aos_gcs.imaging.sightings import sight
from aos_gcs.imaging.views import PlaneView, grid_view
from aos_gcs.imaging.visibility import area_in_view_px, choose_leader, contribution_m2, distance_to_centre, masks_around
from aos_gcs.imaging.workers import parallel_map

FindMask: TypeAlias = Callable[[Frame], NDArray[np.uint8]]
"""What a detector marks of a frame, shape (H, W), 1 where it is anomalous."""


@dataclass(frozen=True, slots=True)
class ImagingSettings:
    """How the frames of a step are analysed (spec, sections 1 and 2).

    Raises:
        ConfigurationError: if a value lies outside its range; the text names it.
    """

    plane_height_m: float = 0.0
    """ENU height of the horizontal focal plane."""
    detector: Detector = Detector.RX
    anomaly_source: AnomalySource = AnomalySource.MASKS
    rx_quantile: float = 0.9998
    """Of an image's scores, above which pixels are marked; for every detector."""
    rx_min_score: float | None = None
    """Score that a marked pixel must also exceed, for every detector; None: the detector's own for the bands."""
    minimum_count: int = 1
    """Frames that must mark a cell of the integral."""
    gap_cells: int = 1
    """Unmarked cells that may lie between two cells of one blob."""
    leader_criterion: LeaderCriterion = LeaderCriterion.CONTRIBUTION
    resolution_m: float | None = None
    """Edge of a cell on the focal plane; None: the finest ground sampling distance of the frames."""
    max_cells: int = DEFAULT_MAX_CELLS
    """Upper bound of the raster's size; cells become coarser to keep it."""
    history_frames: int = 10
    """Views of earlier steps that at most stay in the integral of anomalies; 0: none."""

    def __post_init__(self) -> None:
        if not math.isfinite(self.plane_height_m):
            raise ConfigurationError(f"plane_height_m must be finite, got {self.plane_height_m}.")
        if not 0.0 <= self.rx_quantile < 1.0:
            raise ConfigurationError(f"rx_quantile must lie within [0, 1), got {self.rx_quantile}.")
        if self.rx_min_score is not None and not self.rx_min_score >= 0.0:
            raise ConfigurationError(f"rx_min_score must not be negative, got {self.rx_min_score}.")
        if self.minimum_count < 1:
            raise ConfigurationError(f"minimum_count must be at least 1, got {self.minimum_count}.")
        if self.gap_cells < 0:
            raise ConfigurationError(f"gap_cells must not be negative, got {self.gap_cells}.")
        if self.resolution_m is not None and not self.resolution_m > 0.0:
            raise ConfigurationError(f"resolution_m must be positive, got {self.resolution_m}.")
        if self.max_cells < 100:
            raise ConfigurationError(f"max_cells must be at least 100, got {self.max_cells}.")
        if self.history_frames < 0:
            raise ConfigurationError(f"history_frames must not be negative, got {self.history_frames}.")


def find_mask(frame: Frame, settings: ImagingSettings) -> NDArray[np.uint8]:
    """Return what the detector marks of a frame, shape (H, W), 1 where it is anomalous.

    Raises:
        ImagingError: if it lacks a band that the detector needs.
    """
    # Before any warp: what is interpolated is correlated, and smoother than the background.
    return detect(frame.image, frame.bands, settings.detector, settings.rx_quantile, settings.rx_min_score)


def analyse_step(
    frames: Sequence[Frame],
    settings: ImagingSettings,
    history: Sequence[KeptView] = (),
    known_mask: FindMask | None = None,
) -> StepAnalysis:
    """Integrate frames and their anomaly masks, and find the largest blob and the leader.

    Blocks for tens of milliseconds: call it in a worker thread.

    Args:
        frames: at least one; sizes, altitudes and attitudes may differ. Of several frames of one vehicle the last
            stands for its present position; the others only take part in the integral. Frames that cannot be used, or
            do not see the focal plane, are skipped, and the result says why.
        settings: see :class:`ImagingSettings`.
        history: views of the previous step's ``StepAnalysis.history``. They enlarge blobs that the frames mark, too; a
            blob of theirs alone is none. Leader, fitness and views of blobs are of the frames only.
        known_mask: remembers what ``find_mask`` has found in these very frames, for who analyses them on several
            planes: masks do not depend on the plane.

    Raises:
        UnusableFramesError: if no frame can be used; it gives the reasons.
        ImagingError: if there is no frame, or they lack a band that the detector needs.
    """
    frames, skipped = usable_frames(frames, settings.plane_height_m)
    grid = choose_grid(frames, settings.plane_height_m, settings.resolution_m, settings.max_cells)
    view, bands = grid_view(grid), frames[0].bands
    integral = ViewIntegral(view, bands, exact=False)
    marks: list[Marks] = []
    own_mask = partial(find_mask, settings=settings)
    for first in range(0, len(frames), BATCH_FRAMES):
        taken = frames[first : first + BATCH_FRAMES]
        batch = parallel_map(_in_single_precision, taken)
        integral.add_all(batch)
        if settings.anomaly_source is AnomalySource.MASKS:
            find, frames_to_mark = (own_mask, batch) if known_mask is None else (known_mask, taken)
            marks += parallel_map(partial(_marks, view=view, find=find), frames_to_mark)
    mean, coverage = integral.take()
    if settings.anomaly_source is AnomalySource.INTEGRAL:
        marks = _marks_of_integral(mean, coverage, frames, view, settings)
    past = [(kept, marks_on(kept, grid)) for kept in history]
    anomaly_count = np.zeros_like(coverage)
    for own in marks:
        anomaly_count[own.rows, own.columns] += 1
    present_count = anomaly_count.copy() if past else anomaly_count
    for _, own in past:
        anomaly_count[own.rows, own.columns] += 1
    blobs = [
        cells
        for cells in find_blobs(anomaly_count, settings.minimum_count, settings.gap_cells)
        if present_count[cells.rows, cells.columns].any()
    ]
    sightings = tuple(sight(cells, grid, frames, marks) for cells in blobs)
    vehicle_ids = tuple(dict.fromkeys(frame.vehicle_id for frame in frames))
    fitness = np.zeros(len(vehicle_ids))
    blob, leader_id, masks, present_m2, following = None, None, None, 0.0, tuple(history)
    if sightings:
        blob, cells = sightings[0].blob, blobs[0]
        present = {frame.vehicle_id: (frame, own) for frame, own in zip(frames, marks, strict=True)}
        fitness = np.array([_fitness(*present[i], cells, grid, settings.leader_criterion) for i in vehicle_ids])
        centre = blob.centroid_enu_m
        distances = [distance_to_centre(centre, present[i][0].camera.ideal(), present[i][0].pose) for i in vehicle_ids]
        leader_id = vehicle_ids[choose_leader(fitness, distances)]
        masks = masks_around(centre, grid, [present[i][1] for i in vehicle_ids])
        shown = present_count[cells.rows, cells.columns] >= settings.minimum_count
        present_m2 = float(np.count_nonzero(shown)) * grid.resolution_m**2
        own_marks = list(zip(frames, marks, strict=True))
        following = views_to_keep(cells, grid, own_marks, past, settings.history_frames)
    return StepAnalysis(
        grid=grid,
        integral=mean,
        coverage=coverage,
        anomaly_count=anomaly_count,
        blob=blob,
        vehicle_ids=vehicle_ids,
        fitness=fitness,
        leader_id=leader_id,
        masks=masks,
        sightings=sightings,
        skipped=skipped,
        present_m2=present_m2,
        history=following,
    )


def _in_single_precision(frame: Frame) -> Frame:
    """Return the frame as both the integral and the detector want it, so that neither converts it again."""
    return replace(frame, image=np.ascontiguousarray(frame.image, dtype=np.float32))


def _marks(frame: Frame, view: PlaneView, find: FindMask) -> Marks:
    """Return the cells that a frame marks."""
    mask, projection = find(frame), view.project(frame)
    return NO_MARKS if projection is None else project_marks(mask, projection)


def _marks_of_integral(
    mean: NDArray[np.float32],
    coverage: NDArray[np.uint16],
    frames: Sequence[Frame],
    view: PlaneView,
    settings: ImagingSettings,
) -> list[Marks]:
    """Return which cells that stand out of the integral each frame covers."""
    # The variance of a mean of n frames is 1 / n of theirs: without weights, the rims would stand out.
    weights = coverage.astype(np.float32) / np.float32(max(int(coverage.max()), 1))
    mask = detect(
        mean, frames[0].bands, settings.detector, settings.rx_quantile, settings.rx_min_score, weights=weights
    )
    marks = Marks(*np.nonzero(mask))
    projections = [view.project(frame) for frame in frames]
    return [NO_MARKS if projection is None else covered_marks(marks, projection) for projection in projections]


def _fitness(frame: Frame, marks: Marks, cells: BlobCells, grid: FocalGrid, criterion: LeaderCriterion) -> float:
    if criterion is LeaderCriterion.CONTRIBUTION:
        return contribution_m2(cells, grid, marks)
    return area_in_view_px(cells, grid, frame.camera.ideal(), frame.pose)
