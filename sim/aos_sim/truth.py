"""Views of the persons without the forest: the reference of normalised visibility."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.poses import Pose
from aos_sim.world.person import Person, person_mesh
from aos_sim.world.scene import Scene, build_scene
from aos_sim.world_file import scene_parameters

CELL_M = 0.02
_WITHOUT_DISTRACTORS = {"animals": 0, "stones": 0, "cloths": 0}
HALF_WIDTH_M = 6.0
"""Side of the square around a person for its outlines; the outline of a standing one that is seen 70 degrees
off the nadir still fits in."""
_ASIDE = 0.8
"""Growth of that square per metre of the person's height above the origin, where the focal plane lies: what is
seen 39 degrees off the nadir still fits in."""


def unoccluded_areas_m2(
    world: Mapping[str, Any],
    steps: Sequence[Sequence[tuple[Pose, CameraModel]]],
    plane_height_m: float = 0.0,
    times_utc_s: Sequence[float] | None = None,
) -> list[float]:
    """Return per step the area on the focal plane that the views of its cameras would cover of the persons together.

    A view covers what lies behind a person as seen from the camera: its mesh projected onto the plane from the
    camera's position. Views that do not show a person's position do not count for it.

    Args:
        world: fields of the world file; of those that are missing, the defaults.
        steps: the cameras of each step.
        plane_height_m: height of the focal plane, below the cameras.
        times_utc_s: time of each step by the simulation's clock; needed where persons walk.
    """
    origin = GeodeticPosition(**world["origin"]) if "origin" in world else None
    scene = build_scene(scene_parameters({**_WITHOUT_DISTRACTORS, **world}), origin)
    persons = scene.persons
    start_utc_s = float(world.get("start_utc_s", 0.0))
    still = [(person, _triangles(scene, person)) for person in persons]
    areas_m2 = []
    for index, views in enumerate(steps):
        bodies = still
        if times_utc_s is not None and any(person.walk is not None for person in persons):
            bodies = [
                (person, _triangles(scene, person)) for person in scene.persons_at(times_utc_s[index] - start_utc_s)
            ]
        areas_m2.append(sum(_covered_m2(person, mesh, views, plane_height_m) for person, mesh in bodies))
    return areas_m2


def _triangles(scene: Scene, person: Person) -> NDArray[np.float64]:
    return scene.draped(person_mesh(person), person.position_enu_m).triangles_enu_m.astype(np.float64)


def _covered_m2(
    person: Person, mesh: NDArray[np.float64], views: Sequence[tuple[Pose, CameraModel]], plane_height_m: float
) -> float:
    place_enu_m = person.position_enu_m
    poses = [pose for pose, camera in views if _shows(pose, camera, place_enu_m)]
    return _union_m2(mesh, place_enu_m, poses, plane_height_m)


def _shows(pose: Pose, camera: CameraModel, position_enu_m: NDArray[np.float64]) -> bool:
    x_m, y_m, depth_m = (position_enu_m - pose.position_enu_m) @ pose.R_cam2enu
    if depth_m <= 0.0:
        return False
    column = camera.fx_px * x_m / depth_m + camera.cx_px
    row = camera.fy_px * y_m / depth_m + camera.cy_px
    return bool(0.0 <= column <= camera.width_px - 1 and 0.0 <= row <= camera.height_px - 1)


def _union_m2(
    triangles_enu_m: NDArray[np.float64], centre_enu_m: NDArray[np.float64], poses: Sequence[Pose], height_m: float
) -> float:
    """Return the area of all projections of a mesh, shape (n, 3, 3), onto the plane at ``height_m`` together."""
    half_width_m = HALF_WIDTH_M + _ASIDE * abs(centre_enu_m[2])
    side = round(2 * half_width_m / CELL_M)
    canvas = np.zeros((side, side), np.uint8)
    for pose in poses:
        rays_m = triangles_enu_m - pose.position_enu_m
        reach = (height_m - pose.position_enu_m[2]) / rays_m[..., 2]
        on_plane_enu_m = pose.position_enu_m[:2] + reach[..., None] * rays_m[..., :2]
        cells = np.rint((on_plane_enu_m - centre_enu_m[:2] + half_width_m) / CELL_M).astype(np.int32)
        for triangle in cells:
            cv2.fillConvexPoly(canvas, triangle, 1)
    return float(np.count_nonzero(canvas)) * CELL_M**2
