"""Pictures of the surroundings of anomalies on a map."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.exports.rasters import write_picture
from aos_gcs.imaging.model import MapRaster
from aos_gcs.imaging.pictures import shade_counts, shade_integral
from aos_gcs.surveys.anomalies import MapBlob

MOST = 200
"""Largest number of pictures: those of the most significant anomalies."""
RADIUS_M = 5.0
"""Half the edge of the ground that a picture shows."""
_EDGE_PX = 320


def write_thumbnails(
    folder: Path,
    blobs: Sequence[MapBlob],
    *,
    integral: NDArray[np.float32],
    bands: tuple[str, ...],
    significances: NDArray[np.float32],
    raster: MapRaster,
) -> list[Path]:
    """Write a picture of each anomaly, the map beside its significance, and return their paths.

    Args:
        folder: folder of the pictures, which is made where it is missing.
        blobs: anomalies, in the order of their numbers.
        integral: the map, shape (rows, columns, C).
        bands: bands of the map.
        significances: see :func:`~aos_gcs.surveys.significance.significance`.
        raster: raster of the map.

    Raises:
        ConfigurationError: if a file cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigurationError(f"Cannot make the folder {folder}: {error.strerror or error}.") from error
    to_cell = np.linalg.inv(raster.to_plane)
    paths = []
    for number, blob in enumerate(blobs[:MOST], start=1):
        column, row, _ = to_cell @ (*blob.position_m[:2], 1.0)
        window = _window(column, row, raster)
        known = ~np.isnan(integral[window][:, :, 0])
        heat = np.asarray(np.rint(10.0 * significances[window]), dtype=np.uint16)
        pictures = (shade_integral(integral[window], bands), shade_counts(heat, known))
        path = folder / f"{number:03}.png"
        write_picture(path, np.hstack([_enlarged(picture) for picture in pictures]))
        paths.append(path)
    return paths


def _window(column: float, row: float, raster: MapRaster) -> tuple[slice, slice]:
    """Return the rows and columns about a cell; fewer at the edges of the map."""
    reach = max(1, math.ceil(RADIUS_M / raster.resolution_m))
    rows, columns = (
        slice(max(0, round(middle) - reach), min(size, round(middle) + reach + 1))
        for middle, size in ((row, raster.rows), (column, raster.columns))
    )
    return rows, columns


def _enlarged(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    factor = _EDGE_PX / max(picture.shape[:2])
    size = max(1, round(picture.shape[1] * factor)), max(1, round(picture.shape[0] * factor))
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_NEAREST), dtype=np.uint8)
