"""Spots that stand out in frames without temperatures, judged by the noise of their surroundings.

Grey levels of a thermal camera that tells no temperatures have no scale: its gain follows the scene. What remains is
how far a pixel stands out of its surroundings, in standard deviations of these, and whether frames from other places
see it at the same place on the ground. Leaves and sunlit branches stand out as much in single frames, but lie
elsewhere on the ground in each of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.detection.local_rx import GUARD_PX, local_rx_scores
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.persons.evidence import Evidence, looking_at, vantage_points
from aos_gcs.imaging.persons.warm_bodies import WarmView, view_above

MIN_CONTRAST = 4.0
"""Contrast of a pixel that counts, in standard deviations of its surroundings: a Gaussian background exceeds it in 8
pixels of 512 x 512."""
SURROUNDINGS_PX = 83
"""Edge of the window that a pixel is compared with, without the inner ``GUARD_PX``: with less a second person a body's
length away would hide the first."""
CORE_M = 1.0
"""Radius of a spot: half the length of a lying person."""
RING_M = (2.0, 5.0)
"""Inner and outer radius of the ring that a spot is compared with."""


def can_stand_out(frame: Frame) -> bool:
    """Tell whether a frame has one band of grey levels that may be those of a thermal camera."""
    return _band(frame) is not None


def relative_view(frame: Frame, plane_height_m: float = 0.0) -> WarmView:
    """Return the pixels of a frame that stand out, possibly none; their contrasts are in standard deviations.

    A band ``thermal`` counts where it is warmer than its surroundings. Nobody has said what the band ``grey`` shows:
    there darker pixels count as well.

    Args:
        frame: frame with a band ``thermal`` or ``grey`` in grey levels of any scale.
        plane_height_m: ENU height of the focal plane.

    Raises:
        ValueError: if the frame has neither band.
    """
    band = _band(frame)
    if band is None:
        raise ValueError(f"spots need a band 'thermal' or 'grey', but the frame has {', '.join(frame.bands)}")
    plane = frame.image[..., band : band + 1].astype(np.float32)
    contrast = np.sqrt(local_rx_scores(plane, GUARD_PX, SURROUNDINGS_PX))
    if frame.bands[band] == "thermal":
        contrast[plane[..., 0] < cv2.blur(plane[..., 0], (SURROUNDINGS_PX, SURROUNDINGS_PX))] = 0.0
    return view_above(frame, contrast, MIN_CONTRAST, plane_height_m, radiometric=False)


def spot_at(
    place_enu_m: NDArray[np.float64], views: Sequence[WarmView], plane_height_m: float
) -> tuple[Evidence, tuple[WarmView, ...]]:
    """Return the evidence of what stands out at a place, shape (2,), and the parts of the views that show it.

    Args:
        place_enu_m: place on the focal plane.
        views: views of one step or several, without temperatures.
        plane_height_m: ENU height of the focal plane.
    """
    away_m = [np.linalg.norm(view.points_enu_m - place_enu_m, axis=1) for view in views]
    spot = tuple(
        view.part(near)
        for view, distances_m in zip(views, away_m, strict=True)
        if (near := distances_m <= CORE_M).any()
    )
    contrast = np.concatenate([view.contrast_k for view in spot]) if spot else np.zeros(1)
    median, peak = np.quantile(contrast, [0.5, 0.99])
    inner_m, outer_m = RING_M
    around = sum(int(np.count_nonzero((inner_m < away) & (away <= outer_m))) for away in away_m)
    expected = max(around, 1) * CORE_M**2 / (outer_m**2 - inner_m**2)
    inside = sum(len(view.points_enu_m) for view in spot)
    looking = looking_at(place_enu_m, views, plane_height_m)
    return Evidence(
        views=len(spot),
        vehicles=vantage_points(spot, views),
        area_m2=max((view.area_m2 for view in spot), default=0.0),
        extent_m=max((float(np.ptp(view.points_enu_m, axis=0).max()) for view in spot), default=0.0),
        contrast_median_k=float(median) if spot else math.nan,
        contrast_peak_k=float(peak) if spot else math.nan,
        frames=len(looking),
        swarm=vantage_points(looking, views),
        radiometric=False,
        concentration=inside / expected,
    ), spot


def _band(frame: Frame) -> int | None:
    for name in ("thermal", "grey"):
        if name in frame.bands:
            return frame.bands.index(name)
    return None
