"""The searched ground in shades of grey, from the rasters that the dashboard shows in colour."""

from __future__ import annotations

from functools import cache
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.handover.model import Raster
from aos_gcs.mission.model.steps import PictureKind

LEGENDS: Final = {
    PictureKind.DETECTION: "grey: searched, the darker the likelier a standing person was noticed",
    PictureKind.VIEWS: "grey: searched, the darker the more independent views",
    PictureKind.COVERAGE: "grey: in a frame",
}
"""Rasters of the searched ground, the one that says most first, and what their grey stands for."""
_LIGHTEST, _DARKEST = 245, 185
"""Greys of the share 0 and 1: what is printed above them has to be legible."""
_FLAT: Final = 0.5
"""Share that stands for ground that was in a frame: how often says little."""


def searched_grey(raster: Raster) -> NDArray[np.uint8]:
    """Return the searched ground as grey on white, shape (rows, columns).

    Raises:
        InputDataError: the recorded picture is damaged.
    """
    rgba = cv2.imdecode(np.frombuffer(raster.png, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    if rgba is None or rgba.ndim != 3 or rgba.shape[2] != 4:
        raise InputDataError(f"the recorded picture {raster.kind.value} of the searched ground is damaged")
    bgra = np.asarray(rgba, dtype=np.uint8)
    shares = np.full(bgra.shape[:2], _FLAT) if raster.kind is PictureKind.COVERAGE else _shares(bgra)
    grey = _LIGHTEST + shares * (_DARKEST - _LIGHTEST)
    return np.where(bgra[:, :, 3] > 0, np.rint(grey), 255.0).astype(np.uint8)


def _shares(bgra: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return the shares, 0 to 1, that the colours of a picture stand for."""
    colours, indices = _palette()
    packed = _packed(bgra[:, :, :3])
    places = np.minimum(np.searchsorted(colours, packed), colours.size - 1)
    return np.asarray(indices[places] / 255.0)


@cache
def _palette() -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the colours of the dashboard's palette in ascending order, each with its place in the palette."""
    bgr = cv2.applyColorMap(np.arange(256, dtype=np.uint8), cv2.COLORMAP_VIRIDIS).reshape(-1, 3)
    return np.unique(_packed(np.asarray(bgr, dtype=np.uint8)), return_index=True)


def _packed(bgr: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Return colours, shape (..., 3), as one number each, shape (...)."""
    return np.asarray(bgr.astype(np.int64) @ np.array([65_536, 256, 1]))
