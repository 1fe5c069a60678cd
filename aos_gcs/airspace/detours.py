"""Paths around no-go zones and notches of the geofence, where the straight segment is blocked.

The shortest path between two points past polygons bends at their corners only, so it is searched on the graph of
corners that see each other [de Berg et al., Computational Geometry, chapter 15].
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.polygon import Boundary, edges, signed_area_m2
from aos_gcs.airspace.separation import TOLERANCE_M, near_pairs, point_segment_distance, segment_distance

FloatArray = NDArray[np.float64]

_START, _END = -1, -2


class Detours:
    """The admissible paths within one set of boundaries.

    Args:
        boundaries: the fence and the no-go zones; every path keeps their margins, which vetting requires of a segment.
        slack_m: distance by which vehicles may miss a corner and still see the next one; their arrival radius.
    """

    def __init__(self, boundaries: Sequence[Boundary], slack_m: float) -> None:
        self._boundaries = boundaries
        self._slack_m = slack_m
        starts, ends = zip(*(edges(boundary.vertices_m) for boundary in boundaries), strict=True)
        self._edge_starts, self._edge_ends = np.concatenate(starts), np.concatenate(ends)
        self._edge_counts = [len(boundary.vertices_m) for boundary in boundaries]
        self._margins_m = self._per_edge([boundary.margin_m for boundary in boundaries])
        self._corners_m = self._admissible(
            np.array([c for b in boundaries for c in _corners(b, b.margin_m + 2.0 * slack_m)]).reshape(-1, 2)
        )
        self._seen_from: dict[int, NDArray[np.bool_]] = {}

    def reachable(self, point_m: FloatArray) -> FloatArray:
        """Return the admissible place nearest to a point, shape (2,): the point itself unless it lies in a zone."""
        if len(self._admissible(point_m[None])):
            return point_m
        _, fraction = point_segment_distance(point_m, self._edge_starts, self._edge_ends)
        along = self._edge_ends - self._edge_starts
        feet_m = self._edge_starts + fraction[:, None] * along
        normals = np.column_stack([along[:, 1], -along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
        step_m = (self._margins_m + self._slack_m)[:, None] * normals
        places_m = self._admissible(np.vstack([feet_m + step_m, feet_m - step_m, self._corners_m]))
        if len(places_m) == 0:
            return point_m
        return np.asarray(places_m[np.linalg.norm(places_m - point_m, axis=1).argmin()])

    def next_corners(self, starts_m: FloatArray, ends_m: FloatArray) -> list[FloatArray | None]:
        """Return the first corner, shape (2,), of the shortest path between each two points, shape (n, 2) each.

        None: the straight segment is clear, or there is no path at all.
        """
        corners_m: list[FloatArray | None] = [None] * len(starts_m)
        near = np.flatnonzero(~self._are_far(starts_m, ends_m))
        are_clear = self._are_clear(starts_m[near], ends_m[near], self._required_m(starts_m[near]))
        for index in near[~are_clear].tolist():
            if (came_from := self._search(starts_m[index], ends_m[index])) is not None:
                corners_m[index] = self._first_corner(came_from)
        return corners_m

    def has_path(self, start_m: FloatArray, end_m: FloatArray) -> bool:
        """Return whether a path joins two points, shape (2,) each, on the allowed side of all boundaries."""
        return self._is_clear(start_m, end_m) or self._search(start_m, end_m) is not None

    def reached(self, start_m: FloatArray, ends_m: FloatArray) -> NDArray[np.bool_]:
        """Return which places, shape (k, 2), a path reaches from a point, shape (2,), with the margin kept there."""
        is_reached = self._sees(start_m, ends_m, self._required_m(start_m[None])[0])
        is_reached[is_reached] = self._is_admissible(ends_m[is_reached])
        settled, waiting = {_START}, [_START]
        while waiting and not is_reached.all():
            node = waiting.pop()
            here_m = start_m if node == _START else self._corners_m[node]
            if node != _START:
                unreached = np.flatnonzero(~is_reached)
                is_reached[unreached] = self._sees(here_m, ends_m[unreached], self._margins_m)
            found = set(np.flatnonzero(self._corners_seen(node, here_m)).tolist()) - settled
            settled |= found
            waiting += sorted(found)
        return is_reached

    def _are_far(self, starts_m: FloatArray, ends_m: FloatArray) -> NDArray[np.bool_]:
        """Return which straight segments, ends of shape (n, 2), have no edge within reach."""
        edges_m = point_segment_distance(starts_m[:, None], self._edge_starts, self._edge_ends)[0]
        lengths_m = np.hypot(*(ends_m - starts_m).T)
        return np.asarray((edges_m - lengths_m[:, None] > np.maximum(self._margins_m, 2.0 * TOLERANCE_M)).all(axis=1))

    def _is_clear(self, start_m: FloatArray, end_m: FloatArray) -> bool:
        if self._are_far(start_m[None], end_m[None])[0]:
            return True
        return bool(self._are_clear(start_m[None], end_m[None], self._required_m(start_m[None]))[0])

    def _search(self, start_m: FloatArray, end_m: FloatArray) -> dict[int, int] | None:
        """Return the predecessor of each corner on the shortest path, by A*; None if there is no path."""
        came_from, queue = {_START: _START}, [(0.0, 0.0, _START, _START)]
        settled: set[int] = set()
        while queue:
            _, flown_m, node, previous = heapq.heappop(queue)
            if node in settled:
                continue
            settled.add(node)
            came_from[node] = previous
            if node == _END:
                return came_from
            here_m = start_m if node == _START else self._corners_m[node]
            for following, length_m in self._legs(node, here_m, end_m):
                if following not in settled:
                    there_m = end_m if following == _END else self._corners_m[following]
                    path_m = flown_m + length_m
                    heapq.heappush(queue, (path_m + math.dist(there_m, end_m), path_m, following, node))
        return None

    def _first_corner(self, came_from: dict[int, int]) -> FloatArray:
        node = _END
        while came_from[node] != _START:
            node = came_from[node]
        return np.array(self._corners_m[node])

    def _legs(self, node: int, here_m: FloatArray, end_m: FloatArray) -> Iterator[tuple[int, float]]:
        """Yield what is seen from a node, the corners and the end, with the distance."""
        if node != _START and self._sees(here_m, end_m[None], self._margins_m)[0]:
            yield _END, math.dist(here_m, end_m)
        for corner in np.flatnonzero(self._corners_seen(node, here_m)):
            yield int(corner), math.dist(here_m, self._corners_m[corner])

    def _corners_seen(self, node: int, here_m: FloatArray) -> NDArray[np.bool_]:
        """Return which corners are seen from a node, shape (c,)."""
        if node == _START:
            return self._sees(here_m, self._corners_m, self._required_m(here_m[None])[0])
        if node not in self._seen_from:
            self._seen_from[node] = self._sees(here_m, self._corners_m, self._margins_m + self._slack_m)
        return self._seen_from[node]

    def _per_edge(self, values: Sequence[float]) -> FloatArray:
        """Return one value per boundary as one per edge."""
        return np.repeat(np.array(values, dtype=np.float64), self._edge_counts)

    def _required_m(self, points_m: FloatArray) -> FloatArray:
        """Return the distances that segments from points, shape (n, 2), keep from the edges; infinity beyond one."""
        depths_m = np.array([boundary.depths_m(points_m) for boundary in self._boundaries])
        margins_m = np.array([[boundary.margin_m] for boundary in self._boundaries])
        required_m = np.where(depths_m > 0.0, np.minimum(margins_m, depths_m), np.inf)
        return np.asarray(np.repeat(required_m, self._edge_counts, axis=0).T)

    def _sees(self, here_m: FloatArray, there_m: FloatArray, required_m: FloatArray) -> NDArray[np.bool_]:
        """Return which points, shape (n, 2), a segment reaches that keeps the distances and meets no edge."""
        shape = len(there_m), len(self._edge_starts)
        return self._are_clear(np.broadcast_to(here_m, there_m.shape), there_m, np.broadcast_to(required_m, shape))

    def _are_clear(self, starts_m: FloatArray, ends_m: FloatArray, required_m: FloatArray) -> NDArray[np.bool_]:
        """Return which segments, ends of shape (n, 2), keep distances, shape (n, edges), and meet no edge."""
        least_m = np.maximum(required_m - TOLERANCE_M, 2.0 * TOLERANCE_M)
        are_clear = np.asarray(np.isfinite(least_m).all(axis=1))
        rows = np.flatnonzero(are_clear)
        if not rows.size:
            return are_clear
        nearest_m = float(least_m[rows].max())
        near, edge = near_pairs(starts_m[rows], ends_m[rows], self._edge_starts, self._edge_ends, nearest_m)
        row = rows[near]
        gaps_m = segment_distance(starts_m[row], ends_m[row], self._edge_starts[edge], self._edge_ends[edge])
        are_clear[row[gaps_m < least_m[row, edge]]] = False
        return are_clear

    def _admissible(self, points_m: FloatArray) -> FloatArray:
        """Return those of the points, shape (n, 2), that keep every boundary's margin."""
        return np.array(points_m[self._is_admissible(points_m)])

    def _is_admissible(self, points_m: FloatArray) -> NDArray[np.bool_]:
        least_m = [max(boundary.margin_m - TOLERANCE_M, 2.0 * TOLERANCE_M) for boundary in self._boundaries]
        bounds = list(zip(self._boundaries, least_m, strict=True))
        clear = [all(boundary.depth_m(point_m) >= m for boundary, m in bounds) for point_m in points_m]
        return np.array(clear, dtype=np.bool_)


