"""Windows of overlapping frames along a recorded flight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.focal_plane import footprint
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.surveys.significance import MIN_VIEWS
from aos_gcs.surveys.tiles import Placed

MAX_FRAMES = 30
"""Largest number of frames of a window."""
MAX_REACH = 2.0
"""Largest distance of a window's frames from its first one, in footprints of that one: farther ones share no ground."""
ADVANCE = 2.0 / 3.0
"""Share of a window after which the next one begins: places at its end are in the middle of that one."""
_COARSE_M = 2.0
"""Cells in which windows are counted."""
_MAX_EDGE_CELLS = 500
"""Largest number of cells along the view of a frame; they are larger where frames see far."""
_ROW_CELLS = 1 << 31
"""Number of cells from one row to the next."""


@dataclass(frozen=True, slots=True)
class FrameWindow:
    """Frames that are examined together, as those of a swarm."""

    first: int
    """Index of the first frame in the recording."""
    end: int
    """Index behind the last one."""

    @property
    def frames(self) -> range:
        """Indices of its frames."""
        return range(self.first, self.end)


def plan_windows(views: Sequence[Placed], ground_m: float) -> tuple[FrameWindow, ...]:
    """Return windows that hold every frame of a flight, each of at least two frames where there are as many.

    Args:
        views: cameras and poses of the frames, in the order of the flight.
        ground_m: height of the ground.
    """
    count, first = len(views), 0
    windows: list[FrameWindow] = []
    while True:
        end = min(max(_end(views, first, ground_m), first + 2), count)
        windows.append(FrameWindow(first, end))
        if end == count:
            return tuple(windows)
        # The next window overlaps this one, but begins where the rest of the flight still fills it.
        first = max(first + 1, min(first + round(ADVANCE * (end - first)), count - 2))


def _end(views: Sequence[Placed], first: int, ground_m: float) -> int:
    outline_m = footprint(views[first].camera, views[first].pose, ground_m)
    reach_m = MAX_REACH * float(np.ptp(outline_m, axis=0).max()) if len(outline_m) else 0.0
    start_m = views[first].pose.position_enu_m[:2]
    last = min(first + MAX_FRAMES, len(views))
    for index in range(first + 1, last):
        if np.linalg.norm(views[index].pose.position_enu_m[:2] - start_m) > reach_m:
            return index
    return last


@dataclass(frozen=True, slots=True)
class ExaminedGround:
    """Ground on which enough frames of a window can agree."""

    share: float
    """Share of the ground that frames see."""
    windows_per_place: float
    """Number of windows that examine a place in the mean, at least 1: each gives chance another try."""


def examined_ground(views: Sequence[Placed], windows: Sequence[FrameWindow], ground_m: float) -> ExaminedGround:
    """Return what windows examine. What it takes follows from the views of frames, not from how far they lie apart.

    Args:
        views: cameras and poses of the frames.
        windows: windows of these.
        ground_m: height of the ground.
    """
    outlines_m = [footprint(view.camera, view.pose, ground_m) for view in views]
    largest_m = max((float(np.ptp(outline_m, axis=0).max()) for outline_m in outlines_m if len(outline_m)), default=0.0)
    cell_m = max(_COARSE_M, largest_m / _MAX_EDGE_CELLS)
    corner_m = np.min([outline_m.min(axis=0) for outline_m in outlines_m if len(outline_m)] or [[0.0, 0.0]], axis=0)
    cells = [_cells((outline_m - corner_m) / cell_m) for outline_m in outlines_m]
    examined: list[NDArray[np.int64]] = []
    for window in windows:
        places, counts = np.unique(np.concatenate([cells[index] for index in window.frames]), return_counts=True)
        examined.append(places[counts >= MIN_VIEWS])
    times = np.concatenate(examined)
    if not len(times):
        return ExaminedGround(0.0, 1.0)
    places = np.unique(times)
    return ExaminedGround(len(places) / len(np.unique(np.concatenate(cells))), len(times) / len(places))


def _cells(outline: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return numbers of the cells within a convex outline, of a raster that has no end; shape (n,)."""
    if not len(outline):
        return np.empty(0, dtype=np.int64)
    first = np.floor(outline.min(axis=0)).astype(np.int64)
    columns, rows = np.ceil(outline.max(axis=0)).astype(np.int64) - first + 1
    inside: NDArray[np.uint8] = np.zeros((rows, columns), dtype=np.uint8)
    cv2.fillConvexPoly(inside, np.rint(outline - first).astype(np.int32), (1,))
    row, column = np.nonzero(inside)
    return np.asarray((first[1] + row) * _ROW_CELLS + first[0] + column, dtype=np.int64)


def ground_height_m(views: Sequence[Placed], surface: FocalSurface) -> float:
    """Return the median height of a surface below cameras; NaN where it is known below none."""
    heights_m = [float(surface.z_m(*view.pose.position_enu_m[:2])) for view in views]
    known = [height_m for height_m in heights_m if np.isfinite(height_m)]
    return float(np.median(known)) if known else float("nan")
