"""One decision of the archive strategy: which drones hold which views, and where the others explore."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from aos_gcs.swarm.archive_exploration import SAMPLED, TIE_BREAK, choose_goals, kernel, lattice, predicted, values
from aos_gcs.swarm.archive_looks import Looks, Sightlines
from aos_gcs.swarm.archive_moves import assigned
from aos_gcs.swarm.archive_parameters import ArchiveParameters
from aos_gcs.swarm.archive_raster import BoolArray, FloatArray, IntArray, anchor_of, footprints
from aos_gcs.swarm.archive_selection import Outlook, Views, choose_views, still_held
from aos_gcs.swarm.archive_target import TargetEstimate

MAX_CANDIDATES = 150
"""Looks among which the views to hold are chosen: those that show most."""
MIN_CONFIDENCE = 0.2
"""In a look's mask, less since the target has moved, below which it is no candidate."""
SAME_VIEW_M = 0.4
"""Distance in the canopy below which a candidate is the view chosen the step before."""


@dataclass(frozen=True, slots=True, eq=False)
class Goals:
    """What comes of a decision."""

    positions_enu_m: NDArray[np.float64]
    """Of all drones, shape (n, 2)."""
    held_enu_m: NDArray[np.float64]
    """Where the lines of sight of the chosen views pass the canopy, shape (k, 2)."""


@dataclass(frozen=True, slots=True, eq=False)
class Prospect:
    """What the archive means for the target's place at the next step."""

    target_enu_m: FloatArray
    """Shape (2,)."""
    height_m: float
    """Mean height of the swarm: slopes times it are places on one plane."""
    lines: Sightlines
    """From there through the crossings of the k looks."""
    shown: NDArray[np.float32]
    """Masks times the confidence in them, shape (k, CELLS)."""
    confidence: FloatArray
    """Below 1 for lines that the target's motion has turned, shape (k,)."""

    @classmethod
    def of(cls, looks: Looks, target: TargetEstimate, height_m: float, parameters: ArchiveParameters) -> Prospect:
        """Return the prospect of an archive."""
        target_enu_m = target.position_enu_m + target.next_way_m
        canopy = parameters.canopy
        lines = canopy.lines_through(target_enu_m, looks.lines.crossings_enu_m)
        confidence = kernel(canopy.turned_m(lines, looks.lines), parameters.kernel_m)
        masks = looks.masks_at(anchor_of(target_enu_m), np.array(target.drift_enu_m) + target.next_way_m)
        return cls(target_enu_m, height_m, lines, (masks * confidence[:, None]).astype(np.float32), confidence)

    def candidates(self, radius_m: float) -> IntArray:
        """Return the looks that may be held, the best first: within the aperture, and showing anything."""
        within = np.linalg.norm(self.lines.slopes, axis=1) * self.height_m <= radius_m
        showing = self.shown.sum(axis=1)
        usable = np.flatnonzero(within & (self.confidence > MIN_CONFIDENCE) & (showing > 0.0))
        return usable[np.argsort(-showing[usable], kind="stable")[:MAX_CANDIDATES]]

    def positions(self, slopes: FloatArray, heights_m: FloatArray) -> FloatArray:
        """Return where drones at heights of shape (n,) see the target under slopes (k, 2), shape (n, k, 2)."""
        return np.asarray(self.target_enu_m + slopes * heights_m[:, None, None])


