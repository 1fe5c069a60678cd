"""Warm bodies of the latest steps, each with its evidence and its place; all are located together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.geolocation import Geolocation, Uncertainty, locate_together
from aos_gcs.imaging.persons.evidence import Evidence, gather_evidence
from aos_gcs.imaging.persons.warm_bodies import LINK_M, WarmView, warm_bodies
from aos_gcs.imaging.surfaces.terrain import Terrain

MAX_LINES = 600
"""Lines of sight that bodies are located by: the time that it takes grows with their cube. Ten vehicles, three steps
and twenty bodies have as many."""


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """A warm body as the swarm knows it."""

    evidence: Evidence
    place: Geolocation
    points_enu_m: NDArray[np.float64]
    """Warm pixels of the body on the focal plane, shape (k, 2)."""
    views: tuple[WarmView, ...]
    """Parts of the views that show it."""

    def distance_m(self, place_enu_m: NDArray[np.float64]) -> float:
        """Return the distance of its nearest pixel from a place, shape (2,)."""
        return float(np.linalg.norm(self.points_enu_m - place_enu_m, axis=1).min())


def find_bodies(
    views: Sequence[WarmView],
    plane_height_m: float,
    uncertainty: Uncertainty,
    wanted_enu_m: Sequence[NDArray[np.float64]] = (),
    ground: Terrain | None = None,
    *,
    linked: Sequence[tuple[WarmView, ...]] | None = None,
) -> tuple[Body, ...]:
    """Return the warm bodies that frames show: those at wanted places, then the ones with the most pixels.

    Args:
        views: views of one step or several, of cameras that hover.
        plane_height_m: ENU height of the focal plane.
        uncertainty: of the poses, the ground and the bodies.
        wanted_enu_m: places, shape (2,), whose bodies are found however many larger ones there are.
        ground: the ground in view that bodies are on, where it is known.
        linked: the views' bodies (:func:`~aos_gcs.imaging.persons.warm_bodies.warm_bodies`), where the caller has them.
    """
    linked = warm_bodies(views) if linked is None else linked
    bodies = _within_limit(sorted(linked, key=lambda body: not _is_at_any(body, wanted_enu_m)))
    lines = [[view.as_blob_view() for view in body] for body in bodies]
    places = locate_together(lines, plane_height_m, uncertainty, ground=ground)
    return tuple(
        Body(
            gather_evidence(body, views, plane_height_m),
            place,
            np.concatenate([view.points_enu_m for view in body]),
            body,
        )
        for body, place in zip(bodies, places, strict=True)
    )


def _is_at_any(body: Sequence[WarmView], places_enu_m: Sequence[NDArray[np.float64]]) -> bool:
    points_enu_m = np.concatenate([view.points_enu_m for view in body])
    return any(float(np.linalg.norm(points_enu_m - place, axis=1).min()) <= LINK_M for place in places_enu_m)


def _within_limit(bodies: Sequence[tuple[WarmView, ...]]) -> list[tuple[WarmView, ...]]:
    """Return the first bodies with at most ``MAX_LINES`` views together; of a single one, evenly spaced views."""
    kept: list[tuple[WarmView, ...]] = []
    for body in bodies:
        left = MAX_LINES - sum(map(len, kept))
        if kept and len(body) > left:
            break
        kept.append(body[:: -(-len(body) // MAX_LINES)])
    return kept
