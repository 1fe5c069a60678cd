"""Frames over level ground for maps of it."""

from __future__ import annotations

import math

import numpy as np

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.model import Frame

ORIGIN = GeodeticPosition(47.0, 15.0, 400.0)
BANDS = ("red", "green", "blue", "thermal")
COLOUR = (10.0, 20.0, 30.0, 12.5)
"""Values of all pixels."""
CAMERA = CameraModel.from_fov(64, 64, math.radians(50.0))
R_NADIR = np.diag([1.0, -1.0, -1.0])


def ground_frame(
    east_m: float, north_m: float, height_m: float = 40.0, bands: tuple[str, ...] = BANDS, **changes: object
) -> Frame:
    """Return a frame of one colour, straight down: at 40 m it shows 37.3 m of the ground."""
    image = np.broadcast_to(np.array(COLOUR[: len(bands)], dtype=np.float32), (64, 64, len(bands))).copy()
    pose = Pose(np.array([east_m, north_m, height_m]), R_NADIR)
    fields = {"image": image, "pose": pose, "camera": CAMERA} | changes
    return Frame(vehicle_id=1, bands=bands, **fields)  # type: ignore[arg-type]
