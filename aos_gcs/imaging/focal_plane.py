"""Footprints of frames on a horizontal focal plane, and the raster that holds them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import Plane, as_plane, intersect_plane, plane_to_image
from aos_gcs.imaging.model import FocalGrid, Viewpoint
from aos_gcs.imaging.native import kernels

MAX_DEPTH_RATIO = 5.0
"""Rays that meet the plane at more than this multiple of the camera's distance to it are not used.

At 78 degrees off nadir a pixel covers 25 times the ground of one at nadir; beyond lies the horizon.
"""

DEFAULT_MAX_CELLS = 4_000_000
"""100 vehicles in a line at 4.2 m spacing, 35 m above the plane, still have cells as fine as their pixels."""


def grid_to_plane(grid: FocalGrid) -> NDArray[np.float64]:
    """Return the affine map, shape (3, 3), from cells (column, row, 1), centres at integers, to (x, y, 1) in metres."""
    half = grid.resolution_m / 2
    return np.array(
        [
            [grid.resolution_m, 0.0, grid.west_m + half],
            [0.0, -grid.resolution_m, grid.north_m - half],
            [0.0, 0.0, 1.0],
        ]
    )


def grid_to_image(grid: FocalGrid, camera: CameraModel, pose: Pose) -> NDArray[np.float64]:
    """Return the homography, shape (3, 3), from cells (column, row, 1) to pixels; its third coordinate is the depth."""
    return plane_to_image(camera, pose, grid.height_m) @ grid_to_plane(grid)


def footprint(camera: CameraModel, pose: Pose, plane: Plane | float) -> NDArray[np.float64]:
    """Return the convex outline of what the camera sees of the plane: points (x, y), shape (k, 2), metres.

    It is cut off where rays meet the plane beyond ``MAX_DEPTH_RATIO``, and empty when the plane is not in front of the
    camera. A distorted lens sees a little less than its outline, which is that of its ideal camera.
    """
    camera, plane = camera.ideal(), as_plane(plane)
    right, bottom = camera.width_px - 0.5, camera.height_px - 0.5
    corners = np.array([[-0.5, -0.5, 1.0], [right, -0.5, 1.0], [right, bottom, 1.0], [-0.5, bottom, 1.0]])
    # A ray's depth at the plane is gap / (n · d), with n · d linear in the pixel: the limit cuts the image with a line.
    side = np.sign(plane.gap_m(pose.position_enu_m))
    line = side * (plane.normal @ pose.R_cam2enu @ np.linalg.inv(camera.K)) - [0.0, 0.0, 1.0 / MAX_DEPTH_RATIO]
    outline_px = _clip_convex(corners, line)
    return intersect_plane(outline_px[:, :2], camera, pose, plane)[:, :2]


def visible_half_planes(
    H_raster2image: NDArray[np.float64], camera: CameraModel, max_depth_m: float = math.inf
) -> NDArray[np.float64]:
    """Return the rows l, shape (k, 3), whose l · (column, row, 1) >= 0 together say that the camera sees a raster cell.

    A frame covers a point when its image coordinate, divided by the image size, lies in [0, 1] on both axes, and the
    point lies in front of the camera, not deeper than ``max_depth_m``. The homography's third coordinate must be a
    depth in metres, or a positive multiple of it where ``max_depth_m`` is infinite.
    """
    u, v, depth = H_raster2image
    lines = [
        u + 0.5 * depth,
        (camera.width_px - 0.5) * depth - u,
        v + 0.5 * depth,
        (camera.height_px - 0.5) * depth - v,
        # Positive depth needs no line of its own: it is the sum of the first two.
    ]
    if math.isfinite(max_depth_m):
        lines.append(np.array([0.0, 0.0, max_depth_m]) - depth)
    return np.stack(lines)


def covered_spans(half_planes: NDArray[np.float64], rows: int, columns: int) -> NDArray[np.int32]:
    """Return the first column inside all half-planes and the one behind the last, per row, shape (rows, 2).

    The intersection of half-planes is convex, so that a row has one span; an empty span has last <= first.
    """
    compiled = kernels.covered_spans(half_planes, rows, columns)
    if compiled is not None:
        return compiled
    a, b, d = half_planes.T[:, :, np.newaxis]
    level = b * np.arange(rows) + d
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        crossing = -level / a
    slope = half_planes[:, 0]
    lower = crossing[slope > 0.0].max(axis=0, initial=0.0)
    upper = crossing[slope < 0.0].min(axis=0, initial=columns - 1.0)
    lower[(level[slope == 0.0] < 0.0).any(axis=0)] = columns
    first = np.ceil(np.minimum(lower, columns))
    end = np.floor(np.maximum(upper, -1.0)) + 1.0
    return np.stack((first, np.maximum(first, end)), axis=1).astype(np.int32)


def choose_grid(
    frames: Sequence[Viewpoint],
    plane_height_m: float,
    resolution_m: float | None = None,
    max_cells: int = DEFAULT_MAX_CELLS,
) -> FocalGrid:
    """Return the raster that bounds what all frames see of the plane.

    Args:
        frames: at least one.
        plane_height_m: ENU height of the focal plane.
        resolution_m: edge of a cell; if None, the finest ground sampling distance of all frames.
        max_cells: the resolution is coarsened until the raster has no more cells than this.

    Raises:
        ImagingError: if no frame sees the plane.
    """
    outlines = [footprint(frame.camera, frame.pose, plane_height_m) for frame in frames]
    seen = [(frame, outline) for frame, outline in zip(frames, outlines, strict=True) if len(outline)]
    if not seen:
        lowest_m = min((float(frame.pose.position_enu_m[2]) for frame in frames), default=math.nan)
        raise ImagingError(
            f"No camera has the focal plane at a height of {plane_height_m:g} m in front of it (the lowest camera is "
            f"at {lowest_m:.1f} m): choose a plane below the cameras and point them towards the ground."
        )
    points = np.concatenate([outline for _, outline in seen])
    (west, south), (east, north) = points.min(axis=0), points.max(axis=0)
    if resolution_m is None:
        resolution_m = min(finest_sampling_m(frame.camera, frame.pose, plane_height_m, line) for frame, line in seen)
    resolution_m = max(resolution_m, _coarsest_needed_m(east - west, north - south, max_cells))
    # Edges at multiples of the resolution keep the cells of successive steps in place.
    first_column, first_row = math.floor(west / resolution_m), math.ceil(north / resolution_m)
    return FocalGrid(
        west_m=first_column * resolution_m,
        north_m=first_row * resolution_m,
        resolution_m=resolution_m,
        rows=max(1, first_row - math.floor(south / resolution_m)),
        columns=max(1, math.ceil(east / resolution_m) - first_column),
        height_m=plane_height_m,
    )


def finest_sampling_m(camera: CameraModel, pose: Pose, plane: Plane | float, outline_m: NDArray[np.float64]) -> float:
    """Return the smallest ground sampling distance within a footprint: the root of the area that one pixel covers."""
    H = plane_to_image(camera, pose, plane)
    nearest_m = float((outline_m @ H[2, :2] + H[2, 2]).min())
    # A homography H scales areas by det(H) / w³ where w is its third coordinate.
    return math.sqrt(nearest_m**3 / abs(float(np.linalg.det(H))))


def _coarsest_needed_m(width_m: float, height_m: float, max_cells: int) -> float:
    # Two cells per axis are lost to rounding the edges outwards: (w / r + 2) (h / r + 2) <= n, solved for 1 / r.
    b, c = 2.0 * (width_m + height_m), 4.0 - max_cells
    per_m = (-b + math.sqrt(b * b - 4.0 * width_m * height_m * c)) / (2.0 * width_m * height_m)
    return 1.0 / per_m


def _clip_convex(polygon: NDArray[np.float64], line: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the part of a polygon of homogeneous points, shape (k, 3), with line · point >= 0 (Sutherland-Hodgman)."""
    sides = (polygon @ line).tolist()
    clipped = []
    for point, side, following, following_side in zip(
        polygon, sides, [*polygon[1:], *polygon[:1]], [*sides[1:], *sides[:1]], strict=True
    ):
        if side >= 0.0:
            clipped.append(point)
        if (side >= 0.0) != (following_side >= 0.0):
            clipped.append(point + (following - point) * (side / (side - following_side)))
    return np.array(clipped).reshape(-1, 3)
