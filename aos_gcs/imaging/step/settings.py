"""Settings of the analysis of a step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.focal_plane import DEFAULT_MAX_CELLS
from aos_gcs.imaging.model import AnomalySource, Detector, IntervalCapture, LeaderCriterion, SurfaceKind

MAX_RATE_HZ: Final = 10.0
"""Greatest number of frames per second of one camera."""

DEPTH_BELOW_M: Final = 50.0
"""Greatest depth of a plane that somebody chooses below the mission's own: deeper ones are a slip of the pen."""


@dataclass(frozen=True, slots=True)
class ImagingSettings:
    """Settings of the analysis of a step's frames (spec, sections 1 and 2).

    Raises:
        ConfigurationError: if a value lies outside its range; the text names it.
    """

    plane_height_m: float = 0.0
    """Height of the horizontal focal plane above the surface that it follows."""
    surface: SurfaceKind = SurfaceKind.TERRAIN
    detector: Detector | None = None
    """None: chosen by the bands of the frames, see :meth:`detector_of`."""
    anomaly_source: AnomalySource = AnomalySource.MASKS
    rx_quantile: float = 0.9998
    """Quantile of an image's scores above which pixels are marked, for every detector."""
    rx_min_score: float | None = None
    """Score that a marked pixel must also exceed, for every detector; None: the detector's own for the bands."""
    minimum_count: int = 1
    """Frames that must mark a cell of the integral."""
    gap_cells: int = 1
    """Unmarked cells that may lie between two cells of one blob."""
    leader_criterion: LeaderCriterion = LeaderCriterion.CONTRIBUTION
    resolution_m: float | None = None
    """Edge of a cell on the focal plane; None: the finest ground sampling distance of the frames."""
    max_cells: int = DEFAULT_MAX_CELLS
    """Upper bound of the raster's size; cells become coarser to keep it."""
    agreeing_frames: int | None = None
    """Frames that must mark a place of a blob, where as many see it, each within half the width of a body; None: 2 for
    frames of one band, which are restless, otherwise 1."""
    history_frames: int = 10
    """Largest number of views from earlier steps in the integral of anomalies; 0: none."""
    rate_hz: float = 2.0
    """Frames per second of each camera while its vehicle flies along a leg; slower cameras slow the search down."""
    interval_capture: IntervalCapture = IntervalCapture.AUTO

    def __post_init__(self) -> None:
        if not math.isfinite(self.plane_height_m):
            raise ConfigurationError(f"plane_height_m must be finite, got {self.plane_height_m}.")
        if not 0.0 <= self.rx_quantile < 1.0:
            raise ConfigurationError(f"rx_quantile must lie within [0, 1), got {self.rx_quantile}.")
        if self.rx_min_score is not None and not self.rx_min_score >= 0.0:
            raise ConfigurationError(f"rx_min_score must not be negative, got {self.rx_min_score}.")
        if self.minimum_count < 1:
            raise ConfigurationError(f"minimum_count must be at least 1, got {self.minimum_count}.")
        if self.agreeing_frames is not None and self.agreeing_frames < 1:
            raise ConfigurationError(f"agreeing_frames must be at least 1, got {self.agreeing_frames}.")
        if self.gap_cells < 0:
            raise ConfigurationError(f"gap_cells must not be negative, got {self.gap_cells}.")
        if self.resolution_m is not None and not self.resolution_m > 0.0:
            raise ConfigurationError(f"resolution_m must be positive, got {self.resolution_m}.")
        if self.max_cells < 100:
            raise ConfigurationError(f"max_cells must be at least 100, got {self.max_cells}.")
        if not 0.0 < self.rate_hz <= MAX_RATE_HZ:
            raise ConfigurationError(f"rate_hz must be above 0 and at most {MAX_RATE_HZ:g}, got {self.rate_hz}.")
        if self.history_frames < 0:
            raise ConfigurationError(f"history_frames must not be negative, got {self.history_frames}.")

    def detector_of(self, bands: tuple[str, ...]) -> Detector:
        """Return the detector of frames: of one band, a pixel is judged by its surroundings, not by the whole frame."""
        if self.detector is not None:
            return self.detector
        return Detector.LOCAL_RX if len(bands) == 1 else Detector.RX

    def agreement_of(self, bands: tuple[str, ...]) -> int:
        """Return how many frames of some bands must agree on a blob."""
        if self.agreeing_frames is not None:
            return self.agreeing_frames
        return 2 if len(bands) == 1 else 1
