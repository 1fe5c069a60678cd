"""From sightings to a target estimate, and the decision that a target has been found."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.model import StepAnalysis
from aos_gcs.mission.model import TargetEstimate
from aos_gcs.mission.settings import DetectionSettings

_WINDOW = 12
"""Sightings kept for the estimate: enough to average the swarm's geometry out, few enough to follow a slow walker."""


@dataclass(frozen=True, slots=True)
class _Sighting:
    position_enu_m: NDArray[np.float64]
    area_m2: float
    agreeing: bool
    """Enough frames mark the same cell."""


class TargetTracker:
    """Keeps the latest sightings of one target.

    ``observe`` once per step. A jump farther than the agreement radius from the estimate starts a new one: the blob
    seen now is then another object than the one seen before.
    """

    def __init__(self, settings: DetectionSettings) -> None:
        self._settings = settings
        self._sightings: deque[_Sighting] = deque(maxlen=_WINDOW)
        self.steps_in_view = 0
        self.steps_out_of_view = 0

    def observe(self, analysis: StepAnalysis) -> bool:
        """Take a step's analysis in and return whether a target is in view."""
        blob = analysis.blob
        if blob is None or blob.area_m2 < self._settings.threshold_m2:
            self.steps_in_view = 0
            self.steps_out_of_view += 1
            return False
        self.steps_out_of_view = 0
        self.steps_in_view += 1
        position_enu_m = np.array(blob.centroid_enu_m)
        self._forget_if_elsewhere(position_enu_m)
        self._sightings.append(
            _Sighting(position_enu_m, blob.area_m2, agreeing=blob.max_count >= self._settings.found_min_count)
        )
        return True

    def _forget_if_elsewhere(self, position_enu_m: NDArray[np.float64]) -> None:
        estimate = self.estimate()
        if estimate is None:
            return
        distance_m = float(np.linalg.norm(position_enu_m - np.array(estimate.position_enu_m)))
        if distance_m > 2 * self._settings.found_radius_m:
            self._sightings.clear()
            self.steps_in_view = 1

    def estimate(self) -> TargetEstimate | None:
        """Return the mean of the sightings weighted by their areas, with the standard error of that mean."""
        if not self._sightings:
            return None
        positions_enu_m = np.array([sighting.position_enu_m for sighting in self._sightings])
        weights = np.array([sighting.area_m2 for sighting in self._sightings])
        weights /= weights.sum()
        mean_enu_m = weights @ positions_enu_m
        sigma_m = None
        if len(positions_enu_m) >= 3:
            variance_m2 = weights @ np.sum((positions_enu_m - mean_enu_m)[:, :2] ** 2, axis=1) / 2
            sigma_m = float(np.sqrt(variance_m2 * np.sum(weights**2)))
        east_m, north_m, up_m = (float(value) for value in mean_enu_m)
        return TargetEstimate((east_m, north_m, up_m), sigma_m, len(positions_enu_m))

    def is_found(self) -> bool:
        """Return whether the latest sightings agree on one place, each confirmed by enough frames."""
        latest = list(self._sightings)[-self._settings.found_steps :]
        if self.steps_in_view < self._settings.found_steps or len(latest) < self._settings.found_steps:
            return False
        if not all(sighting.agreeing for sighting in latest):
            return False
        positions_enu_m = np.array([sighting.position_enu_m for sighting in latest])
        spread_m = np.linalg.norm(positions_enu_m - positions_enu_m.mean(axis=0), axis=1).max()
        return bool(spread_m <= self._settings.found_radius_m)