def _corners(boundary: Boundary, distance_m: float) -> Iterator[FloatArray]:
    """Yield the points where paths bend around a boundary: its convex corners, moved off to a distance.

    Sharp corners get two points, so that no vehicle flies far out to the tip of a mitre.
    """
    vertices_m = boundary.vertices_m
    # Seen counter-clockwise around the blocked side, convex corners turn left.
    if (signed_area_m2(vertices_m) > 0.0) == boundary.keeps_in:
        vertices_m = vertices_m[::-1]
    incoming = vertices_m - np.roll(vertices_m, 1, axis=0)
    outgoing = np.roll(incoming, -1, axis=0)
    headings_rad = np.arctan2(incoming[:, 1], incoming[:, 0])
    turns_rad = np.arctan2(
        incoming[:, 0] * outgoing[:, 1] - incoming[:, 1] * outgoing[:, 0], np.einsum("ij,ij->i", incoming, outgoing)
    )
    for vertex_m, heading_rad, turn_rad in zip(vertices_m, headings_rad, turns_rad, strict=True):
        if turn_rad <= 0.0:
            continue
        count = math.ceil(turn_rad / (0.5 * math.pi) - 1e-9)
        part_rad = turn_rad / count
        for part in range(count):
            normal_rad = heading_rad - 0.5 * math.pi + (part + 0.5) * part_rad
            reach_m = distance_m / math.cos(0.5 * part_rad)
            yield vertex_m + reach_m * np.array([math.cos(normal_rad), math.sin(normal_rad)])
