"""Integral images on a horizontal focal plane: means of all frames that cover a point (spec, section 1).

Source: Kurmi, Schedl and Bimber, *Airborne Optical Sectioning*, Journal of Imaging 4(8), 2018.
"""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import plane_to_image
from aos_gcs.imaging.focal_plane import covered_spans, visible_half_planes
from aos_gcs.imaging.model import FocalGrid, Frame, Pixels
from aos_gcs.imaging.undistort import undistorted
from aos_gcs.imaging.warp import Patch, locate, warp_image

MIN_DISTANCE_M = 1e-6
"""Of a virtual camera to the focal plane; nearer, the plane has no image."""


class GridIntegral:
    """Running sums of frames on a focal grid."""

    def __init__(self, grid: FocalGrid, channels: int) -> None:
        self.coverage = np.zeros((grid.rows, grid.columns), dtype=np.uint16)
        self._sum = np.zeros((grid.rows, grid.columns, channels), dtype=np.float32)

    def add(self, patch: Patch, warped: Pixels, covered: NDArray[np.uint8]) -> None:
        """Add one frame, as :func:`~aos_gcs.imaging.warp.warp_image` has given it."""
        self.coverage[patch.window] += covered
        cv2.accumulate(warped, self._sum[patch.window], covered)

    def mean(self) -> NDArray[np.float32]:
        """Return the integral, shape (rows, columns, C), NaN where nothing covers."""
        # Dividing by NaN marks uncovered cells at the cost of the division alone.
        divisor = np.where(self.coverage == 0, np.float32(np.nan), self.coverage.astype(np.float32))
        return np.asarray(self._sum / divisor[:, :, np.newaxis], dtype=np.float32)


def integrate_on_grid(frames: Iterable[Frame], grid: FocalGrid) -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
    """Average frames on a focal grid, with one warp per frame.

    Args:
        frames: at least one, all with the same channels; taken one after the other, so that memory does not grow with
            their number.
        grid: on the focal plane.

    Returns:
        The integral, shape (rows, columns, C), NaN where nothing covers, and the number of frames that cover each cell,
        shape (rows, columns).

    Raises:
        ImagingError: if there is no frame, or frames differ in their bands.
    """
    integral: GridIntegral | None = None
    bands: tuple[str, ...] = ()
    for frame in frames:
        if integral is None:
            integral, bands = GridIntegral(grid, frame.image.shape[2]), frame.bands
        check_frame(frame, bands)
        ideal = undistorted(frame)
        patch = locate(ideal, grid)
        if patch is not None:
            integral.add(patch, *warp_image(ideal.image, patch))
    if integral is None:
        raise ImagingError("There is no frame to integrate: give at least one.")
    return integral.mean(), integral.coverage


def integrate_view(
    frames: Iterable[Frame], virtual_camera: CameraModel, virtual_pose: Pose, plane_height_m: float
) -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
    """Average frames as a virtual camera sees them on the focal plane, with exact bilinear interpolation.

    The plane z = ``plane_height_m`` may lie on either side of the cameras, in a world with any axes.

    Args:
        frames: at least one, all with the same channels; taken one after the other, so that memory does not grow with
            their number.
        virtual_camera: its image size is that of the result.
        virtual_pose: in the world of the frames' poses.
        plane_height_m: of the focal plane.

    Returns:
        The integral, shape (H, W, C), NaN where nothing covers, and the number of frames that cover each pixel, shape
        (H, W).

    Raises:
        ImagingError: if there is no frame, frames differ in their bands, or the virtual camera does not have the plane
            in front of it.
    """
    H_view2plane = _view_to_plane(virtual_camera, virtual_pose, plane_height_m)
    shape = virtual_camera.height_px, virtual_camera.width_px
    count = np.zeros(shape, dtype=np.uint16)
    total: NDArray[np.float64] | None = None
    bands: tuple[str, ...] = ()
    for frame in frames:
        if total is None:
            total, bands = np.zeros((*shape, frame.image.shape[2])), frame.bands
        check_frame(frame, bands)
        H_view2image = plane_to_image(frame.camera, frame.pose, plane_height_m) @ H_view2plane
        rows, columns = _covered_pixels(H_view2image, H_view2plane, frame.camera, shape)
        samples = _sample(frame.image, H_view2image, rows, columns)
        finite = np.isfinite(samples).all(axis=1)
        total[rows[finite], columns[finite]] += samples[finite]
        count[rows[finite], columns[finite]] += 1
    if total is None:
        raise ImagingError("There is no frame to integrate: give at least one.")
    divisor = np.where(count == 0, np.nan, count)
    return (total / divisor[:, :, np.newaxis]).astype(np.float32), count


