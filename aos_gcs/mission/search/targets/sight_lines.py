"""Lines of sight to a person from all steps: a place that the latest few steps alone know worse.

Errors of attitude stay with a vehicle, and height and place of a body can hardly be told apart from one side. Lines of
many steps come from more vehicles and from more sides.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from aos_gcs.imaging.geolocation import Geolocation, Uncertainty, geolocate
from aos_gcs.imaging.model import BlobView
from aos_gcs.imaging.surfaces.terrain import Terrain

MAX_LINES = 200
"""Most lines that are kept, evenly from all steps; to locate a body by them takes 20 ms."""

MOVED_SIGMAS = 3.0
"""Distance, in standard deviations of the latest place, from which a body has moved: former lines are dropped then."""


_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
"""Multiples of it, modulo 1, are spread evenly however many there are."""


@dataclass(frozen=True, slots=True, eq=False)
class SightLine:
    """A view of a body, kept."""

    number: int
    """Counts the views of the body."""
    view: BlobView
    plane_height_m: float
    """Height of the focal plane that its point lies on."""

    @property
    def rank(self) -> float:
        """Rank by which lines are kept, the lowest first: those of any few are from all times and all vehicles."""
        return self.number * _GOLDEN % 1.0


@dataclass(frozen=True, slots=True, eq=False)
class SightLines:
    """Lines of sight to one body that stays, the oldest first."""

    lines: tuple[SightLine, ...] = ()
    count: int = 0
    """Number of all views so far."""

    def noted(self, views: Sequence[BlobView], plane_height_m: float) -> SightLines:
        """Return the lines with those of another step, whose views' points lie on a plane of that ENU height."""
        new = tuple(SightLine(self.count + index, view, plane_height_m) for index, view in enumerate(views))
        kept = sorted(sorted((*self.lines, *new), key=lambda line: line.rank)[:MAX_LINES], key=lambda line: line.number)
        return SightLines(tuple(kept), self.count + len(new))

    def extended(
        self,
        views: Sequence[BlobView],
        latest: Geolocation,
        plane_height_m: float,
        uncertainty: Uncertainty,
        ground: Terrain | None = None,
    ) -> tuple[SightLines, Geolocation]:
        """Return the lines with those of another step, and the place by all of them.

        Args:
            views: the step's own views of the body, at least one.
            latest: place by the latest steps alone.
            plane_height_m: ENU height of the focal plane that the views' points lie on.
            uncertainty: of the poses, the ground and the body.
            ground: the ground in view that it is on, where it is known.
        """
        both = self.noted(views, plane_height_m)
        on_plane = [_on_plane(line.view, line.plane_height_m, plane_height_m) for line in both.lines]
        together = geolocate(on_plane, plane_height_m, uncertainty, ground=ground)
        if _distance_m(together, latest) > MOVED_SIGMAS * _sigma_m(latest):
            return SightLines(count=self.count).noted(views, plane_height_m), latest
        return both, min(together, latest, key=_sigma_m)


def _on_plane(view: BlobView, from_height_m: float, to_height_m: float) -> BlobView:
    """Return a view with its point where its line of sight meets another focal plane."""
    if from_height_m == to_height_m:
        return view
    camera_m = view.pose.position_enu_m
    share = (to_height_m - camera_m[2]) / (from_height_m - camera_m[2])
    return replace(view, point_enu_m=camera_m[:2] + share * (view.point_enu_m - camera_m[:2]))


def _distance_m(one: Geolocation, other: Geolocation) -> float:
    return float(np.linalg.norm(one.position_enu_m[:2] - other.position_enu_m[:2]))


def _sigma_m(place: Geolocation) -> float:
    return math.sqrt(float(np.trace(place.covariance_m2[:2, :2])) / 2.0)
