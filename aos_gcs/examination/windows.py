"""Windows of overlapping frames along a recorded flight."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.focal_plane import footprint
from aos_gcs.surveys.seen_ground import SeenGround
from aos_gcs.surveys.significance import MIN_VIEWS
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

    frames: tuple[int, ...]
    """Indices of its frames in the recording, in ascending order."""

    @property
    def first(self) -> int:
        """Index of its first frame."""
        return self.frames[0]

    @property
    def last(self) -> int:
        """Index of its last frame."""
        return self.frames[-1]


def plan_windows(views: Sequence[Placed], ground_m: float) -> tuple[FrameWindow, ...]:
    """Return windows that hold every frame of a flight, each of at least two frames where there are as many.

    Where the pictures of several flights alternate, as those of two drones do in the order of their times, windows are
    those of each flight alone; otherwise they hold frames as they follow each other.

    Args:
        views: cameras and poses of the frames, in the order of the recording.
        ground_m: height of the ground.
    """
    flights = runs(views, ground_m)
    if [index for flight in flights for index in flight] == list(range(len(views))):
        # None alternates with another: what follows a gap belongs to the same flight.
        flights = (tuple(range(len(views))),)
    return tuple(
        FrameWindow(tuple(flight[place] for place in places))
        for flight in flights
        for places in _successive([views[index] for index in flight], ground_m)
    )


def runs(views: Sequence[Placed], ground_m: float) -> tuple[tuple[int, ...], ...]:
    """Return the indices of frames by stretches of flight, in the order of the first frames of these.

    A frame continues the stretch that was continued last of those whose latest frame it shares ground with. A stretch
    that none of the :data:`MAX_FRAMES` frames before has continued has ended: who returns to a place begins anew.

    Args:
        views: cameras and poses of the frames, in the order of the recording.
        ground_m: height of the ground.
    """
    found: list[list[int]] = []
    recent: list[tuple[list[int], float]] = []
    for index, view in enumerate(views):
        recent = [(run, reach_m) for run, reach_m in recent if run[-1] >= index - MAX_FRAMES]
        place, (run, _) = next(
            (
                (place, (run, reach_m))
                for place, (run, reach_m) in enumerate(recent)
                if _distance_m(views[run[-1]], view) <= reach_m
            ),
            (None, ([], 0.0)),
        )
        if place is None:
            found.append(run)
        else:
            del recent[place]
        run.append(index)
        recent.insert(0, (run, _extent_m(view, ground_m)))
    return tuple(tuple(run) for run in found)


def _successive(views: Sequence[Placed], ground_m: float) -> Iterator[range]:
    """Yield windows of frames that follow each other."""
    count, first = len(views), 0
    while True:
        end = min(max(_end(views, first, ground_m), first + 2), count)
        yield range(first, end)
        if end == count:
            return
        # The next window overlaps this one, but begins where the rest of the flight still fills it.
        first = max(first + 1, min(first + round(ADVANCE * (end - first)), count - 2))


def _end(views: Sequence[Placed], first: int, ground_m: float) -> int:
    reach_m = MAX_REACH * _extent_m(views[first], ground_m)
    last = min(first + MAX_FRAMES, len(views))
    for index in range(first + 1, last):
        if _distance_m(views[first], views[index]) > reach_m:
            return index
    return last


def _extent_m(view: Placed, ground_m: float) -> float:
    """Return the longer edge of the ground that a frame sees; 0 if it sees none."""
    outline_m = footprint(view.camera, view.pose, ground_m)
    return float(np.ptp(outline_m, axis=0).max()) if len(outline_m) else 0.0


def _distance_m(one: Placed, other: Placed) -> float:
    return float(np.linalg.norm(one.pose.position_enu_m[:2] - other.pose.position_enu_m[:2]))


@dataclass(frozen=True, slots=True)
class ExaminedGround:
    """Ground on which enough frames of a window can agree."""

    share: float
    """Share of the ground that frames see and that has a height."""
    windows_per_place: float
    """Number of windows that examine a place in the mean, at least 1: each gives chance another try."""


def examined_ground(seen: SeenGround, windows: Sequence[Sequence[int]]) -> ExaminedGround:
    """Return what windows examine. What it takes follows from the views of frames, not from how far they lie apart.

    Args:
        seen: ground that the frames see.
        windows: indices of the frames of each window that take part in it.
    """
    examined: list[NDArray[np.int64]] = [np.empty(0, dtype=np.int64)]
    for window in windows:
        if len(window):
            places, counts = np.unique(np.concatenate([seen.cells[index] for index in window]), return_counts=True)
            examined.append(places[counts >= MIN_VIEWS])
    times = np.concatenate(examined)
    if not len(times):
        return ExaminedGround(0.0, 1.0)
    places = np.unique(times)
    return ExaminedGround(len(places) / seen.known, len(times) / len(places))
