"""Regions that autofocus looks at: a part of the ground, or of a camera's view."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import Plane, intersect_plane, pixel_rays
from aos_gcs.imaging.surfaces.terrain import Terrain

MAX_POINTS = 10_000
"""Points of a region: more make autofocus slower, and no better."""


class FocusRegion(Protocol):
    """A lattice of points that can be laid on any focal surface."""

    def points_m(self, surface: Plane | Terrain) -> NDArray[np.float64]:
        """Return the points on a surface, shape (n, 3), NaN where there are none; n does not depend on the surface."""
        ...

    def centre_m(self, height_m: float) -> NDArray[np.float64]:
        """Return the region's centre on the plane z = height, shape (3,)."""
        ...


@dataclass(frozen=True, slots=True)
class GroundRegion:
    """A rectangle in x and y, whatever the height of the plane is.

    Raises:
        ImagingError: if it has no area.
    """

    min_x_m: float
    min_y_m: float
    max_x_m: float
    max_y_m: float

    def __post_init__(self) -> None:
        _check_area(self.min_x_m, self.min_y_m, self.max_x_m, self.max_y_m, "m")

    def points_m(self, surface: Plane | Terrain) -> NDArray[np.float64]:
        """Return the points on a surface, shape (n, 3); z is NaN where a terrain is unknown."""
        x, y = _lattice(self.min_x_m, self.min_y_m, self.max_x_m, self.max_y_m).T
        return np.column_stack((x, y, surface.z_m(x, y)))

    def centre_m(self, height_m: float) -> NDArray[np.float64]:
        """Return the centre at a height, shape (3,)."""
        return np.array([(self.min_x_m + self.max_x_m) / 2, (self.min_y_m + self.max_y_m) / 2, height_m])


@dataclass(frozen=True, slots=True, eq=False)
class ViewRegion:
    """A window of what a real or virtual camera sees: the points move with the plane along the camera's rays.

    Raises:
        ImagingError: if the window has no area.
    """

    camera: CameraModel
    pose: Pose
    window_px: tuple[float, float, float, float]
    """Smallest u and v, greatest u and v."""

    def __post_init__(self) -> None:
        _check_area(*self.window_px, "px")

    @classmethod
    def whole(cls, camera: CameraModel, pose: Pose) -> ViewRegion:
        """Return all of a view."""
        return cls(camera, pose, (-0.5, -0.5, camera.width_px - 0.5, camera.height_px - 0.5))

    def points_m(self, surface: Plane | Terrain) -> NDArray[np.float64]:
        """Return the points on a surface, shape (n, 3); NaN for rays that never meet it."""
        pixels = _lattice(*self.window_px)
        if isinstance(surface, Terrain):
            return surface.intersect(self.pose.position_enu_m, pixel_rays(pixels, self.camera, self.pose))
        return intersect_plane(pixels, self.camera, self.pose, surface)

    def centre_m(self, height_m: float) -> NDArray[np.float64]:
        """Return where the ray through the window's centre meets the plane z = height, shape (3,); NaN if nowhere."""
        left, top, right, bottom = self.window_px
        centre_px = [[(left + right) / 2, (top + bottom) / 2]]
        return np.asarray(intersect_plane(centre_px, self.camera, self.pose, height_m)[0])


def _lattice(left: float, top: float, right: float, bottom: float) -> NDArray[np.float64]:
    """Return about ``MAX_POINTS`` points evenly spread over a rectangle, shape (n, 2)."""
    width, height = right - left, bottom - top
    columns = min(max(round(math.sqrt(MAX_POINTS * width / height)), 2), MAX_POINTS // 2)
    rows = max(MAX_POINTS // columns, 2)
    u = left + (np.arange(columns) + 0.5) * (width / columns)
    v = top + (np.arange(rows) + 0.5) * (height / rows)
    return np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)


def _check_area(left: float, top: float, right: float, bottom: float, unit: str) -> None:
    if not (math.isfinite(right - left) and math.isfinite(bottom - top) and left < right and top < bottom):
        raise ImagingError(
            f"The region to focus on must span an area, got {left:g} to {right:g} and {top:g} to {bottom:g} {unit}."
        )
