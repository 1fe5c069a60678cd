"""Order of the altitude layers by which vehicles come down at home without meeting those still on their way.

On its own return each autopilot flies home in its layer and descends at its launch point, through the layers below. A
vehicle whose path home leads past another one's launch point must be in the higher layer of both: it passes above, and
the other one descends below it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from aos_gcs.airspace.polygon import signed_depth_m

FloatArray = NDArray[np.float64]


def passes(area_enu_m: Sequence[Sequence[float]], homes_m: FloatArray, clearance_m: float) -> NDArray[np.bool_]:
    """Return which vehicle's ways home lead past which other's launch point, shape (n, n): row past column.

    Args:
        area_enu_m: search area, from all of which they return; shape (m, 2), metres.
        homes_m: launch points, shape (n, 2), metres.
        clearance_m: distance from a way below which it leads past a launch point.
    """
    area_m = np.array(area_enu_m, dtype=np.float64)
    found = np.zeros((len(homes_m), len(homes_m)), dtype=np.bool_)
    for row, home_m in enumerate(homes_m):
        points_m = np.vstack([area_m, home_m])
        ways_m = points_m[ConvexHull(points_m).vertices]
        found[row] = [signed_depth_m(other_m, ways_m) > -clearance_m for other_m in homes_m]
    np.fill_diagonal(found, False)
    return found


def order_of_layers(is_past: NDArray[np.bool_]) -> list[int]:
    """Return the rows of the vehicles from the lowest layer to the highest; where nothing else decides, as they come.

    Args:
        is_past: whose ways home lead past whose launch points, shape (n, n), as :func:`passes` returns it.
    """
    left, order = list(range(len(is_past))), []
    while left:
        # The lowest of those left is one that passes no launch point of another, or else as few as possible.
        lowest = min(left, key=lambda row: int(is_past[row, left].sum()))
        left.remove(lowest)
        order.append(lowest)
    return order


def staggered(is_past: NDArray[np.bool_], layers_m: Sequence[float]) -> list[float]:
    """Return the layer of each vehicle, in the order of the rows, of ``layers_m``, which ascend."""
    own_m = np.empty(len(layers_m))
    own_m[order_of_layers(is_past)] = layers_m
    return [float(layer_m) for layer_m in own_m]


def meetings(is_past: NDArray[np.bool_], layers_m: Sequence[float]) -> list[tuple[int, int]]:
    """Return the pairs of rows of which the first flies home below the second one's layer and past its launch point."""
    higher = np.array(layers_m)[None, :] > np.array(layers_m)[:, None]
    return [(int(row), int(column)) for row, column in np.argwhere(is_past & higher)]
