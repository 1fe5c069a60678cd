"""Pictures of a forest floor without a forest."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from aos_gcs.mission.model.steps import PictureKind

_SIZE_PX = 256


@lru_cache(maxsize=512)
def paint(
    kind: PictureKind,
    seed: int,
    bounds: tuple[float, float, float, float],
    person_enu_m: tuple[float, float, float],
    visibility_m2: float,
) -> bytes:
    """Return a PNG with blurred foliage and a person that shows the better the higher the visibility is."""
    size = _SIZE_PX
    rng = np.random.default_rng(seed)
    foliage = cv2.GaussianBlur(rng.random((size, size), np.float32), (0, 0), 5)
    foliage = (foliage - foliage.min()) / float(np.ptp(foliage))
    row, column = np.mgrid[0:size, 0:size].astype(np.float32)
    west_m, _, east_m, north_m = bounds
    scale_px_per_m = size / (east_m - west_m)
    east_px, north_px = (person_enu_m[0] - west_m) * scale_px_per_m, (north_m - person_enu_m[1]) * scale_px_per_m
    person = np.exp(-((column - east_px) ** 2 + (row - north_px) ** 2) / (2 * 5.0**2)) * min(1.0, visibility_m2 + 0.1)
    colours = {
        PictureKind.INTEGRAL: np.stack([30 + 50 * foliage, 60 + 90 * foliage, 40 + 60 * foliage + 190 * person], -1),
        PictureKind.THERMAL: np.repeat((40 + 60 * foliage + 155 * person)[..., None], 3, axis=-1),
        PictureKind.ANOMALY: np.stack([0 * person, 180 * person, 255 * person], -1),
        PictureKind.COVERAGE: np.stack([60 + 0 * person, 80 + 120 * foliage, 140 + 0 * person], -1),
        PictureKind.VIEWS: np.stack([60 + 0 * person, 140 + 80 * foliage, 130 + 0 * person], -1),
        PictureKind.DETECTION: np.stack([180 + 60 * foliage, 200 + 0 * person, 40 + 0 * person], -1),
        PictureKind.FLOOR: np.stack([50 + 40 * foliage, 70 + 50 * foliage, 90 + 60 * foliage], -1),
        PictureKind.PRIOR: np.stack([200 + 0 * person, 60 + 80 * foliage, 120 + 0 * person], -1),
        PictureKind.VISIBILITY: np.stack([60 + 160 * foliage, 80 + 120 * foliage, 60 + 0 * person], -1),
    }[kind]
    covered = np.hypot(column - size / 2, row - size / 2) < 0.48 * size
    visible = covered & (person > 0.15) if kind is PictureKind.ANOMALY else covered
    rgba = np.dstack([colours, 255.0 * visible]).clip(0, 255).astype(np.uint8)
    done, data = cv2.imencode(".png", rgba)
    if not done:
        raise RuntimeError("the picture could not be encoded")
    return data.tobytes()
