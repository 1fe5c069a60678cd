"""Windows of overlapping frames along a recorded flight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aos_gcs.imaging.focal_plane import footprint
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.surveys.tiles import Placed

MAX_FRAMES = 30
"""Largest number of frames of a window."""
MAX_REACH = 2.0
"""Largest distance of a window's frames from its first one, in footprints of that one: farther ones share no ground."""
ADVANCE = 2.0 / 3.0
"""Share of a window after which the next one begins: places at its end are in the middle of that one."""


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


def ground_height_m(views: Sequence[Placed], surface: FocalSurface) -> float:
    """Return the median height of a surface below cameras; NaN where it is known below none."""
    heights_m = [float(surface.z_m(*view.pose.position_enu_m[:2])) for view in views]
    known = [height_m for height_m in heights_m if np.isfinite(height_m)]
    return float(np.median(known)) if known else float("nan")
