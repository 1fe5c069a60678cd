"""Autofocus during a search: the region to focus on in each step, and the update of the focal height."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from aos_gcs.errors import ImagingError
from aos_gcs.imaging.focus.autofocus import find_focus
from aos_gcs.imaging.focus.measure import FocusSignal
from aos_gcs.imaging.focus.region import GroundRegion
from aos_gcs.imaging.focus.track import FocusTrack, search_range_m, update_focus
from aos_gcs.imaging.model import Frame

TARGET_HALF_WIDTH_M = 5.0
"""Half the edge of the region about a target: wide enough for its images to part when the plane is some metres off."""

GROUND_HALF_WIDTH_M = 10.0
"""Half the edge of the region below the swarm's centre."""


def follow_focus(
    track: FocusTrack,
    frames: Sequence[Frame],
    target_enu_m: Sequence[float] | None,
    low_m: float,
    high_m: float,
) -> FocusTrack:
    """Return the track after autofocus has looked at one step's frames.

    With a target in view, the height is looked for at which the frames agree best on what the detector marks there:
    that is where its visibility is greatest. Without one, the texture below the swarm decides; a dense forest has
    no height that stands out, and the height stays.

    Blocks for tenths of a second with ten frames: call it by a ``Worker``.

    Args:
        track: focal height before the step.
        frames: frames of the step, all with the same bands.
        target_enu_m: position of the target, if one is in view.
        low_m: smallest height; keep it near the ground, as crowns have the most texture.
        high_m: greatest height, below the cameras.
    """
    if target_enu_m is None:
        east_m, north_m = np.mean([frame.pose.position_enu_m[:2] for frame in frames], axis=0)
        half_m, signal = GROUND_HALF_WIDTH_M, FocusSignal.TEXTURE
    else:
        east_m, north_m = target_enu_m[:2]
        half_m, signal = TARGET_HALF_WIDTH_M, FocusSignal.ANOMALY
    region = GroundRegion(east_m - half_m, north_m - half_m, east_m + half_m, north_m + half_m)
    try:
        result = find_focus(frames, region, *search_range_m(track, low_m, high_m), signal=signal)
    except ImagingError:
        # Fewer than two cameras look at the region: as good as a step that found nothing.
        return replace(track, missed=track.missed + 1)
    return update_focus(track, result)
