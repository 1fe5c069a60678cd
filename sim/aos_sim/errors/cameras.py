"""Cameras with all their errors: from the motion of a vehicle to the frame that its camera delivers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_sim.errors.exposure import CameraErrors, Motion
from aos_sim.errors.model import ErrorModel
from aos_sim.errors.optics import FloatArray
from aos_sim.errors.sensor import CameraSensor, RenderedFrame

View = Callable[[Pose, CameraModel, float], FloatArray]
"""What a camera sees from a pose at a moment: red, green, blue (0 to 255) and degrees Celsius, shape (H, W, 4)."""

LAST_MOMENT_S = 3600
"""Moments that are drawn, not flown, lie within so many seconds."""


class ErringCameras:
    """The cameras of a swarm. Equal arguments give equal frames; any number of threads may call it at once.

    Args:
        model: errors; the positions and attitudes of the vehicles are not the cameras' matter.
        camera: common model of the cameras.
        seed: of what stays with each camera.
    """

    def __init__(self, model: ErrorModel, camera: CameraModel, seed: int) -> None:
        self.camera = camera
        self._poses = CameraErrors(model.gimbal, model.timing, seed)
        self._sensor = CameraSensor(model.thermal, model.optics, seed)

    def expose(
        self, view: View, motion: Motion, rng: np.random.Generator, *, camera_id: int, index: int, at_s: float
    ) -> RenderedFrame:
        """Return an image.

        Args:
            view: the scene.
            motion: true motion of the vehicle at the moment that it reports for the image.
            rng: draws the noise.
            camera_id: which camera.
            index: number of its image.
            at_s: seconds since the camera has started.
        """
        true = self._poses.expose(camera_id, index, motion, self.camera)
        seen = view(true.pose, self.camera, at_s)
        return self._sensor.expose(seen, rng, camera_id=camera_id, at_s=at_s, speed_pxps=true.speed_pxps)


def four_bands(frame: RenderedFrame) -> FloatArray:
    """Return red, green, blue and degrees Celsius, shape (H, W, 4)."""
    bands = np.empty((*frame.thermal_celsius.shape, 4), np.float32)
    bands[..., :3], bands[..., 3] = frame.rgb, frame.thermal_celsius
    return bands
