"""Pictures of a forest floor without a forest."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.mission.model.steps import PictureKind

_SIZE_PX = 128


# Red, green and blue without anything, what is added to them by foliage, and by a person.
_COLOURS = {
    PictureKind.INTEGRAL: ((30, 60, 40), (50, 90, 60), (0, 0, 190)),
    PictureKind.THERMAL: ((40, 40, 40), (60, 60, 60), (155, 155, 155)),
    PictureKind.ANOMALY: ((0, 0, 0), (0, 0, 0), (0, 180, 255)),
    PictureKind.COVERAGE: ((60, 80, 140), (0, 120, 0), (0, 0, 0)),
    PictureKind.VIEWS: ((60, 140, 130), (0, 80, 0), (0, 0, 0)),
    PictureKind.DETECTION: ((180, 200, 40), (60, 0, 0), (0, 0, 0)),
    PictureKind.FLOOR: ((50, 70, 90), (40, 50, 60), (0, 0, 0)),
    PictureKind.PRIOR: ((200, 60, 120), (0, 80, 0), (0, 0, 0)),
    PictureKind.VISIBILITY: ((60, 80, 60), (160, 120, 0), (0, 0, 0)),
}


@lru_cache(maxsize=512)
def paint(
    kind: PictureKind,
    seed: int,
    bounds: tuple[float, float, float, float],
    person_enu_m: tuple[float, float, float],
    visibility_m2: float,
) -> bytes:
    """Return a PNG with blurred foliage and a person that shows the better the higher the visibility is."""
    foliage, person = _foliage(seed), _person(bounds, person_enu_m, visibility_m2)
    plain, of_foliage, of_person = np.array(_COLOURS[kind], np.float32)
    rgba = np.empty((_SIZE_PX, _SIZE_PX, 4), np.uint8)
    colours = plain + of_foliage * foliage[..., np.newaxis] + of_person * person[..., np.newaxis]
    rgba[..., :3] = colours.clip(0.0, 255.0)
    row, column = np.ogrid[:_SIZE_PX, :_SIZE_PX]
    covered = np.hypot(column - _SIZE_PX / 2, row - _SIZE_PX / 2) < 0.48 * _SIZE_PX
    visible = covered & (person > 0.15) if kind is PictureKind.ANOMALY else covered
    rgba[..., 3] = 255 * visible
    done, data = cv2.imencode(".png", rgba, [cv2.IMWRITE_PNG_COMPRESSION, 1])
    if not done:
        raise RuntimeError("the picture could not be encoded")
    return data.tobytes()


@lru_cache(maxsize=16)
def _foliage(seed: int) -> NDArray[np.float32]:
    rng = np.random.default_rng(seed)
    foliage = cv2.GaussianBlur(rng.random((_SIZE_PX, _SIZE_PX), np.float32), (0, 0), 2.5)
    return np.asarray((foliage - foliage.min()) / np.ptp(foliage), np.float32)


@lru_cache(maxsize=16)
def _person(
    bounds: tuple[float, float, float, float], person_enu_m: tuple[float, float, float], visibility_m2: float
) -> NDArray[np.float32]:
    west_m, _, east_m, north_m = bounds
    scale_px_per_m = _SIZE_PX / (east_m - west_m)
    east_px, north_px = (person_enu_m[0] - west_m) * scale_px_per_m, (north_m - person_enu_m[1]) * scale_px_per_m
    row, column = np.ogrid[:_SIZE_PX, :_SIZE_PX]
    spot = np.exp(-((column - east_px) ** 2 + (row - north_px) ** 2) / (2 * 2.5**2))
    return np.asarray(spot * min(1.0, visibility_m2 + 0.1), np.float32)
