"""Positions that a receiver has told by mistake: no aircraft gets there in time."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import SEA_LEVEL
from aos_gcs.surveys.video.subtitles import CueTelemetry

MAX_SPEED_MPS = 50.0
"""Speed that no aircraft with such a camera reaches."""
_INTERVAL_S = 1.5
"""Longest time between two positions of a receiver: cues come more often, and repeat them."""


def without_jumps(samples: Sequence[CueTelemetry]) -> list[CueTelemetry]:
    """Return samples, in the order of their times, without those that the longest unbroken part does not lead to.

    Args:
        samples: at least one.
    """
    middle = samples[len(samples) // 2]
    frame = LocalFrame(GeodeticPosition(middle.latitude_deg, middle.longitude_deg, SEA_LEVEL))
    places_m = np.array([frame.to_enu(GeodeticPosition(s.latitude_deg, s.longitude_deg, SEA_LEVEL)) for s in samples])
    times_s = np.array([sample.time_s for sample in samples])
    is_jump = _is_beyond(np.diff(places_m, axis=0), np.diff(times_s))
    edges = [0, *(np.flatnonzero(is_jump) + 1).tolist(), len(samples)]
    parts = [range(start, end) for start, end in pairwise(edges)]
    longest = max(range(len(parts)), key=lambda number: len(parts[number]))
    kept = list(parts[longest])
    for part in parts[longest + 1 :]:
        if not _is_beyond(places_m[part[0]] - places_m[kept[-1]], times_s[part[0]] - times_s[kept[-1]]):
            kept += part
    for part in reversed(parts[:longest]):
        if not _is_beyond(places_m[part[-1]] - places_m[kept[0]], times_s[kept[0]] - times_s[part[-1]]):
            kept = [*part, *kept]
    return [samples[index] for index in kept]


def _is_beyond(way_m: NDArray[np.float64], seconds: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell whether ways, shape (..., 3), are too long for times of shape (...)."""
    return np.asarray(np.linalg.norm(way_m, axis=-1) > MAX_SPEED_MPS * (seconds + _INTERVAL_S))
