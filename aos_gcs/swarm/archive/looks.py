"""The archive: what frames have shown of the target, and along which lines of sight.

Drones fly in different layers and a target may walk, so that a frame is remembered by its line of sight rather than by
the drone's position: the *slope* (horizontal distance over height, seen from the target) and the *crossing*, the point
where the line passes the middle of the canopy. Two lines that are close there and nearly parallel pass the same leaves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from aos_gcs.swarm.archive.raster import (
    FINE_CELL_M,
    FINE_CELLS,
    BoolArray,
    FloatArray,
    IntArray,
    packed,
    shifted,
    unpacked,
)

ScalarT = TypeVar("ScalarT", bound=np.generic)

MAX_LOOKS = 600
"""The oldest ones are forgotten first."""
SAME_LINE_M = 0.15
"""Distance within the canopy below which a look replaces an older one: it shows the same."""


@dataclass(frozen=True, slots=True)
class Canopy:
    """Layer of leaves that hide the target, above the focal plane."""

    height_m: float
    """Height of the middle of the layer."""
    half_depth_m: float
    """Distance from the middle of the layer to its edges."""

    def lines_of_slopes(self, target_enu_m: FloatArray, slopes: FloatArray) -> Sightlines:
        """Return the lines from the target under slopes of shape (n, 2)."""
        return Sightlines(slopes, target_enu_m + slopes * self.height_m)

    def lines_through(self, target_enu_m: FloatArray, crossings_enu_m: FloatArray) -> Sightlines:
        """Return the lines from the target through crossings of shape (n, 2)."""
        return Sightlines((crossings_enu_m - target_enu_m) / self.height_m, crossings_enu_m)

    def distances_m(self, first: Sightlines, second: Sightlines) -> FloatArray:
        """Return how far apart lines of sight are within the canopy, shape (n, k)."""
        return np.asarray(cdist(self.coordinates_m(first), self.coordinates_m(second)))

    def turned_m(self, first: Sightlines, second: Sightlines) -> FloatArray:
        """Return how far apart lines through the same crossings are at the canopy's edges, pair by pair, shape (n,)."""
        return np.asarray(self.half_depth_m * np.linalg.norm(first.slopes - second.slopes, axis=1))

    def coordinates_m(self, lines: Sightlines) -> FloatArray:
        """Return lines as points whose distance is that of the lines, shape (n, 4)."""
        return np.hstack([lines.crossings_enu_m, self.half_depth_m * lines.slopes])


@dataclass(frozen=True, slots=True, eq=False)
class Sightlines:
    """Lines of sight."""

    slopes: NDArray[np.float64]
    """East and north, shape (n, 2)."""
    crossings_enu_m: NDArray[np.float64]
    """Shape (n, 2)."""

    def __len__(self) -> int:
        return len(self.slopes)

    def __getitem__(self, rows: BoolArray | IntArray | slice) -> Sightlines:
        """Return some of them."""
        return Sightlines(self.slopes[rows], self.crossings_enu_m[rows])


def joined_lines(first: Sightlines, second: Sightlines) -> Sightlines:
    """Return the lines of both, in that order."""
    return Sightlines(
        np.concatenate([first.slopes, second.slopes]),
        np.concatenate([first.crossings_enu_m, second.crossings_enu_m]),
    )


@dataclass(frozen=True, slots=True, eq=False)
class LookArchive:
    """The archive of k looks, the oldest first; plain data."""

    lines: Sightlines
    anchors: NDArray[np.int64]
    """Centres of the masks' rasters, shape (k, 2)."""
    drifts_enu_m: NDArray[np.float64]
    """Displacement of the target at the time of each look, shape (k, 2)."""
    packed_masks: str
    """See :func:`aos_gcs.swarm.archive.raster.packed`."""

    def __len__(self) -> int:
        return len(self.lines)

    def masks_at(self, anchor: IntArray, drift_enu_m: FloatArray) -> BoolArray:
        """Return the masks on the raster at an anchor, moved along with the target, shape (k, FINE_CELLS)."""
        moved = np.rint((drift_enu_m - self.drifts_enu_m) / FINE_CELL_M).astype(np.int64)
        return shifted(unpacked(self.packed_masks, len(self)), self.anchors + moved - anchor)


def no_looks() -> LookArchive:
    """Return an empty archive."""
    none = np.zeros((0, 2))
    return LookArchive(
        Sightlines(none, none), none.astype(np.int64), none, packed(np.zeros((0, FINE_CELLS), dtype=np.bool_))
    )


def with_looks(
    looks: LookArchive,
    canopy: Canopy,
    lines: Sightlines,
    *,
    masks: BoolArray,
    anchor: IntArray,
    drift_enu_m: FloatArray,
    at_most: int = MAX_LOOKS,
) -> LookArchive:
    """Return the archive with the looks of one step, which replace older ones along the same lines.

    Args:
        looks: the archive before.
        canopy: canopy that the lines pass.
        lines: n of them.
        masks: masks seen along them, shape (n, FINE_CELLS).
        anchor: centre of the masks' raster, shape (2,).
        drift_enu_m: displacement of the target, shape (2,).
        at_most: looks to keep; the oldest ones are forgotten first.
    """
    if len(lines) == 0:
        return looks
    kept = (canopy.distances_m(looks.lines, lines) > SAME_LINE_M).all(axis=1)

    def joined(old: NDArray[ScalarT], new: NDArray[ScalarT]) -> NDArray[ScalarT]:
        return np.concatenate([old[kept], new])[-at_most:]

    old_masks = unpacked(looks.packed_masks, len(looks))
    return LookArchive(
        Sightlines(
            joined(looks.lines.slopes, lines.slopes),
            joined(looks.lines.crossings_enu_m, lines.crossings_enu_m),
        ),
        joined(looks.anchors, np.tile(anchor, (len(lines), 1))),
        joined(looks.drifts_enu_m, np.tile(drift_enu_m, (len(lines), 1))),
        packed(joined(old_masks, masks)),
    )
