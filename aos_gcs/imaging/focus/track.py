"""Track of the focal height over a mission: smoothed, robust against single wrong results, set by the operator."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.focus.autofocus import FocusResult

GATE_SIGMAS = 3.0
"""Distance beyond which a result is doubted, in standard deviations."""

MAX_DOUBTED = 2
"""Results in a row that may be doubted; the next one is accepted."""

MIN_SIGMA_M = 0.1
"""Smallest standard deviation of a single result: errors of poses are common to all steps."""

WINDOW_SIGMAS = 4.0
MIN_WINDOW_M = 2.0
"""Smallest range that the next step looks at, to each side of the present height."""


@dataclass(frozen=True, slots=True)
class FocusTrack:
    """Estimate of the focal height; a new one for every step."""

    height_m: float
    sigma_m: float
    """Standard deviation; infinite while the height is a mere guess."""
    override_m: float | None = None
    """The operator's height, used while it is set; the estimate continues meanwhile."""
    doubted: int = 0
    """Results in a row that lay too far off to be taken."""
    missed: int = 0
    """Steps in a row that found nothing."""

    def moved(self, up_m: float) -> FocusTrack:
        """Return the track of heights that count from elsewhere; the operator's stays."""
        return replace(self, height_m=self.height_m + up_m)


def update_focus(track: FocusTrack, result: FocusResult, drift_m: float = 0.2) -> FocusTrack:
    """Return the track after one more step (a Kalman filter of a random walk, with a gate).

    Args:
        track: focal height before the step.
        result: result of the step; one that was not found only increases the uncertainty.
        drift_m: standard deviation of how far the terrain below the region rises or falls from step to step.
    """
    variance_m2 = track.sigma_m**2 + drift_m**2
    if not result.found:
        return replace(track, sigma_m=math.sqrt(variance_m2), missed=track.missed + 1)
    track = replace(track, missed=0)
    noise_m2 = max(result.sigma_m, MIN_SIGMA_M) ** 2
    innovation_m = result.height_m - track.height_m
    is_far = innovation_m**2 > GATE_SIGMAS**2 * (variance_m2 + noise_m2)
    if is_far and track.doubted < MAX_DOUBTED:
        return replace(track, sigma_m=math.sqrt(variance_m2), doubted=track.doubted + 1)
    if is_far or math.isinf(variance_m2):
        return replace(track, height_m=result.height_m, sigma_m=math.sqrt(noise_m2), doubted=0)
    gain = variance_m2 / (variance_m2 + noise_m2)
    return replace(
        track, height_m=track.height_m + gain * innovation_m, sigma_m=math.sqrt((1.0 - gain) * variance_m2), doubted=0
    )


def overridden(track: FocusTrack, height_m: float | None) -> FocusTrack:
    """Return the track with the operator's height; None gives it back to the estimate.

    Raises:
        ConfigurationError: if the height is not finite.
    """
    if height_m is not None and not math.isfinite(height_m):
        raise ConfigurationError(f"The focal height must be a finite number of metres, got {height_m}.")
    return replace(track, override_m=height_m)


def search_range_m(track: FocusTrack, low_m: float, high_m: float) -> tuple[float, float]:
    """Return the range of heights that the next step should look at: near a sure height, all of low to high else."""
    reach_m = max(WINDOW_SIGMAS * track.sigma_m, MIN_WINDOW_M)
    window_m = max(low_m, track.height_m - reach_m), min(high_m, track.height_m + reach_m)
    # A doubted or missing result says that the truth may lie outside of the window.
    is_lost = track.doubted > 0 or track.missed > 0 or window_m[0] >= window_m[1]
    return (low_m, high_m) if is_lost else window_m
