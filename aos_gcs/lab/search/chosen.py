"""The rival of parallel legs: every vehicle flies on to where it expects to see most of the ground anew per second.

After the visibility heuristic of arXiv 2511.18353, on the tile grid of the searched ground: before anything is seen, a
vehicle's next stretch is the one whose frames gain most probability of detection per second, over all cells that they
show, by the directions that are new there. Stretches of three lengths in sixteen directions are compared, and one to
the cell that lacks most for its distance, so that nobody stays where all is seen. Turning costs the time in which the
velocity changes. Vehicles choose one after the other, whoever arrives first, and know what the others have chosen.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.groundmap.detection import DETECTABILITY, Posture, detection_by_views
from aos_gcs.groundmap.directions import ViewDirections
from aos_gcs.groundmap.tile import MAX_VIEWS
from aos_gcs.lab.search.paths import SearchFlight, ordered
from aos_gcs.planning.detection.expected_views import forest_directions
from aos_gcs.planning.estimate import ACCELERATION_MPS2, CLIMB_MPS, SINK_MPS, STILL_S, move_s
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.proposal import altitude_layers
from aos_gcs.planning.settings import ForestSettings

FloatArray = NDArray[np.float64]

CELL_M: Final = 4.0
"""Edge of a cell whose views are counted."""
_LENGTHS_M: Final = (15.0, 30.0, 60.0)
_DIRECTIONS: Final = 16
SPEEDS_MPS: Final = (4.0, 7.0)
"""Speeds that are tried beside that of the planned legs."""
LONGEST_S: Final = 7200.0
"""Time after which a search that does not reach what is wanted is given up."""


class ViewedCells:
    """Cells of the area, and the directions from which each was seen."""

    @classmethod
    def of(cls, half_m: float, forest: ForestSettings) -> ViewedCells:
        """Return the cells of a square area about the origin, nothing of which was seen.

        Args:
            half_m: half of its side.
            forest: forest above it.
        """
        return cls(half_m, forest_directions(forest), forest.occlusion)

    def __init__(self, half_m: float, directions: ViewDirections, occlusion: float) -> None:
        side = math.ceil(2.0 * half_m / CELL_M)
        middles_m = (np.arange(side) + 0.5) * (2.0 * half_m / side) - half_m
        self.middles_m = middles_m
        self._directions = directions
        self._seen = np.zeros((side, side, directions.side**2), dtype=np.bool_)
        self.views = np.zeros((side, side), dtype=np.int64)
        self._law = detection_by_views(occlusion, DETECTABILITY[Posture.STANDING])

    @property
    def detection(self) -> FloatArray:
        """Probability of detection by cell, shape (rows from the south, columns)."""
        return np.asarray(self._law[self.views])

    def shown(self, cameras_m: FloatArray, half_view: float) -> tuple[NDArray[np.intp], NDArray[np.int64]]:
        """Return which cells frames show for the first time from a direction: index of the cell and the square."""
        side = len(self.middles_m)
        cells, squares = [], []
        for camera_m in cameras_m:
            reach_m = camera_m[2] * half_view
            first, last = (
                np.searchsorted(self.middles_m, camera_m[:2] - reach_m),
                np.searchsorted(self.middles_m, camera_m[:2] + reach_m),
            )
            east_m, north_m = self.middles_m[first[0] : last[0]], self.middles_m[first[1] : last[1]]
            places = np.zeros((len(north_m), len(east_m), 3))
            places[..., 0], places[..., 1] = east_m, north_m[:, np.newaxis]
            index, _ = self._directions.squares(camera_m, places)
            rows, columns = np.mgrid[first[1] : last[1], first[0] : last[0]]
            cells.append((rows * side + columns).ravel())
            squares.append(index.ravel().astype(np.int64))
        cell, square = np.concatenate(cells), np.concatenate(squares)
        key = np.unique(cell * self._directions.side**2 + square)
        cell, square = np.divmod(key, self._directions.side**2)
        new = ~self._seen.reshape(side * side, -1)[cell, square]
        return cell[new], square[new]

    def gain(self, cells: NDArray[np.intp]) -> float:
        """Return the probability of detection, summed over cells, that new directions on these cells gain."""
        if not len(cells):
            return 0.0
        which, counts = np.unique(cells, return_counts=True)
        before = self.views.reshape(-1)[which]
        return float((self._law[np.minimum(before + counts, MAX_VIEWS)] - self._law[before]).sum())

    def add(self, cells: NDArray[np.intp], squares: NDArray[np.int64]) -> None:
        """Note new directions on cells."""
        self._seen.reshape(self.views.size, -1)[cells, squares] = True
        np.add.at(self.views.reshape(-1), cells, 1)
        np.minimum(self.views, MAX_VIEWS, out=self.views)


def fly_chosen(plan: MissionPlan, pod: float) -> SearchFlight | None:
    """Return the flight of vehicles that choose their views, at the best of some speeds.

    Arguments and result as of :func:`fly_chosen_at`.
    """
    speeds_mps = {plan.leg_speed_mps, *SPEEDS_MPS}
    flights = [fly_chosen_at(plan, pod, speed_mps) for speed_mps in sorted(speeds_mps)]
    return min((one for one in flights if one is not None), key=lambda one: one.duration_s, default=None)


def fly_chosen_at(plan: MissionPlan, pod: float, mps: float) -> SearchFlight | None:
    """Return the flight of vehicles that choose their views, until the expected probability of detection is reached.

    Args:
        plan: plan with a forest and a launch point, of a square area about the origin.
        pod: wanted mean over the area.
        mps: their speed.

    Returns:
        None where that takes hours.
    """
    if plan.forest is None or plan.launch_enu_m is None:
        return None
    half_m = plan.area_enu_m[2][0]
    ground = ViewedCells.of(half_m, plan.forest)
    half_view = math.tan(plan.camera_fov_rad / 2.0)
    heights_m = altitude_layers(plan.vehicles, plan.lowest_layer_m, plan.layer_spacing_m)
    launch_m = np.array(plan.launch_enu_m)
    places_m = [launch_m.copy() for _ in heights_m]
    courses: list[FloatArray | None] = [None] * len(heights_m)
    free = [(plan.highest_layer_m / CLIMB_MPS + STILL_S, number) for number in range(len(heights_m))]
    times_s, cameras_m, path_m = [], [], 0.0
    while float(ground.detection.mean()) < pod:
        now_s, number = heapq.heappop(free)
        if now_s > LONGEST_S:
            return None
        here_m = places_m[number]
        best = (-1.0, 0.0, here_m, np.empty(0), np.empty((0, 3)))
        for target_m in targets(ground, here_m, half_m, _LENGTHS_M):
            length_m = math.dist(here_m, target_m)
            if length_m < mps / plan.rate_hz:
                continue  # nothing is exposed on the way
            course = (target_m - here_m) / length_m
            along_m = np.arange(mps / plan.rate_hz, length_m + 1e-6, mps / plan.rate_hz)
            cameras = np.full((len(along_m), 3), heights_m[number])
            cameras[:, :2] = here_m + along_m[:, np.newaxis] * course
            turn_s = _turn_s(courses[number], course, mps)
            cells, _ = ground.shown(cameras, half_view)
            rate = ground.gain(cells) / (length_m / mps + turn_s)
            if rate > best[0]:
                best = (rate, turn_s, target_m, along_m, cameras)
        _, turn_s, target_m, along_m, cameras = best
        length_m = math.dist(here_m, target_m)
        ground.add(*ground.shown(cameras, half_view))
        times_s.append(now_s + turn_s + along_m / mps)
        cameras_m.append(cameras)
        path_m += length_m
        places_m[number], courses[number] = target_m, (target_m - here_m) / length_m
        heapq.heappush(free, (now_s + turn_s + length_m / mps, number))
    home_m = [math.dist(place_m, launch_m) for place_m in places_m]
    ends_s = [now_s + move_s(home_m[number], plan.cruise_speed_mps) for now_s, number in free]
    return ordered(
        np.concatenate(times_s),
        np.concatenate(cameras_m),
        max(ends_s) + plan.highest_layer_m / SINK_MPS,
        path_m + sum(home_m),
    )


def targets(ground: ViewedCells, here_m: FloatArray, half_m: float, lengths_m: Sequence[float]) -> list[FloatArray]:
    """Return where a vehicle may fly next from a place, shape (2,), inside of the area.

    Args:
        ground: what was seen.
        here_m: the place.
        half_m: half of the side of the area.
        lengths_m: lengths of the stretches that are compared.
    """
    angles_rad = np.arange(_DIRECTIONS) * math.tau / _DIRECTIONS
    courses = np.column_stack((np.sin(angles_rad), np.cos(angles_rad)))
    targets = [here_m + length_m * course for length_m in lengths_m for course in courses]
    inside = [target_m for target_m in targets if np.abs(target_m).max() <= half_m]
    east_m, north_m = np.meshgrid(ground.middles_m, ground.middles_m)
    distance_m = np.hypot(east_m - here_m[0], north_m - here_m[1])
    lacking = np.unravel_index(int(((1.0 - ground.detection) / (distance_m + 30.0)).argmax()), distance_m.shape)
    return [*inside, np.array([east_m[lacking], north_m[lacking]])]


def _turn_s(before: FloatArray | None, after: FloatArray, mps: float) -> float:
    """Return the time in which the velocity turns from one course to another, or comes up from rest."""
    change_mps = mps if before is None else mps * math.dist(before, after)
    return change_mps / ACCELERATION_MPS2 / 2.0
