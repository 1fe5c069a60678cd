"""The anomaly detectors by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.imaging.detection.local_rx import local_rx_scores
from aos_gcs.imaging.detection.rx import anomaly_mask, default_min_score, rx_scores
from aos_gcs.imaging.detection.thermal_anomaly import warm_scores
from aos_gcs.imaging.model import Detector, Pixels


@dataclass(frozen=True, slots=True)
class DetectorMethod:
    """Scores of a detector, and the smallest score that counts."""

    scores: Callable[[Pixels, tuple[str, ...]], NDArray[np.float32]]
    """Scores of an image, shape (H, W, C), with its bands; they have shape (H, W), NaN is never marked."""
    min_score: Callable[[int], float]
    """Score that background practically never exceeds, for a number of bands."""


def detect(
    image: Pixels,
    bands: tuple[str, ...],
    detector: Detector = Detector.RX,
    quantile: float = 0.9998,
    min_score: float | None = None,
    *,
    weights: NDArray[np.float32] | None = None,
) -> NDArray[np.uint8]:
    """Return a mask of an image, shape (H, W), 1 where it is anomalous.

    Args:
        image: shape (H, W, C).
        bands: one name per channel.
        detector: see :class:`~aos_gcs.imaging.model.Detector`.
        quantile: see :func:`~aos_gcs.imaging.detection.rx.anomaly_mask`.
        min_score: the same; None: the detector's own.
        weights: factors of the scores, shape (H, W), where the background's variance is known to differ.

    Raises:
        ImagingError: if the image lacks a band that the detector needs.
    """
    method = DETECTORS[detector]
    limit = method.min_score(len(bands)) if min_score is None else min_score
    scores = method.scores(image, bands)
    return anomaly_mask(scores if weights is None else scores * weights, quantile, limit)


def thermal_band(image: Pixels, bands: tuple[str, ...]) -> Pixels:
    """Return the thermal band of an image, shape (H, W, C), as a view of shape (H, W).

    Raises:
        ImagingError: if there is none.
    """
    if "thermal" not in bands:
        raise ImagingError(
            f"The thermal detector needs a thermal band, but the frames have {', '.join(bands)}: choose another "
            "imaging.detector."
        )
    return np.asarray(image[:, :, bands.index("thermal")])


DETECTORS: Mapping[Detector, DetectorMethod] = MappingProxyType(
    {
        Detector.RX: DetectorMethod(lambda image, _: rx_scores(image), default_min_score),
        Detector.LOCAL_RX: DetectorMethod(lambda image, _: local_rx_scores(image), default_min_score),
        Detector.THERMAL: DetectorMethod(
            lambda image, bands: warm_scores(thermal_band(image, bands)), lambda _: default_min_score(1)
        ),
    }
)
