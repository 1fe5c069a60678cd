"""Windows of overlapping frames along a recorded flight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.projection import Plane
from aos_gcs.imaging.focal_plane import footprint
from aos_gcs.imaging.surfaces.ground import choose_raster
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


def plan_windows(views: Sequence[Placed], ground_m: float, max_frames: int = MAX_FRAMES) -> tuple[FrameWindow, ...]:
    """Return windows that hold every frame of a flight, each of at least two frames where there are as many.

    Args:
        views: cameras and poses of the frames, in the order of the flight.
        ground_m: height of the ground.
        max_frames: largest number of frames of a window.
    """
    count, first = len(views), 0
    windows: list[FrameWindow] = []
    while True:
        end = min(max(_end(views, first, ground_m, max_frames), first + 2), count)
        windows.append(FrameWindow(first, end))
        if end == count:
            return tuple(windows)
        # The next window overlaps this one, but begins where the rest of the flight still fills it.
        first = max(first + 1, min(first + round(ADVANCE * (end - first)), count - 2))


def _end(views: Sequence[Placed], first: int, ground_m: float, max_frames: int) -> int:
    outline_m = footprint(views[first].camera, views[first].pose, ground_m)
    reach_m = MAX_REACH * float(np.ptp(outline_m, axis=0).max()) if len(outline_m) else 0.0
    start_m = views[first].pose.position_enu_m[:2]
    for index in range(first + 1, min(first + max_frames, len(views))):
        if np.linalg.norm(views[index].pose.position_enu_m[:2] - start_m) > reach_m:
            return index
    return min(first + max_frames, len(views))


def windows_per_place(views: Sequence[Placed], windows: Sequence[FrameWindow], ground_m: float) -> float:
    """Return how many windows examine a place of the ground in the mean, at least 1: each gives chance another try.

    Args:
        views: cameras and poses of the frames.
        windows: windows of these.
        ground_m: height of the ground.

    Raises:
        ImagingError: if no frame sees the ground.
    """
    raster = choose_raster([(view.camera, view.pose) for view in views], Plane(ground_m), _COARSE_M)
    to_cells = np.linalg.inv(raster.to_plane)
    outlines = []
    for view in views:
        outline_m = footprint(view.camera, view.pose, ground_m)
        cells = to_cells @ np.column_stack((outline_m, np.ones(len(outline_m)))).T
        outlines.append(np.rint(cells[:2].T).astype(np.int32))
    shape = raster.rows, raster.columns
    times: NDArray[np.int64] = np.zeros(shape, dtype=np.int64)
    for window in windows:
        seen: NDArray[np.int64] = np.zeros(shape, dtype=np.int64)
        for index in window.frames:
            if len(outlines[index]):
                inside: NDArray[np.uint8] = np.zeros(shape, dtype=np.uint8)
                cv2.fillConvexPoly(inside, outlines[index], (1,))
                seen += inside
        times += seen >= MIN_VIEWS
    return float(times.sum() / np.count_nonzero(times)) if times.any() else 1.0


def ground_height_m(views: Sequence[Placed], surface: FocalSurface) -> float:
    """Return the median height of a surface below cameras; NaN where it is known below none."""
    heights_m = [float(surface.z_m(*view.pose.position_enu_m[:2])) for view in views]
    known = [height_m for height_m in heights_m if np.isfinite(height_m)]
    return float(np.median(known)) if known else float("nan")
