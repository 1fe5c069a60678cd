"""Frames that the vehicles' cameras have delivered, and the footprints of the latest ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from aos_gcs.airspace.polygon import Polygon, as_points
from aos_gcs.geometry.projection import intersect_plane
from aos_gcs.imaging.model import Frame
from aos_gcs.mission.model.vehicles import CameraSnapshot

MAX_FOOTPRINT_HEIGHTS: Final = 10.0
"""Largest distance of a footprint's corner, in heights above the plane: beyond it the camera looks along the ground."""


def footprint_enu_m(frame: Frame, plane_height_m: float) -> Polygon:
    """Return the corners of what a frame shows of a plane, clockwise from its upper left pixel.

    Empty when it looks above the horizon, or so flat that a corner is far away.
    """
    width_px, height_px = frame.camera.width_px, frame.camera.height_px
    corners_px = np.array([(0, 0), (width_px, 0), (width_px, height_px), (0, height_px)]) - 0.5
    corners_enu_m = intersect_plane(corners_px, frame.camera, frame.pose, plane_height_m)[:, :2]
    position_enu_m = frame.pose.position_enu_m
    reach_m = MAX_FOOTPRINT_HEIGHTS * abs(float(position_enu_m[2]) - plane_height_m)
    distances_m = np.linalg.norm(corners_enu_m - position_enu_m[:2], axis=1)
    return as_points(corners_enu_m) if bool((distances_m <= reach_m).all()) else ()


class CameraLog:
    """Counts of delivered and missing frames, by vehicle."""

    def __init__(self) -> None:
        self._cameras: dict[int, CameraSnapshot] = {}

    def note(
        self, step: int, frames: Sequence[Frame], footprints: Sequence[Polygon], missing: Mapping[int, str]
    ) -> None:
        """Note the frames of a step.

        Args:
            step: number of the step.
            frames: those that could be used.
            footprints: one for each frame.
            missing: reasons why other vehicles delivered none.
        """
        for frame, footprint in zip(frames, footprints, strict=True):
            camera = self.of(frame.vehicle_id)
            self._cameras[frame.vehicle_id] = replace(
                camera, frames=camera.frames + 1, last_step=step, footprint_enu_m=footprint, failure=None
            )
        for vehicle_id, reason in missing.items():
            camera = self.of(vehicle_id)
            self._cameras[vehicle_id] = replace(camera, failures=camera.failures + 1, failure=reason)

    def of(self, vehicle_id: int) -> CameraSnapshot:
        """Return what is known of a vehicle's camera."""
        return self._cameras.get(vehicle_id, CameraSnapshot())
