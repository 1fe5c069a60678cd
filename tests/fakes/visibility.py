"""Share of a simulated person that a camera sees."""

from __future__ import annotations

import numpy as np

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_sim.render.renderer import Renderer


def person_visibility(renderer: Renderer, pose: Pose, camera: CameraModel, name: str | None = None) -> float | None:
    """Return the visible share of a person's pixels, 0 to 1, or None when out of view.

    It compares with the same view without forest. ``name`` as in ``Renderer.person_masks``.
    """
    masks = renderer.person_masks(pose, camera, name)
    unoccluded = np.count_nonzero(masks.unoccluded)
    return np.count_nonzero(masks.visible) / unoccluded if unoccluded else None
