"""One decision of the archive strategy: which drones look along which lines of sight next.

Lines that were looked along are known; of those that were not, what near ones have shown says something, and the rest
is hoped for. All drones together get the lines that are expected to show most of the target's body. A line that
disappoints is known from then on, so that its drone goes to look along another one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from aos_gcs.swarm.archive.body import learnt_body, voxel_cells
from aos_gcs.swarm.archive.exploration import KNOWN, expected_masks, kernel, lattice, likeness
from aos_gcs.swarm.archive.looks import Canopy, LookArchive, Sightlines, joined_lines
from aos_gcs.swarm.archive.moves import assigned
from aos_gcs.swarm.archive.parameters import AosApsoParameters
from aos_gcs.swarm.archive.raster import FINE_CELL_M, BoolArray, FloatArray, IntArray, anchor_of, quarters, shares
from aos_gcs.swarm.archive.selection import Views, choose_single_views, choose_views, still_held
from aos_gcs.swarm.archive.target import TargetState

MAX_CANDIDATES = 150
"""Looks among which the views to hold are chosen: those that show most."""
MIN_CONFIDENCE = 0.2
"""Confidence of a look below which it is no candidate; it falls as the target moves."""
SAME_VIEW_M = 0.4
"""Distance in the canopy below which a candidate is the view chosen the step before."""
SURELY_SEEN = 0.5
"""Probability from which a cell belongs to the target's image, whatever the model of the body says."""


@dataclass(frozen=True, slots=True, eq=False)
class Prospect:
    """The archive, applied to the target's expected position at the next step."""

    target_enu_m: FloatArray
    """Shape (2,)."""
    height_m: float
    """Mean height of the swarm: slopes times it are places on one plane."""
    lines: Sightlines
    """Lines from there through the crossings of the k looks."""
    masks: BoolArray
    """Masks of the looks, shape (k, FINE_CELLS)."""
    shown: NDArray[np.float32]
    """Share of each cell that the masks mark, shape (k, CELLS)."""
    confidence: FloatArray
    """Confidence in the masks, below 1 for lines that the target's motion has turned, shape (k,)."""

    @classmethod
    def of(cls, looks: LookArchive, target: TargetState, height_m: float, parameters: AosApsoParameters) -> Prospect:
        """Return the prospect of an archive."""
        target_enu_m = target.position_enu_m + target.next_way_m
        canopy = parameters.canopy
        lines = canopy.lines_through(target_enu_m, looks.lines.crossings_enu_m)
        confidence = kernel(canopy.turned_m(lines, looks.lines), parameters.kernel_m)
        masks = looks.masks_at(anchor_of(target_enu_m), np.array(target.drift_enu_m) + target.next_way_m)
        return cls(target_enu_m, height_m, lines, masks, shares(masks), confidence)

    def best_looks(self, radius_m: float) -> IntArray:
        """Return the looks that may be held, the best first: within the aperture, and showing anything."""
        within = np.linalg.norm(self.lines.slopes, axis=1) * self.height_m <= radius_m
        showing = self.shown.sum(axis=1) * self.confidence
        usable = np.flatnonzero(within & (self.confidence > MIN_CONFIDENCE) & (showing > 0.0))
        return usable[np.argsort(-showing[usable], kind="stable")[:MAX_CANDIDATES]]


def choose_lines(
    looks: LookArchive,
    target: TargetState,
    heights_m: FloatArray,
    held_enu_m: FloatArray | None,
    parameters: AosApsoParameters,
) -> FloatArray:
    """Return the crossings with the canopy of the lines along which to look, at most one per drone, shape (k, 2).

    Args:
        looks: the archive.
        target: target of the looks.
        heights_m: heights of the drones above the focal plane, shape (n,).
        held_enu_m: crossings chosen before, or None.
        parameters: parameters of the strategy.
    """
    # Whole metres, so that the spots stay where they are while heights are measured with noise.
    prospect = Prospect.of(looks, target, round(float(heights_m.mean())), parameters)
    lines, views = _candidates(looks, prospect, parameters)
    held = [] if held_enu_m is None else _still_held(lines, views, held_enu_m)
    if parameters.joint_choice:
        chosen = choose_views(views, len(heights_m), held, parameters.area_exponent, parameters.hysteresis)
    else:
        chosen = choose_single_views(views, len(heights_m), held, parameters.hysteresis)
    return np.asarray(lines.crossings_enu_m[chosen])


