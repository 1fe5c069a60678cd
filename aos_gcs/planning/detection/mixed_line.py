"""Line on the legs in which low and high altitude layers are mixed, so that all places get about as many views.

A camera shows each place below it in more frames the higher it flies, and shows more places: from 57.5 m it gives about
2.7 times the views that it gives from 35 m. In a line whose layers ascend from one end to the other, one half of each
strip gets far fewer views than the other one, and a probability of detection suffers more where views are few than it
gains where they are many. Mixed layers give the same views to more places.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.planning.legs import ScanLeg, leg_formation
from aos_gcs.swarm.line import line_places

FloatArray = NDArray[np.float64]


def mixed_layers(count: int) -> NDArray[np.int64]:
    """Return which layer each place of a line has, counted from the lowest one, shape (n,), along the line.

    Every third place from either end has one of the lowest layers, the very lowest at the ends, where a high camera
    would look at what lies beyond the strip. Between them are the others, the highest ones nearest to the ends.

    Args:
        count: number of places.
    """
    inwards = sorted(range(count), key=lambda place: min(place, count - 1 - place))
    from_end = [min(place, count - 1 - place) for place in range(count)]
    low = [place for place in inwards if from_end[place] % 3 == 0]
    others = [place for place in inwards if from_end[place] % 3]
    layers = np.empty(count, dtype=np.int64)
    layers[low + others[::-1]] = np.arange(count)
    return layers


def mixed_formation(
    leg: ScanLeg, positions_enu_m: FloatArray, layers_m: Sequence[float], spacing_m: float
) -> FloatArray:
    """Return each vehicle's place in the line at the start of a leg, shape (n, 2), in the order of the rows.

    Layers are mixed, in the order or its mirror image that is nearer, so that a line that is mixed stays as it is on
    the way back. Paths may cross, each in a layer of its own. Where mixing would send somebody farther by more than
    half the line than the order of the vehicles' projections does, that order stays.

    Args:
        leg: leg that begins.
        positions_enu_m: where the vehicles are, shape (n, 2).
        layers_m: height of each one's altitude layer.
        spacing_m: distance of the vehicles in the line.
    """
    near_m = leg_formation(leg, positions_enu_m, spacing_m)
    places_m = line_places(np.array(leg.start_enu_m), np.array(leg.direction_enu), len(positions_enu_m), spacing_m)
    own_layer = np.argsort(np.argsort(layers_m, kind="stable"), kind="stable")
    place_of_layer = np.argsort(mixed_layers(len(positions_enu_m)))
    mixed_m = min(
        (places_m[place_of_layer][own_layer], places_m[::-1][place_of_layer][own_layer]),
        key=lambda formed_m: float(((formed_m - positions_enu_m) ** 2).sum()),
    )
    half_line_m = spacing_m * (len(positions_enu_m) - 1) / 2.0
    is_far = _farthest_m(mixed_m, positions_enu_m) > _farthest_m(near_m, positions_enu_m) + half_line_m
    return near_m if is_far else mixed_m


def _farthest_m(places_m: FloatArray, positions_m: FloatArray) -> float:
    return float(np.hypot(*(places_m - positions_m).T).max(initial=0.0))
