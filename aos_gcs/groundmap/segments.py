"""Figures by segment, and the probability of success: what the search has gained where the person is likely to be."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.groundmap.detection import DETECTABILITY, Posture, detection_by_views
from aos_gcs.groundmap.figures import SegmentFigures, ViewRaster
from aos_gcs.groundmap.tile import VIEW_CELL_M
from aos_gcs.prior.model import AreaPrior
from aos_gcs.prior.segments import Segment
from aos_gcs.prior.shapes import inside_ring


def segment_figures(
    raster: ViewRaster, segments: Sequence[Segment], occlusion: float | None, prior: AreaPrior | None
) -> tuple[SegmentFigures, ...]:
    """Return the figures of segments; what lies beyond the raster counts as not seen.

    Args:
        raster: views.
        segments: segments in the frame of the raster.
        occlusion: share of the ground that one image does not see; None where the forest is not described.
        prior: prior within the search area; None without one.
    """
    return tuple(_figures(raster, segment, occlusion, prior) for segment in segments)


def success_of(raster: ViewRaster, occlusion: float | None, prior: AreaPrior | None) -> float | None:
    """Return the probability that the person is in the search area and would have been noticed by now.

    None without a prior, and where the forest is not described.
    """
    if prior is None or occlusion is None:
        return None
    places_m, mass = _cells(prior)
    return float(mass @ _law(occlusion)[raster.at(places_m)])


def _figures(raster: ViewRaster, segment: Segment, occlusion: float | None, prior: AreaPrior | None) -> SegmentFigures:
    corners_m = np.array(segment.area_enu_m, dtype=np.float64)
    east_m, north_m = (corners_m - corners_m[0]).T
    area_m2 = abs(float(east_m @ np.roll(north_m, -1) - north_m @ np.roll(east_m, -1))) / 2.0
    views = raster.views[raster.inside(segment.area_enu_m)]
    cells = max(len(views), round(area_m2 / VIEW_CELL_M**2), 1)
    counts = np.bincount(views, minlength=256)
    counts[0] += cells - len(views)
    detection = None if occlusion is None else float(counts @ _law(occlusion)) / cells
    probability = success = None
    if prior is not None:
        places_m, mass = _cells(prior)
        inside = inside_ring(places_m, corners_m)
        probability = float(mass[inside].sum())
        if occlusion is not None:
            success = float(mass[inside] @ _law(occlusion)[raster.at(places_m[inside])])
    return SegmentFigures(segment.name, area_m2, 1.0 - float(counts[0]) / cells, detection, probability, success)


def _law(occlusion: float) -> NDArray[np.float64]:
    return detection_by_views(occlusion, DETECTABILITY[Posture.STANDING])


def _cells(prior: AreaPrior) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the middles of a prior's cells, shape (k, 2), and their mass, shape (k,)."""
    rows, columns = np.nonzero(prior.mass)
    east_m, north_m = prior.west_m + (columns + 0.5) * prior.cell_m, prior.north_m - (rows + 0.5) * prior.cell_m
    return np.column_stack((east_m, north_m)), prior.mass[rows, columns]
