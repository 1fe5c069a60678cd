"""Images with their poses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition


@dataclass(frozen=True, slots=True, eq=False)
class Capture:
    """One exposure of a vehicle's camera."""

    vehicle_id: int
    image_index: int
    """The camera's own running number."""
    utc_s: float
    """Time of exposure."""
    image: NDArray[np.uint8] | NDArray[np.uint16] | NDArray[np.float32]
    """Shape (H, W, C); bands as in ``bands``."""
    bands: tuple[str, ...]
    """One of ``red, green, blue, grey, thermal`` per channel. Thermal is in degrees Celsius when radiometric."""
    position: GeodeticPosition
    """Projection centre at exposure."""
    R_cam2enu: NDArray[np.float64]
    """Orientation at exposure, shape (3, 3), into the ENU axes at ``position``."""
    camera: CameraModel
    time_sigma_s: float | None = None
    """Standard deviation of the time that the pose is of; None where the source does not report it."""


class IntervalCaptures(Protocol):
    """Images of a camera that takes them by itself; see ``Vehicle.interval``."""

    async def next(self, deadline_s: float) -> Capture:
        """Wait for the next image that is there whole, each once; a slow one delays none that come after it.

        Raises:
            NoIntervalError: the camera takes no images by itself any more, as when another station has stopped it.
            CaptureError: an image is missing, refused or late, or none came by ``deadline_s``; the next may come.
        """
        ...
