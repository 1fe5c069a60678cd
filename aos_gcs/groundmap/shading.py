"""Pictures of the searched ground for operators: views per place, probability of detection, and the prior."""

from __future__ import annotations

import math
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.groundmap.detection import DETECTABILITY, Posture, detection_by_views
from aos_gcs.groundmap.figures import ViewRaster
from aos_gcs.groundmap.tile import MAX_VIEWS, VIEW_CELL_M
from aos_gcs.imaging.pictures import RasterPicture, encode_png
from aos_gcs.prior.model import AreaPrior

FULL_VIEWS: Final = 30
"""Number of views from which the colour no longer changes."""
PICTURED_POSTURE: Final = Posture.STANDING
"""Posture whose probability of detection is pictured: from above, one who stands is the smallest."""
MAX_PICTURE_CELLS: Final = 1_000_000
"""Largest number of cells of a picture; larger rasters are reduced, to the smallest number of views in each place."""
_ALPHA = np.uint8(150)
"""Opacity; the map below must stay readable."""


def ground_pictures(raster: ViewRaster, occlusion: float | None) -> tuple[RasterPicture, ...]:
    """Return the pictures ``views`` and, where the forest is described, ``detection``; transparent where not seen.

    Args:
        raster: numbers of views.
        occlusion: share of the ground that one image does not see; None where the forest is not described.
    """
    shares = {"views": np.minimum(np.arange(MAX_VIEWS + 1) / FULL_VIEWS, 1.0)}
    if occlusion is not None:
        shares["detection"] = detection_by_views(occlusion, DETECTABILITY[PICTURED_POSTURE])
    views, cell_m = _reduced(raster.views)
    return tuple(
        RasterPicture(
            kind=kind,
            png=encode_png(_palette(share)[views]),
            west_m=raster.west_m,
            south_m=raster.north_m - views.shape[0] * cell_m,
            east_m=raster.west_m + views.shape[1] * cell_m,
            north_m=raster.north_m,
        )
        for kind, share in shares.items()
    )


def prior_picture(prior: AreaPrior) -> RasterPicture:
    """Return the picture ``prior``: the brighter the likelier by area, transparent where the person cannot be."""
    rows, columns = prior.mass.shape
    shares = prior.mass / max(float(prior.mass.max()), np.finfo(np.float64).tiny)
    bgr = cv2.applyColorMap((255.0 * shares).astype(np.uint8), cv2.COLORMAP_PLASMA)
    alpha = np.where(prior.mass > 0.0, _ALPHA, np.uint8(0))
    return RasterPicture(
        kind="prior",
        png=encode_png(np.dstack((bgr[..., ::-1], alpha))),
        west_m=prior.west_m,
        south_m=prior.north_m - rows * prior.cell_m,
        east_m=prior.west_m + columns * prior.cell_m,
        north_m=prior.north_m,
    )


def _reduced(views: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], float]:
    """Return the views in few enough cells, and the edge of one; a cell has what its least seen part has."""
    factor = math.ceil(math.sqrt(views.size / MAX_PICTURE_CELLS))
    if factor <= 1:
        return views, VIEW_CELL_M
    rows, columns = (-(-size // factor) for size in views.shape)
    whole = np.zeros((rows * factor, columns * factor), dtype=np.uint8)
    whole[: views.shape[0], : views.shape[1]] = views
    return whole.reshape(rows, factor, columns, factor).min(axis=(1, 3)), VIEW_CELL_M * factor


def _palette(shares: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return the colour of each number of views, shape (256, 4), by shares from 0 to 1."""
    bgr = cv2.applyColorMap((255.0 * shares).astype(np.uint8), cv2.COLORMAP_VIRIDIS).reshape(-1, 3)
    alpha = np.where(np.arange(len(shares)) > 0, _ALPHA, np.uint8(0))
    return np.column_stack((bgr[:, ::-1], alpha)).astype(np.uint8)
