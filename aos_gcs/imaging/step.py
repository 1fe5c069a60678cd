"""One step of the mission: from the vehicles' frames to the visibility, the leader and the target's position."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from aos_gcs.errors import ConfigurationError, ImagingError
from aos_gcs.imaging.blobs import BlobCells, find_blobs
from aos_gcs.imaging.focal_plane import DEFAULT_MAX_CELLS, choose_grid
from aos_gcs.imaging.integral import BATCH_FRAMES, ViewIntegral, check_frame
from aos_gcs.imaging.marks import Marks, project_marks
from aos_gcs.imaging.model import FocalGrid, Frame, LeaderCriterion, StepAnalysis
from aos_gcs.imaging.rx import anomaly_mask, default_min_score, rx_scores
from aos_gcs.imaging.sightings import sight
from aos_gcs.imaging.views import PlaneView, grid_view
from aos_gcs.imaging.visibility import area_in_view_px, choose_leader, contribution_m2, distance_to_centre, masks_around
from aos_gcs.imaging.workers import parallel_map


@dataclass(frozen=True, slots=True)
class ImagingSettings:
    """How the frames of a step are analysed (spec, sections 1 and 2).

    Raises:
        ConfigurationError: if a value lies outside its range; the text names it.
    """

    plane_height_m: float = 0.0
    """ENU height of the horizontal focal plane."""
    rx_quantile: float = 0.9998
    """Of a frame's scores, above which pixels are marked."""
    rx_min_score: float | None = None
    """Score that a marked pixel must also exceed; None: the default for the number of bands."""
    minimum_count: int = 1
    """Frames that must mark a cell of the integral."""
    gap_cells: int = 1
    """Unmarked cells that may lie between two cells of one blob."""
    leader_criterion: LeaderCriterion = LeaderCriterion.CONTRIBUTION
    resolution_m: float | None = None
    """Edge of a cell on the focal plane; None: the finest ground sampling distance of the frames."""
    max_cells: int = DEFAULT_MAX_CELLS
    """Upper bound of the raster's size; cells become coarser to keep it."""

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


def analyse_step(frames: Sequence[Frame], settings: ImagingSettings) -> StepAnalysis:
    """Integrate frames and their anomaly masks, and find the largest blob and the leader.

    Blocks for tens of milliseconds: call it in a worker thread.

    Args:
        frames: at least one, all with the same bands; sizes, altitudes and attitudes may differ. Of several frames of
            one vehicle the last stands for its present position; the others only take part in the integral. A frame
            that does not see the focal plane takes no part, and its vehicle's fitness is 0.
        settings: see :class:`ImagingSettings`.

    Raises:
        ImagingError: if there is no frame, bands differ, or no frame sees the focal plane.
    """
    if not frames:
        raise ImagingError("There is no frame to analyse: give at least one.")
    for frame in frames:
        check_frame(frame, frames[0].bands)
    grid = choose_grid(frames, settings.plane_height_m, settings.resolution_m, settings.max_cells)
    view = grid_view(grid)
    integral = ViewIntegral(view, frames[0].bands, exact=False)
    marks: list[Marks | None] = []
    for first in range(0, len(frames), BATCH_FRAMES):
        batch = frames[first : first + BATCH_FRAMES]
        integral.add_all(batch)
        marks += parallel_map(partial(_marks, view=view, settings=settings), batch)
    anomaly_count = np.zeros_like(integral.coverage)
    for own in marks:
        if own is not None:
            anomaly_count[own.rows, own.columns] += 1
    blobs = find_blobs(anomaly_count, settings.minimum_count, settings.gap_cells)
    sightings = tuple(sight(cells, grid, frames, marks) for cells in blobs)
    vehicle_ids = tuple(dict.fromkeys(frame.vehicle_id for frame in frames))
    fitness = np.zeros(len(vehicle_ids))
    blob, leader_id, present_masks = None, None, None
    if sightings:
        blob, cells = sightings[0].blob, blobs[0]
        shares_m2 = [0.0 if own is None else contribution_m2(cells, grid, own) for own in marks]
        present = {frame.vehicle_id: (frame, share) for frame, share in zip(frames, shares_m2, strict=True)}
        fitness = np.array([_fitness(*present[i], cells, grid, settings.leader_criterion) for i in vehicle_ids])
        centre = blob.centroid_enu_m
        distances = [distance_to_centre(centre, present[i][0].camera.ideal(), present[i][0].pose) for i in vehicle_ids]
        leader_id = vehicle_ids[choose_leader(fitness, distances)]
        marks_of = {frame.vehicle_id: own for frame, own in zip(frames, marks, strict=True)}
        present_masks = masks_around(centre, grid, [marks_of[i] for i in vehicle_ids])
    return StepAnalysis(
        grid=grid,
        integral=integral.mean(),
        coverage=integral.coverage,
        anomaly_count=anomaly_count,
        blob=blob,
        vehicle_ids=vehicle_ids,
        fitness=fitness,
        leader_id=leader_id,
        masks=present_masks,
        sightings=sightings,
    )


def _marks(frame: Frame, view: PlaneView, settings: ImagingSettings) -> Marks | None:
    """Return the cells that a frame marks; None if it does not see the focal plane."""
    projection = view.project(frame)
    if projection is None:
        return None
    min_score = settings.rx_min_score
    if min_score is None:
        min_score = default_min_score(len(frame.bands))
    # Before any warp: what is interpolated is correlated, and smoother than the background.
    mask = anomaly_mask(rx_scores(frame.image), settings.rx_quantile, min_score)
    return project_marks(mask, projection)


def _fitness(frame: Frame, share_m2: float, cells: BlobCells, grid: FocalGrid, criterion: LeaderCriterion) -> float:
    if criterion is LeaderCriterion.CONTRIBUTION:
        return share_m2
    return area_in_view_px(cells, grid, frame.camera.ideal(), frame.pose)