def goals_along(
    crossings_enu_m: FloatArray,
    target: TargetState,
    positions_enu_m: FloatArray,
    heights_m: FloatArray,
    canopy: Canopy,
) -> FloatArray:
    """Return where each drone goes to look along one of these lines, shape (n, 2).

    Args:
        crossings_enu_m: crossings of the lines with the canopy, shape (k, 2); drones beyond their number stay.
        target: target to look at.
        positions_enu_m: positions of the drones in the order of their ids, shape (n, 2).
        heights_m: heights of the drones above the focal plane, shape (n,).
        canopy: canopy that the lines pass.
    """
    target_enu_m = target.position_enu_m + target.next_way_m
    slopes = canopy.lines_through(target_enu_m, crossings_enu_m).slopes
    view_goals_m = target_enu_m + slopes * heights_m[:, None, None]
    goals_m = positions_enu_m + target.next_way_m
    goal_of = assigned(goals_m, view_goals_m)
    sent = np.flatnonzero(goal_of >= 0)
    goals_m[sent] = view_goals_m[sent, goal_of[sent]]
    return goals_m


@lru_cache(maxsize=4)
def _spots(radius_m: float, pitch_m: float, height_m: float) -> tuple[FloatArray, NDArray[np.int16]]:
    """Return the slopes of all spots, shape (p, 2), and the cells that voxels are seen on from there."""
    slopes = lattice(radius_m, pitch_m) / height_m
    return slopes, voxel_cells(slopes, height_m, np.zeros(2))


def _candidates(looks: LookArchive, prospect: Prospect, parameters: AosApsoParameters) -> tuple[Sightlines, Views]:
    """Return the lines that drones may look along, and what is expected of them: the best looks, and open spots."""
    canopy, height_m = parameters.canopy, prospect.height_m
    best = prospect.best_looks(parameters.aperture_radius_m)
    known, confidence = prospect.lines[best], prospect.confidence[best, None].astype(np.float32)
    spot_slopes, spot_cells = _spots(parameters.aperture_radius_m, parameters.spot_pitch_m, height_m)
    spots = canopy.lines_of_slopes(prospect.target_enu_m, spot_slopes)
    weights = likeness(canopy.coordinates_m(spots), canopy.coordinates_m(looks.lines), parameters.kernel_m)
    is_open = weights.max(axis=1, initial=0.0) < KNOWN
    spots, weights = spots[is_open], weights[is_open]

    offset_m = prospect.target_enu_m - FINE_CELL_M * anchor_of(prospect.target_enu_m)
    known_cells = voxel_cells(known.slopes, height_m, offset_m)
    body = learnt_body(
        prospect.shown[best] * confidence,
        known_cells,
        prior_height_m=parameters.body_height_m,
        prior_radius_m=parameters.body_radius_m,
    )
    known_footprints = body.footprints(known_cells) | (prospect.shown[best] >= SURELY_SEEN)
    spot_footprints = body.footprints(spot_cells[is_open])
    # Sums over the cells that anything may be seen on, which are a third of the raster.
    cells = np.flatnonzero(known_footprints.any(axis=0) | spot_footprints.any(axis=0))
    known_footprints, spot_footprints = known_footprints[:, cells], spot_footprints[:, cells]
    shown, hope = prospect.shown[:, cells], np.float32(parameters.optimism)
    unsure = (1.0 - confidence) * hope * known_footprints
    expected = expected_masks(weights, shown, spot_footprints, parameters.optimism)

    lines = joined_lines(known, spots)
    places_m = lines.slopes * height_m
    views = Views(
        np.vstack([confidence * shown[best] + unsure, expected]),
        np.vstack([known_footprints, spot_footprints | (expected > SURELY_SEEN)]).astype(np.float32),
        _too_near(places_m, parameters.view_spacing_m),
        np.ascontiguousarray(confidence[:, :, None] * quarters(prospect.masks[best])[:, cells] + unsure[:, :, None]),
    )
    return lines, views


def _too_near(places_m: FloatArray, spacing_m: float) -> BoolArray:
    """Return which places are nearer to each other than a spacing, each with itself, shape (n, n)."""
    places = places_m.astype(np.float32)
    squares = 0.5 * (places**2).sum(axis=1)
    # |a - b|^2 / 2, multiplied out.
    return np.asarray(places @ places.T > squares[:, None] + (squares - np.float32(0.5 * spacing_m**2)))


def _still_held(lines: Sightlines, views: Views, held_enu_m: FloatArray) -> list[int]:
    return still_held(cdist(held_enu_m, lines.crossings_enu_m), views.conflicts, SAME_VIEW_M)
