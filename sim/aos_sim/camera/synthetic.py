"""Images without a world: a pattern on the ground, for tests and machines without a renderer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_sim.world.relief import Relief

TILE_M = 2.0
COOL_CELSIUS = 15.0
WARM_CELSIUS = 20.0
COOL_RGB = (60, 110, 50)
WARM_RGB = (120, 90, 60)


class CheckerboardGround:
    """A chequered ground: cool green and warm brown tiles of 2 m, correct in perspective.

    Args:
        relief: shape of the ground; None: the plane z = 0.
    """

    def __init__(self, relief: Relief | None = None) -> None:
        self._relief = relief

    def view(self, pose: Pose, camera: CameraModel, at_s: float) -> NDArray[np.float32]:
        """See :meth:`aos_sim.camera.image.ImageSource.view`; a ray that misses the ground sees it far away."""
        del at_s
        columns, rows = np.meshgrid(np.arange(camera.width_px), np.arange(camera.height_px))
        directions_cam = np.stack(
            [(columns - camera.cx_px) / camera.fx_px, (rows - camera.cy_px) / camera.fy_px, np.ones(rows.shape)],
            axis=-1,
        )
        directions = directions_cam @ pose.R_cam2enu.T
        down = np.maximum(-directions[..., 2], 1e-6)
        reach = pose.position_enu_m[2] / down
        if self._relief is not None:
            reach = self._relief.reach(pose.position_enu_m, np.dstack([directions[..., :2], -down]))
        ground = pose.position_enu_m[:2] + directions[..., :2] * reach[..., np.newaxis]
        warm = np.floor(ground / TILE_M).sum(axis=-1) % 2 == 1
        cool_view, warm_view = (*COOL_RGB, COOL_CELSIUS), (*WARM_RGB, WARM_CELSIUS)
        return np.where(warm[..., np.newaxis], warm_view, cool_view).astype(np.float32)
