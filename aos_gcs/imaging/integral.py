"""Integral images: means of all frames that cover a point (spec, section 1).

Source: Kurmi, Schedl and Bimber, *Airborne Optical Sectioning*, Journal of Imaging 4(8), 2018.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.model import FocalGrid, Frame, Pixels
from aos_gcs.imaging.undistort import undistorted
from aos_gcs.imaging.views import FocalSurface, FocalView, perspective_view
from aos_gcs.imaging.warp import Patch, locate, warp_image


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
        return _mean(self._sum, self.coverage)


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


class ViewIntegral:
    """Running sums of frames on a virtual raster; adding or removing a frame costs one warp."""

    def __init__(self, view: FocalView, bands: tuple[str, ...], *, exact: bool = True) -> None:
        """Begin with no frame.

        Args:
            view: see :func:`~aos_gcs.imaging.views.perspective_view` and :func:`~aos_gcs.imaging.views.ortho_view`.
            bands: of all frames to come.
            exact: see :class:`~aos_gcs.imaging.views.FocalView`; sums are then of double precision, too.
        """
        self.coverage = np.zeros(view.shape, dtype=np.uint16)
        self._view, self._bands, self._exact = view, bands, exact
        self._sum = np.zeros((*view.shape, len(bands)), dtype=np.float64 if exact else np.float32)

    def add(self, frame: Frame) -> bool:
        """Add one frame, and tell whether it covers anything.

        Raises:
            ImagingError: if it does not fit its camera or the bands.
        """
        check_frame(frame, self._bands)
        layer = self._view.warp(frame, exact=self._exact)
        if layer is None:
            return False
        self.coverage[layer.window] += layer.covered
        cv2.accumulate(layer.values, self._sum[layer.window], layer.covered)
        return bool(layer.covered.any())

    def remove(self, frame: Frame) -> None:
        """Take away a frame that has been added; without its image and pose unchanged, the sums go wrong.

        Raises:
            ImagingError: if it cannot have been added, because cells it covers are not covered.
        """
        check_frame(frame, self._bands)
        layer = self._view.warp(frame, exact=self._exact)
        if layer is None:
            return
        if (self.coverage[layer.window] < layer.covered).any():
            raise ImagingError(f"The frame of vehicle {frame.vehicle_id} is not part of the integral.")
        self.coverage[layer.window] -= layer.covered
        self._sum[layer.window] -= np.where(layer.covered[:, :, np.newaxis] > 0, layer.values, 0)

    def mean(self) -> NDArray[np.float32]:
        """Return the integral, shape (H, W, C), NaN where nothing covers."""
        return _mean(self._sum, self.coverage)


def integrate(
    frames: Iterable[Frame], view: FocalView, *, exact: bool = True
) -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
    """Average frames on a virtual raster.

    Args:
        frames: at least one, all with the same channels; taken one after the other, so that memory does not grow with
            their number.
        view: see :func:`~aos_gcs.imaging.views.perspective_view` and :func:`~aos_gcs.imaging.views.ortho_view`.
        exact: see :class:`~aos_gcs.imaging.views.FocalView`.

    Returns:
        The integral, shape (H, W, C), NaN where nothing covers, and the number of frames that cover each pixel, shape
        (H, W).

    Raises:
        ImagingError: if there is no frame, or frames differ in their bands.
    """
    integral: ViewIntegral | None = None
    for frame in frames:
        if integral is None:
            integral = ViewIntegral(view, frame.bands, exact=exact)
        integral.add(frame)
    if integral is None:
        raise ImagingError("There is no frame to integrate: give at least one.")
    return integral.mean(), integral.coverage


def integrate_view(
    frames: Iterable[Frame],
    virtual_camera: CameraModel,
    virtual_pose: Pose,
    surface: FocalSurface | float,
    *,
    exact: bool = True,
) -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
    """Average frames as a virtual camera sees them on a focal surface, see :func:`integrate`.

    Args:
        frames: see :func:`integrate`.
        virtual_camera: its image size is that of the result.
        virtual_pose: in the world of the frames' poses, which may have any axes; the surface may lie on either side.
        surface: a plane, a terrain, or the height of a horizontal plane.
        exact: see :class:`~aos_gcs.imaging.views.FocalView`.

    Raises:
        ImagingError: if there is no frame, frames differ in their bands, or the virtual camera does not have the
            surface in front of it.
    """
    return integrate(frames, perspective_view(virtual_camera, virtual_pose, surface), exact=exact)


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


def _mean(total: NDArray[np.floating[Any]], coverage: NDArray[np.uint16]) -> NDArray[np.float32]:
    # Dividing by NaN marks uncovered cells at the cost of the division alone.
    divisor = np.where(coverage == 0, np.float32(np.nan), coverage.astype(np.float32))
    return np.asarray(total / divisor[:, :, np.newaxis], dtype=np.float32)
