"""What the cameras of the fakes see: ground with noise, and warm things on it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel

_TARGET_RADIUS_M = 0.7
_CLOTHES_C = 24.0
"""Temperature from which a thing is a person, whose middle shows skin."""
_SKIN_RADIUS_M, _SKIN_K = 0.3, 5.0
_MEANS, _DEVIATIONS = np.array([70.0, 90.0, 50.0, 12.0]), np.array([6.0, 6.0, 6.0, 0.5])
"""Bands of the ground: red, green, blue, degrees Celsius."""


def look_down(
    vehicle_id: int,
    image_index: int,
    camera: CameraModel,
    true_enu_m: NDArray[np.float64],
    things: Sequence[tuple[float, float, float]],
) -> NDArray[np.float32]:
    """Return an image that looks straight down with north up, shape (H, W, 4).

    ``things`` are east, north and degrees Celsius of what lies on the ground.
    """
    shape = camera.height_px, camera.width_px
    image = _ground(vehicle_id, image_index, shape).copy()
    east_m, north_m, up_m = true_enu_m
    ground_m = up_m / camera.fx_px
    rows, columns = np.indices(shape, sparse=True)
    for at_east_m, at_north_m, celsius in things:
        east_of_target_m = east_m + (columns - camera.cx_px) * ground_m - at_east_m
        north_of_target_m = north_m - (rows - camera.cy_px) * ground_m - at_north_m
        distance_m = np.hypot(east_of_target_m, north_of_target_m)
        image[distance_m < _TARGET_RADIUS_M] = [200.0, 40.0, 160.0, celsius]
        if celsius >= _CLOTHES_C:
            image[distance_m < _SKIN_RADIUS_M, 3] += _SKIN_K
    return image


@lru_cache(maxsize=256)
def _ground(vehicle_id: int, image_index: int, shape: tuple[int, int]) -> NDArray[np.float32]:
    """Return the ground as a vehicle sees it in one image, shape (H, W, 4): the same in every mission."""
    rng = np.random.default_rng([vehicle_id, image_index])
    # Twice as fast as rng.normal with these means and deviations, and the same numbers.
    noise = rng.standard_normal((*shape, 4))
    return np.asarray((_MEANS + noise * _DEVIATIONS).astype(np.float32))