def plan(
    looks: Looks,
    target: TargetEstimate,
    *,
    positions_enu_m: FloatArray,
    heights_m: FloatArray,
    held_enu_m: FloatArray | None,
    parameters: ArchiveParameters,
    rng: np.random.Generator,
) -> Goals:
    """Return where the drones should go.

    Args:
        looks: the archive.
        target: what they are of.
        positions_enu_m: of the drones in the order of their ids, shape (n, 2).
        heights_m: of the drones above the focal plane, shape (n,).
        held_enu_m: of the decision before, or None.
        parameters: of the strategy.
        rng: breaks ties between spots to explore.
    """
    # Whole metres, so that the spots stay where they are while heights are measured with noise.
    prospect = Prospect.of(looks, target, round(float(heights_m.mean())), parameters)
    places_m = positions_enu_m + target.next_way_m
    spots = parameters.canopy.lines_of_slopes(
        prospect.target_enu_m, lattice(parameters.aperture_radius_m, parameters.spot_pitch_m) / prospect.height_m
    )
    weights = kernel(parameters.canopy.distances_m(spots, looks.lines), parameters.kernel_m)
    familiarity = weights.max(axis=1, initial=0.0)
    count = count_holding(len(places_m), float(np.mean(familiarity > SAMPLED)), parameters.explorer_share)

    candidates = prospect.candidates(parameters.aperture_radius_m)
    footprint = _spot_footprints(prospect.height_m, parameters)
    views, cells = _views(prospect, candidates, np.asarray(footprint.any(axis=0)), parameters)
    held = [] if held_enu_m is None else _still_held(prospect.lines[candidates], views, held_enu_m)
    chosen = choose_views(views, count, held, parameters.area_exponent, parameters.hysteresis)
    lines = prospect.lines[candidates[chosen]]

    goals_m = places_m.copy()
    view_goals_m = prospect.positions(lines.slopes, heights_m)
    goal_of = assigned(places_m, view_goals_m)
    holders = np.flatnonzero(goal_of >= 0)
    goals_m[holders] = view_goals_m[holders, goal_of[holders]]

    shown, spot_footprints = prospect.shown[:, cells], footprint[:, cells].astype(np.float32)
    value = values(
        Outlook.of(views, chosen.tolist()),
        predicted(weights, shown, spot_footprints),
        spot_footprints,
        familiarity,
        1.0 - shown.max(axis=0, initial=0.0),
        area_exponent=parameters.area_exponent,
        curiosity=parameters.curiosity,
        history_weight=parameters.history_weight,
    )
    explorers = np.flatnonzero(goal_of < 0)
    spot_goals_m = prospect.positions(spots.slopes, heights_m[explorers])
    spot_of = choose_goals(
        value + TIE_BREAK * rng.random(len(value)),
        spots.slopes * prospect.height_m,
        np.linalg.norm(spot_goals_m - places_m[explorers, None], axis=2),
        lines.slopes * prospect.height_m,
        spacing_m=parameters.min_distance_m,
        cost_per_m=parameters.travel_cost_per_m,
    )
    for row, (drone, spot) in enumerate(zip(explorers, spot_of, strict=True)):
        if spot is not None:
            goals_m[drone] = spot_goals_m[row, spot]
    return Goals(goals_m, lines.crossings_enu_m)


def count_holding(n: int, sampled_share: float, explorer_share: float) -> int:
    """Return how many of n drones hold views: as many as the part of the aperture that is known, and two at least."""
    most = max(1, n - math.ceil(explorer_share * n))
    return min(max(math.ceil(n * sampled_share), 2), most)


def _views(
    prospect: Prospect, candidates: IntArray, cells: BoolArray, parameters: ArchiveParameters
) -> tuple[Views, BoolArray]:
    """Return the candidates, and the cells of the raster they are given on: those asked for and all they may show."""
    lines, shown = prospect.lines[candidates], prospect.shown[candidates]
    # What is seen would be seen without forest too, whatever the model of the body says.
    footprint = _footprints(lines, prospect.height_m, parameters) | (shown > 0.0)
    cells = cells | footprint.any(axis=0)
    places_m = lines.slopes * prospect.height_m
    distances_m = np.linalg.norm(places_m[:, None] - places_m, axis=2)
    conflicts = distances_m < parameters.min_distance_m
    return Views(shown[:, cells], footprint[:, cells].astype(np.float32), conflicts), cells


def _still_held(lines: Sightlines, views: Views, held_enu_m: FloatArray) -> list[int]:
    distances_m = np.linalg.norm(held_enu_m[:, None] - lines.crossings_enu_m, axis=2)
    return still_held(distances_m, views.conflicts, SAME_VIEW_M)


@lru_cache(maxsize=4)
def _spot_footprints(height_m: float, parameters: ArchiveParameters) -> BoolArray:
    slopes = lattice(parameters.aperture_radius_m, parameters.spot_pitch_m) / height_m
    return footprints(slopes, height_m, parameters.body_height_m, parameters.body_radius_m)


def _footprints(lines: Sightlines, height_m: float, parameters: ArchiveParameters) -> BoolArray:
    return footprints(lines.slopes, height_m, parameters.body_height_m, parameters.body_radius_m)
