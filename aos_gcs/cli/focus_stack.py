"""Contact sheet of ``aos-gcs integrate``: a view integrated at evenly spaced heights, to choose the height by eye."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.exports.rasters import write_picture
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import Plane
from aos_gcs.imaging.integral import integrate
from aos_gcs.imaging.pictures import shade_integral
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.views import perspective_view
from aos_gcs.surveys.images import LazyFrames
from aos_gcs.surveys.model import Survey

PLANES = 12
COLUMNS = 4
EDGE_PX = 320
LABEL_PX = 24


def write_focus_stack(
    path: Path,
    survey: Survey,
    virtual: tuple[CameraModel, Pose],
    surfaces: Sequence[tuple[str, Plane | Terrain]],
    *,
    skip_broken: bool,
) -> None:
    """Write a view integrated on some surfaces as one picture, each with its label.

    Raises:
        ConfigurationError: if the file cannot be written.
        InputDataError: if an image cannot be read.
    """
    camera, pose = virtual
    small = CameraModel.from_fov(EDGE_PX, EDGE_PX, camera.horizontal_fov_rad)
    frames = LazyFrames(survey.images, survey.bands, skip_broken)
    tiles = []
    for label, surface in surfaces:
        integral, _ = integrate(frames, perspective_view(small, pose, surface))
        tiles.append(_labelled(shade_integral(integral, survey.bands), label))
    write_picture(path, sheet(tiles))


def stack_heights_m(low_m: float, high_m: float) -> list[float]:
    """Return the heights of a contact sheet, both ends included."""
    return [float(height_m) for height_m in np.linspace(low_m, high_m, PLANES)]


def sheet(tiles: Sequence[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """Return pictures of one size in rows of ``COLUMNS``; what is left of the last row is transparent."""
    rows, (height, width, channels) = math.ceil(len(tiles) / COLUMNS), tiles[0].shape
    whole = np.zeros((rows * height, COLUMNS * width, channels), dtype=np.uint8)
    for index, tile in enumerate(tiles):
        row, column = divmod(index, COLUMNS)
        whole[row * height : (row + 1) * height, column * width : (column + 1) * width] = tile
    return whole


def _labelled(picture: NDArray[np.uint8], label: str) -> NDArray[np.uint8]:
    strip = np.zeros((LABEL_PX, picture.shape[1], 4), dtype=np.uint8)
    cv2.putText(strip, label, (6, LABEL_PX - 7), cv2.FONT_HERSHEY_SIMPLEX, 0.55, (255, 255, 255, 255), 1, cv2.LINE_AA)
    # Only now: smoothed letters leave other values behind.
    strip[..., 3] = 255
    return np.vstack((picture, strip))
