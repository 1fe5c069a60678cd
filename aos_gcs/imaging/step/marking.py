"""Marking of anomalies: the cells of the focal plane that each frame of a step marks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.detection.detectors import detect
from aos_gcs.imaging.detection.marks import NO_MARKS, Marks, covered_marks, project_marks
from aos_gcs.imaging.model import AnomalySource, Frame
from aos_gcs.imaging.step.integration import StepIntegral
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.imaging.views import PlaneView
from aos_gcs.imaging.workers import parallel_map

FindMask: TypeAlias = Callable[[Frame], NDArray[np.uint8]]
"""Function that returns what a detector marks of a frame, shape (H, W), 1 where it is anomalous."""


@dataclass(frozen=True, slots=True, eq=False)
class MarkedFrame:
    """A frame with the cells of the focal plane that it marks."""

    frame: Frame
    marks: Marks


def find_mask(frame: Frame, settings: ImagingSettings) -> NDArray[np.uint8]:
    """Return what the detector marks of a frame, shape (H, W), 1 where it is anomalous.

    Raises:
        ImagingError: if it lacks a band that the detector needs.
    """
    # Before any warp: interpolated pixels are correlated, and smoother than the background.
    return detect(frame.image, frame.bands, settings.detector, settings.rx_quantile, settings.rx_min_score)


def mark(
    frames: Sequence[Frame], integral: StepIntegral, settings: ImagingSettings, known_mask: FindMask | None = None
) -> list[MarkedFrame]:
    """Return the frames with the cells that they mark; in the integral, a frame marks every anomaly it covers.

    Args:
        frames: those of the integral.
        integral: integral of the frames.
        settings: detector and what it is applied to.
        known_mask: used in place of :func:`find_mask`, for callers that remember the masks of these very frames.

    Raises:
        ImagingError: if the frames lack a band that the detector needs.
    """
    if settings.anomaly_source is AnomalySource.INTEGRAL:
        anomalies = _anomalies_of(integral, frames[0].bands, settings)
        find_marks = partial(_covered, anomalies=anomalies, view=integral.view)
    else:
        find = partial(find_mask, settings=settings) if known_mask is None else known_mask
        find_marks = partial(_own_marks, view=integral.view, find=find)
    return [MarkedFrame(frame, marks) for frame, marks in zip(frames, parallel_map(find_marks, frames), strict=True)]


def _own_marks(frame: Frame, view: PlaneView, find: FindMask) -> Marks:
    """Return the cells under the mask of the frame itself."""
    mask, projection = find(frame), view.project(frame)
    return NO_MARKS if projection is None else project_marks(mask, projection)


def _covered(frame: Frame, anomalies: Marks, view: PlaneView) -> Marks:
    """Return the anomalous cells that the frame covers."""
    projection = view.project(frame)
    return NO_MARKS if projection is None else covered_marks(anomalies, projection)


def _anomalies_of(integral: StepIntegral, bands: tuple[str, ...], settings: ImagingSettings) -> Marks:
    """Return the cells that stand out of the integral."""
    # The variance of a mean of n frames is 1 / n of theirs: without weights, the rims would stand out.
    weights = integral.coverage.astype(np.float32) / np.float32(max(int(integral.coverage.max()), 1))
    mask = detect(integral.mean, bands, settings.detector, settings.rx_quantile, settings.rx_min_score, weights=weights)
    return Marks(*np.nonzero(mask))
