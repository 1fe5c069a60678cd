"""Pictures in memory as sources of tiles, wherever their pixels lie on the ground."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.basemaps.mercator import WorldBox, pixel_centres, to_degrees
from aos_gcs.basemaps.pyramid import Rgba

FloatArray = NDArray[np.float64]
ToPixels = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""Columns and rows of a picture, whole at the centres of its pixels, of longitudes and latitudes in degrees."""

_LARGE_STEP = 1.5
"""Pixels of a picture per pixel of a tile from which their mean is taken."""


class PictureSource:
    """A picture whose pixels are found by a function of longitude and latitude."""

    def __init__(self, rgba: NDArray[np.uint8], box: WorldBox, pixel: float, to_pixels: ToPixels) -> None:
        """Take a picture.

        Args:
            rgba: red, green, blue and opacity, shape (rows, columns, 4).
            box: its extent on the map of the world.
            pixel: width of its pixels as a share of the world's.
            to_pixels: where its pixels are.
        """
        self.box, self.pixel = box, pixel
        # Colours times opacity, which are interpolated: what is transparent lends no colour to its neighbours.
        opacity = rgba[..., 3:].astype(np.uint16)
        colours = (rgba[..., :3] * opacity + 127) // 255
        self._rgba = np.concatenate((colours.astype(np.uint8), rgba[..., 3:]), axis=-1)
        self._to_pixels = to_pixels

    def tile(self, zoom: int, column: int, row: int) -> Rgba | None:
        """Return its pixels in a tile, or None."""
        x, y = pixel_centres(zoom, column, row)
        longitude, latitude = to_degrees(*np.meshgrid(x, y))
        columns, rows = self._to_pixels(longitude, latitude)
        height, width = self._rgba.shape[:2]
        first = max(0, int(np.floor(rows.min())) - 1), max(0, int(np.floor(columns.min())) - 1)
        end = min(height, int(np.ceil(rows.max())) + 2), min(width, int(np.ceil(columns.max())) + 2)
        if first[0] >= end[0] or first[1] >= end[1]:
            return None
        part = self._rgba[first[0] : end[0], first[1] : end[1]]
        rows, columns = rows - first[0], columns - first[1]
        step = max(float(np.ptp(rows)) / len(y), float(np.ptp(columns)) / len(x))
        if step > _LARGE_STEP:
            # Bilinear values alone would skip pixels.
            size = max(1, round(part.shape[1] / step)), max(1, round(part.shape[0] / step))
            scale = size[0] / part.shape[1], size[1] / part.shape[0]
            part = np.asarray(cv2.resize(part, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
            columns, rows = (columns + 0.5) * scale[0] - 0.5, (rows + 0.5) * scale[1] - 0.5
        found = cv2.remap(
            part,
            columns.astype(np.float32),
            rows.astype(np.float32),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=(0.0, 0.0, 0.0, 0.0),
        )
        opacity = found[..., 3:].astype(np.float32) / 255.0
        colours = (found[..., :3] / np.maximum(opacity, 1.0 / 255.0)).clip(0.0, 255.0)
        return np.concatenate((np.rint(colours).astype(np.uint8), found[..., 3:]), axis=-1)
