"""What an upright body hides of the ground, exactly: the truth that the archive strategy's own idea is held against."""

import numpy as np

from aos_gcs.swarm.archive.raster import CELL_M, FINE_CELLS, HALF_CELLS, SIDE, BoolArray, FloatArray

_AXIS_M = CELL_M * (np.arange(SIDE) + 0.5 - HALF_CELLS)
_CELLS_M = np.stack([axis.ravel() for axis in np.meshgrid(_AXIS_M, -_AXIS_M)]).astype(np.float32)


def footprints(slopes: FloatArray, height_m: float, body_height_m: float, body_radius_m: float) -> BoolArray:
    """Return what an upright body at the raster's middle would cover without forest, shape (n, CELLS).

    The body is a vertical line of some thickness; seen under a slope its image on the focal plane reaches from the foot
    away from the camera.

    Args:
        slopes: horizontal distance over height of camera above target, east and north, shape (n, 2).
        height_m: of the cameras above the focal plane, more than the body's.
        body_height_m: above the focal plane.
        body_radius_m: half of the body's width.
    """
    heads_m = (-slopes * (body_height_m * height_m / (height_m - body_height_m))).astype(np.float32)
    lengths_m2 = np.maximum((heads_m**2).sum(axis=1), np.float32(1e-9))[:, None]
    along = heads_m @ _CELLS_M
    share = np.clip(along / lengths_m2, 0.0, 1.0)
    # |cell - share * head|^2, multiplied out.
    distances_m2 = (_CELLS_M**2).sum(axis=0) - share * (2.0 * along - share * lengths_m2)
    return np.asarray(distances_m2 <= body_radius_m**2)


def on_fine_cells(masks: BoolArray) -> BoolArray:
    """Return masks, shape (n, CELLS), on fine cells, shape (n, FINE_CELLS)."""
    return np.asarray(masks.reshape(-1, SIDE, SIDE).repeat(2, axis=1).repeat(2, axis=2).reshape(-1, FINE_CELLS))
