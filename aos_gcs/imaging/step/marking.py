"""Marking of anomalies: the cells of the focal plane that each frame of a step marks and covers."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.detection.detectors import detect
from aos_gcs.imaging.detection.marks import NO_MARKS, Marks, covered_marks, project_marks
from aos_gcs.imaging.integral import BAND_ROWS
from aos_gcs.imaging.model import Viewpoint
from aos_gcs.imaging.native import kernels
from aos_gcs.imaging.step.examination import ExaminedFrame
from aos_gcs.imaging.step.integration import StepIntegral
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.imaging.warp import PlaneProjection
from aos_gcs.imaging.warped import WarpedFrame
from aos_gcs.imaging.workers import parallel_map


@dataclass(frozen=True, slots=True, eq=False)
class ProjectedFrame:
    """A frame, and where it lies on the raster of the focal plane."""

    frame: ExaminedFrame
    projection: PlaneProjection | None
    """None where it covers no cell."""


@dataclass(frozen=True, slots=True, eq=False)
class MarkedFrame:
    """A frame with the cells of the focal plane that it marks."""

    frame: Viewpoint
    marks: Marks


def mark(projected: Sequence[ProjectedFrame]) -> list[MarkedFrame]:
    """Return the frames with the cells under what the detector marks of them.

    Raises:
        ImagingError: the frames lack a band that the detector needs.
    """
    marks = parallel_map(_own_marks, projected)
    return [MarkedFrame(one.frame, own) for one, own in zip(projected, marks, strict=True)]


def mark_in_integral(
    projected: Sequence[ProjectedFrame], integral: StepIntegral, settings: ImagingSettings
) -> list[MarkedFrame]:
    """Return the frames with the anomalies of their integral that they cover.

    Raises:
        ImagingError: the frames lack a band that the detector needs.
    """
    anomalies = _anomalies_of(integral, projected[0].frame.bands, settings)
    return [
        MarkedFrame(one.frame, NO_MARKS if one.projection is None else covered_marks(anomalies, one.projection))
        for one in projected
    ]


def cover(projected: Sequence[ProjectedFrame], shape: tuple[int, int]) -> NDArray[np.uint16]:
    """Return how many frames cover each cell of a raster of some shape, as their integral has it."""
    spans, broken = [], []
    for one in projected:
        if one.projection is None:
            continue
        if one.frame.camera.distortion is None and one.frame.gaps is None:
            spans.append(one.projection.spans)
        else:
            broken.append(one)
    coverage = count_spans(spans, *shape)
    for warped in itertools.chain.from_iterable(parallel_map(_valid_parts, broken)):
        coverage[warped.window] += warped.coverage()
    return coverage


def count_spans(spans: Sequence[NDArray[np.int32]], rows: int, columns: int) -> NDArray[np.uint16]:
    """Return how many spans hold each cell, see :func:`~aos_gcs.imaging.native.kernels.count_spans`."""
    compiled = kernels.count_spans(spans, rows, columns)
    if compiled is not None:
        return compiled
    # Where spans begin and end; the sum along a row is what they cover.
    changes = np.zeros((rows, columns + 1), dtype=np.int16)
    every_row = np.arange(rows)
    for first, end in (own.T for own in spans):
        changes[every_row, first] += 1
        changes[every_row, end] -= 1
    return np.cumsum(changes[:, :-1], axis=1, dtype=np.int16).view(np.uint16)


def _valid_parts(projected: ProjectedFrame) -> list[WarpedFrame]:
    """Return what a frame covers of its spans: neither its gaps nor what its lens does not image."""
    if projected.projection is None:
        return []
    plane, rows = projected.frame.validity(), projected.projection.rows
    bands = [
        projected.projection.sample(plane, first, first + BAND_ROWS)
        for first in range(rows.start - rows.start % BAND_ROWS, rows.stop, BAND_ROWS)
    ]
    return [warped.without_gaps() for warped in bands if warped is not None]


def _own_marks(projected: ProjectedFrame) -> Marks:
    """Return the cells under the mask of the frame itself."""
    mask = projected.frame.mask()
    return NO_MARKS if projected.projection is None else project_marks(mask, projected.projection)


def _anomalies_of(integral: StepIntegral, bands: tuple[str, ...], settings: ImagingSettings) -> Marks:
    """Return the cells that stand out of the integral."""
    # The variance of a mean of n frames is 1 / n of theirs: without weights, the rims would stand out.
    weights = integral.coverage.astype(np.float32) / np.float32(max(int(integral.coverage.max()), 1))
    detector = settings.detector_of(bands)
    mask = detect(integral.mean, bands, detector, settings.rx_quantile, settings.rx_min_score, weights=weights)
    return Marks(*np.nonzero(mask))
