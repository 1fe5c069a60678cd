"""Levels of anomaly of an image's pixels, and their sums on the ground."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import scipy
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.detection.detectors import DETECTORS, thermal_band
from aos_gcs.imaging.detection.local_rx import LOADING, local_rx_scores, local_warm_scores
from aos_gcs.imaging.model import Detector, Frame, Pixels
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.views import FocalSurface, FocalView
from aos_gcs.surveys.significance import AnomalySums

REACH_M = 0.3
"""Distance up to which a pixel marks the ground around it: half the width of a body, and errors of the poses."""
BODY_M = 1.9
"""Edge of the square around a pixel that its surroundings leave out: a person, lying."""
LEVELS_PER_DOUBLING = 2
MOST_LEVELS = 13
"""Levels above the first six doublings of the score are one: nothing in an image is told more clearly."""
_BASE_DEVIATIONS = 5.0
"""Deviation of one band from its surroundings that is the lowest level, in standard deviations."""
_SURROUNDINGS = 2.5
"""Edge of the surroundings in multiples of what they leave out. The smaller they are, the more a second body of even
warmth hides the first: with 2.0 two persons 1.6 m apart on calm ground were marked in no image."""
_STRIDE_PX = 4
"""Distance of the pixels by which the levels of a picture are known."""
_FEWEST_PX = 9
"""Smallest square of pixels that surroundings leave out."""


@cache
def base_score(bands: int) -> float:
    """Return the score of the lowest level: as rare on a Gaussian background as five deviations of one band."""
    return float(scipy.special.chdtri(bands, scipy.special.chdtrc(1, _BASE_DEVIATIONS**2)))


def levels(
    frame: Frame, detector: Detector, surface: FocalSurface, min_score: float | None = None, cell_m: float | None = None
) -> Frame | None:
    """Return the levels of a frame in its place, one band; None if no pixel reaches the lowest.

    Level 0 lies below the base score, level 1 reaches it, and each further one takes a score larger by the square root
    of two. Every pixel takes the highest level within :data:`REACH_M`, at least half a cell.

    Args:
        frame: one band or several.
        detector: detector of the scores. The thermal detector takes a grey image for a thermal one.
        surface: ground, which tells how large a pixel is.
        min_score: base score; None: :func:`base_score`.
        cell_m: edge of a cell of the raster; None where cells have different sizes.

    Raises:
        ImagingError: if the frame lacks a band that the detector needs.
    """
    pixel_m = pixel_size_m(frame.camera, frame.pose, surface)
    # A thermal recording is a grey picture to its files.
    bands = ("thermal",) if detector is Detector.THERMAL and frame.bands == ("grey",) else frame.bands
    windows_px = _windows_px(pixel_m, min(frame.image.shape[:2]))
    if detector is Detector.LOCAL_RX:
        scores = local_rx_scores(frame.image, *windows_px, LOADING + _rounding(frame.image))
    elif detector is Detector.THERMAL:
        # A deviation of the whole frame would be that of its restless part, and hide who lies on a calm meadow.
        band = thermal_band(frame.image, bands)
        scores = local_warm_scores(band, *windows_px, LOADING + _rounding(band[:, :, np.newaxis]))
    else:
        scores = DETECTORS[detector].scores(frame.image, bands)
    base = base_score(1 if detector is Detector.THERMAL else len(bands)) if min_score is None else max(min_score, 1e-6)
    marked = scores >= base
    if not marked.any():
        return None
    level = np.zeros(scores.shape, dtype=np.uint8)
    doublings = np.log2(scores[marked].astype(np.float64) / base)
    level[marked] = np.clip(np.floor(LEVELS_PER_DOUBLING * doublings) + 1.0, 1.0, MOST_LEVELS)
    reach_px = max(REACH_M, 0.0 if cell_m is None else cell_m / 2.0) / pixel_m
    # A square with the area of a circle: its rows and columns are looked at one after the other.
    edge_px = 2 * round(reach_px * math.sqrt(math.pi) / 2.0) + 1
    grown = cv2.dilate(level, np.ones((edge_px, edge_px), dtype=np.uint8))
    return replace(frame, image=np.asarray(grown, dtype=np.uint8).reshape(*level.shape, 1), bands=("anomaly",))


def add_levels(sums: AnomalySums, frame: Frame, view: FocalView, coverage: NDArray[np.uint16] | None = None) -> None:
    """Add the levels of a frame, see :func:`levels`, to the cells of a view; where they are NaN it sees nothing.

    Args:
        sums: marks of the images.
        frame: levels in the place of an image.
        view: raster of the sums.
        coverage: images that see each cell, to which the frame is added; None: not counted here.
    """
    projection = view.project(frame)
    warped = None if projection is None else projection.sample(frame.image, 0, view.shape[0])
    if warped is None:
        return
    if frame.image.dtype.kind == "f":
        warped = warped.without_gaps()
    covered = warped.coverage()
    level: NDArray[np.uint8] = np.rint(warped.values[:, :, 0] * (covered > 0)).astype(np.uint8)
    sums.count[warped.window] += level > 0
    sums.excess[warped.window] += np.maximum(level, 1) - np.uint8(1)
    if coverage is not None:
        coverage[warped.window] += covered


def pixel_size_m(camera: CameraModel, pose: Pose, surface: FocalSurface) -> float:
    """Return the size of a pixel on the surface, at the foot of its camera."""
    x_m, y_m, z_m = pose.position_enu_m
    surface_m = float(surface.z_m(x_m, y_m))
    if not math.isfinite(surface_m) and isinstance(surface, Terrain):
        surface_m = float(np.nanmedian(surface.heights_m))
    return max(abs(float(z_m) - surface_m), 1e-6) / camera.fx_px


def _rounding(image: Pixels) -> float:
    """Return the variance of the rounding of one band, in units of that of the frame; 0 of several.

    A camera whose range is far wider than the scene tells it in a dozen levels: ground that one of them covers does not
    vary, and a pixel that differs by one would stand out.
    """
    if image.shape[2] != 1:
        return 0.0
    seen = image[::_STRIDE_PX, ::_STRIDE_PX, 0].astype(np.float64)
    seen = seen[np.isfinite(seen)]
    steps = np.diff(np.unique(seen))
    return float(steps.min() ** 2 / 12.0 / seen.var()) if steps.size else 0.0


def _windows_px(pixel_m: float, shorter_px: int) -> tuple[int, int]:
    """Return the inner and outer window of a pixel's surroundings: a person, and room for others beside."""
    inner = int(np.clip(round(BODY_M / pixel_m), _FEWEST_PX, max(_FEWEST_PX, shorter_px // 4))) | 1
    return inner, round(_SURROUNDINGS * inner) | 1
