"""Anomalies on which frames in memory agree: the detection of a whole survey's map, on a window of its frames."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from aos_gcs.errors import ConfigurationError, ImagingError
from aos_gcs.imaging.model import AnomalySource, Detector, Frame, MapRaster
from aos_gcs.imaging.step.examination import examine_all
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.imaging.surfaces.ground import choose_raster
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.imaging.workers import parallel_map
from aos_gcs.surveys.anomalies import MapBlob, significant_blobs
from aos_gcs.surveys.levels import add_levels, levels
from aos_gcs.surveys.significance import (
    DEFAULT_FALSE_ALARMS_PER_HA,
    MIN_VIEWS,
    AnomalySums,
    significance,
    significance_limit,
)
from aos_gcs.surveys.tiles import Placed, map_tiles

MAX_CELLS = 16_000_000
"""Largest map of a window; cells become coarser to keep it."""
_FAULTS_ONLY = ImagingSettings(anomaly_source=AnomalySource.INTEGRAL)
"""Frames are looked at for what makes them unusable; the detector is applied elsewhere."""


@dataclass(frozen=True, slots=True)
class Detection:
    """Detector, and from when on frames agree.

    Raises:
        ConfigurationError: if a value lies outside its range; the text names it.
    """

    detector: Detector = Detector.LOCAL_RX
    min_score: float | None = None
    """Score of the lowest level of anomaly; None: see :func:`~aos_gcs.surveys.levels.base_score`."""
    false_alarms_per_ha: float = DEFAULT_FALSE_ALARMS_PER_HA
    """Places per hectare at which chance may exceed the limit of an anomaly."""

    def __post_init__(self) -> None:
        significance_limit(self.false_alarms_per_ha)
        if self.min_score is not None and not self.min_score >= 0.0:
            raise ConfigurationError(f"--min-score must not be negative, got {self.min_score:g}.")


@dataclass(frozen=True, slots=True, eq=False)
class WindowAnomalies:
    """What stands out of a window more than chance does."""

    blobs: tuple[MapBlob, ...]
    """The most significant first."""
    searched_m2: float
    """Ground that :data:`~aos_gcs.surveys.significance.MIN_VIEWS` frames see."""
    left_out: Mapping[int, str]
    """Reason why a frame took no part, by its ``vehicle_id``."""


def window_raster(views: Sequence[Placed], surface: FocalSurface, finest_cell_m: float) -> MapRaster:
    """Return the raster of all that cameras see, of at most :data:`MAX_CELLS`.

    Raises:
        ImagingError: if none sees the surface.
    """
    placed = [(view.camera, view.pose) for view in views]
    raster = choose_raster(placed, surface, finest_cell_m)
    excess = raster.rows * raster.columns / MAX_CELLS
    return raster if excess <= 1.0 else choose_raster(placed, surface, finest_cell_m * math.sqrt(excess) * 1.01)


def find_anomalies(
    frames: Sequence[Frame], surface: FocalSurface, detection: Detection, finest_cell_m: float
) -> WindowAnomalies:
    """Return what the frames of a window agree on. Takes seconds: call it in a thread.

    Args:
        frames: frames of one camera, each with a ``vehicle_id`` of its own.
        surface: ground, in the world of their poses.
        detection: see :class:`Detection`.
        finest_cell_m: smallest cell of the map on which frames have to agree.

    Raises:
        ImagingError: if no frame sees the surface, or none can be used.
    """
    examined = examine_all(frames, _FAULTS_ONLY)
    left_out = {one.vehicle_id: one.fault for one in examined if one.fault}
    sound = [(frame, one) for frame, one in zip(frames, examined, strict=True) if not one.fault]
    if not sound:
        raise ImagingError(f"No frame can be examined: {next(iter(left_out.values()), 'there is none')}.")
    raster = window_raster([frame for frame, _ in sound], surface, finest_cell_m)
    find = partial(_levels_of, surface=surface, detection=detection, cell_m=raster.resolution_m)
    found = parallel_map(find, [frame for frame, _ in sound])
    marked = []
    for (frame, one), own in zip(sound, found, strict=True):
        if isinstance(own, str):
            left_out[frame.vehicle_id] = own
        else:
            # Gaps of a frame cover no ground.
            marked.append(own if one.gaps is None else replace(own, image=own.image + one.validity()[:, :, :1]))
    if not marked:
        raise ImagingError(f"No frame can be examined: {next(iter(left_out.values()))}")
    sums = AnomalySums.none((raster.rows, raster.columns))
    coverage = np.zeros_like(sums.count)
    for tile in map_tiles(raster, marked, surface):
        view = tile.view(surface)
        for index in tile.images:
            add_levels(sums.part(tile.window), marked[index], view, coverage[tile.window])
    significances = significance(sums, coverage, raster.resolution_m)
    rate = detection.false_alarms_per_ha
    blobs = significant_blobs(sums, significances, coverage, raster, surface, false_alarms_per_ha=rate)
    searched_m2 = float(np.count_nonzero(coverage >= MIN_VIEWS)) * raster.resolution_m**2
    return WindowAnomalies(tuple(blobs), searched_m2, left_out)


def _levels_of(frame: Frame, surface: FocalSurface, detection: Detection, cell_m: float) -> Frame | str:
    """Return the levels of a frame in its place, possibly all 0; or the reason why the detector cannot be applied."""
    try:
        marked = levels(frame, detection.detector, surface, detection.min_score, cell_m)
    except ImagingError as error:
        return str(error)
    if marked is not None:
        return marked
    return replace(frame, image=np.zeros((*frame.image.shape[:2], 1), dtype=np.uint8), bands=("anomaly",))