def check_frame(frame: Frame, bands: tuple[str, ...]) -> None:
    """Refuse a frame that does not fit its own camera or the bands of the others.

    Raises:
        ImagingError: naming the vehicle and what differs.
    """
    size = frame.camera.height_px, frame.camera.width_px
    if frame.image.ndim != 3 or frame.image.shape[:2] != size or frame.image.shape[2] != len(frame.bands):
        raise ImagingError(
            f"The image of vehicle {frame.vehicle_id} has shape {frame.image.shape}, but its camera and bands ask for "
            f"{(*size, len(frame.bands))}."
        )
    if frame.bands != bands:
        raise ImagingError(
            f"The frame of vehicle {frame.vehicle_id} has the bands {', '.join(frame.bands)}, others have "
            f"{', '.join(bands)}: only frames with the same bands can be integrated."
        )


def _view_to_plane(camera: CameraModel, pose: Pose, plane_height_m: float) -> NDArray[np.float64]:
    """Return the homography from pixels to the plane, its third coordinate positive where the plane is in front."""
    if abs(plane_height_m - float(pose.position_enu_m[2])) < MIN_DISTANCE_M:
        raise ImagingError(
            f"The focal plane z = {plane_height_m:g} m passes through the virtual camera: choose one in front of it."
        )
    # (x, y, 1) = depth · H⁻¹ (u, v, 1): the third coordinate of H⁻¹ (u, v, 1) is 1 / depth.
    H_view2plane = np.linalg.inv(plane_to_image(camera, pose, plane_height_m))
    corners = np.array([[-0.5, camera.width_px - 0.5], [-0.5, camera.height_px - 0.5]])
    inverse_depths = [H_view2plane[2] @ (u, v, 1.0) for u in corners[0] for v in corners[1]]
    if max(inverse_depths) <= 0.0:
        raise ImagingError(
            f"The focal plane z = {plane_height_m:g} m lies behind the virtual camera at "
            f"z = {float(pose.position_enu_m[2]):.1f} m: choose a plane on the side that the camera looks to."
        )
    return np.asarray(H_view2plane)


def _covered_pixels(
    H_view2image: NDArray[np.float64], H_view2plane: NDArray[np.float64], camera: CameraModel, shape: tuple[int, int]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return rows and columns of the virtual pixels whose point on the plane the camera sees."""
    half_planes = np.vstack((visible_half_planes(H_view2image, camera), H_view2plane[2]))
    spans = covered_spans(half_planes, *shape)
    columns = np.arange(shape[1])
    rows, columns = np.nonzero((columns >= spans[:, :1]) & (columns < spans[:, 1:]))
    return rows, columns


def _sample(
    image: Pixels, H_view2image: NDArray[np.float64], rows: NDArray[np.intp], columns: NDArray[np.intp]
) -> NDArray[np.float64]:
    """Return the image's channels at the virtual pixels, shape (n, C): exact bilinear, clamped at the border."""
    u, v, w = H_view2image @ np.stack((columns, rows, np.ones_like(rows)))
    coordinates = np.stack((v / w, u / w))
    # OpenCV's warps quantise the coordinate to 1/32 pixel before version 5; this one does not.
    channels = [
        map_coordinates(image[:, :, channel], coordinates, output=np.float64, order=1, mode="nearest")
        for channel in range(image.shape[2])
    ]
    return np.stack(channels, axis=1)
