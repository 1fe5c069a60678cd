"""Integral images: means of all frames that cover a point (spec, section 1).

Source: Kurmi, Schedl and Bimber, *Airborne Optical Sectioning*, Journal of Imaging 4(8), 2018.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.layers import Layer, Projection
from aos_gcs.imaging.model import FocalGrid, Frame, Pixels
from aos_gcs.imaging.views import FocalSurface, FocalView, grid_view, perspective_view
from aos_gcs.imaging.workers import parallel_map

BAND_ROWS = 128
"""Of the raster, summed up by one thread: lower bands fit into smaller caches, but cost more calls."""

BATCH_FRAMES = 8
"""Added to a band, one after the other, while its sums are in the cache; so many images are held at a time."""


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """The image of a frame, ready to be sampled."""

    image: Pixels
    """Shape (H, W, C), float32 unless exact."""
    exact: bool
    complete: bool
    """Every pixel is finite."""

    @classmethod
    def of(cls, frame: Frame, *, exact: bool) -> Source:
        """Prepare the image of a frame."""
        if exact:
            return cls(frame.image, exact=True, complete=True)
        # Bytes would be rounded to whole grey levels by every single warp, and OpenCV is hardly faster with them.
        image = np.ascontiguousarray(frame.image, dtype=np.float32)
        finite = frame.image.dtype.kind != "f" or math.isfinite(cv2.sumElems(image.reshape(image.shape[0], -1))[0])
        return cls(image, exact=False, complete=finite)

    def sample(self, projection: Projection, first_row: int, end_row: int) -> Layer | None:
        """Return the image on a band of the projection's raster; None where it covers nothing."""
        if self.exact:
            return projection.sample_exactly(self.image, first_row, end_row)
        layer = projection.sample(np.asarray(self.image, dtype=np.float32), first_row, end_row)
        return layer if layer is None or self.complete else layer.without_gaps()


class ViewIntegral:
    """Running sums of frames on a virtual raster; adding or removing a frame costs one warp."""

    def __init__(self, view: FocalView, bands: tuple[str, ...], *, exact: bool = True) -> None:
        """Begin with no frame.

        Args:
            view: see :mod:`~aos_gcs.imaging.views`.
            bands: of all frames to come.
            exact: bilinear at double precision, sums included. Otherwise OpenCV's single precision (before OpenCV 5:
                coordinates in steps of 1/32 pixel), and the way through a lens is interpolated between whole pixels.
        """
        self.coverage = np.zeros(view.shape, dtype=np.uint16)
        self._view, self._bands, self._exact = view, bands, exact
        self._sum = np.zeros((*view.shape, len(bands)), dtype=np.float64 if exact else np.float32)

    def add(self, frame: Frame) -> bool:
        """Add one frame, and tell whether it covers anything.

        Raises:
            ImagingError: if it does not fit its camera or the bands.
        """
        return self.add_all([frame])[0]

    def add_all(self, frames: Sequence[Frame]) -> list[bool]:
        """Add frames, and tell of each whether it covers anything; they are the faster, the more there are.

        Raises:
            ImagingError: if one does not fit its camera or the bands; none is added then.
        """
        for frame in frames:
            check_frame(frame, self._bands)
        projected = [(index, self._view.project(frame)) for index, frame in enumerate(frames)]
        present = [(index, projection) for index, projection in projected if projection is not None]
        sources = parallel_map(lambda item: Source.of(frames[item[0]], exact=self._exact), present)
        pairs = [(source, projection) for source, (_, projection) in zip(sources, present, strict=True)]
        per_band = parallel_map(partial(self._add_to_band, pairs), self._bands_of_rows())
        covering = {index for seen in per_band for (index, _), own in zip(present, seen, strict=True) if own}
        return [index in covering for index in range(len(frames))]

    def remove(self, frame: Frame) -> None:
        """Take away a frame that has been added; without its image and pose unchanged, the sums go wrong.

        Raises:
            ImagingError: if it cannot have been added, because cells it covers are not covered.
        """
        check_frame(frame, self._bands)
        projection = self._view.project(frame)
        if projection is None:
            return
        source = Source.of(frame, exact=self._exact)
        # In the bands that it was added in: what is taken away is then the same to the last digit.
        layers = [layer for band in self._bands_of_rows() if (layer := source.sample(projection, *band)) is not None]
        if any((self.coverage[layer.window] < layer.coverage()).any() for layer in layers):
            raise ImagingError(f"The frame of vehicle {frame.vehicle_id} is not part of the integral.")
        for layer in layers:
            self.coverage[layer.window] -= layer.coverage()
            cv2.accumulate(-layer.values, self._sum[layer.window], layer.covered)

    def mean(self) -> NDArray[np.float32]:
        """Return the integral, shape (H, W, C), NaN where nothing covers."""
        return self._divide(np.empty(self._sum.shape, dtype=np.float32))

    def take(self) -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
        """Return the integral and the coverage, and begin anew: as ``mean``, with less memory and time."""
        total, coverage = self._sum, self.coverage
        mean = self._divide(total if total.dtype == np.float32 else np.empty(total.shape, dtype=np.float32))
        self._sum, self.coverage = np.zeros(total.shape, total.dtype), np.zeros(coverage.shape, coverage.dtype)
        return mean, coverage

    def _divide(self, integral: NDArray[np.float32]) -> NDArray[np.float32]:
        parallel_map(partial(self._divide_band, integral), self._bands_of_rows())
        return integral

    def _bands_of_rows(self) -> Iterator[tuple[int, int]]:
        rows = self._view.shape[0]
        return ((first, min(first + BAND_ROWS, rows)) for first in range(0, rows, BAND_ROWS))

    def _add_to_band(self, pairs: Sequence[tuple[Source, Projection]], band: tuple[int, int]) -> list[bool]:
        covering = []
        for source, projection in pairs:
            layer = source.sample(projection, *band)
            covering.append(layer is not None and (layer.covered is None or bool(layer.covered.any())))
            if layer is not None:
                self.coverage[layer.window] += 1 if layer.covered is None else layer.covered
                cv2.accumulate(layer.values, self._sum[layer.window], layer.covered)
        return covering

    def _divide_band(self, integral: NDArray[np.float32], band: tuple[int, int]) -> None:
        rows = slice(*band)
        # Dividing by NaN marks uncovered cells at the cost of the division alone.
        divisor = np.where(self.coverage[rows] == 0, np.float32(np.nan), self.coverage[rows].astype(np.float32))
        # Written out per channel, as broadcasting along a very short axis takes three times as long.
        written_out = cv2.merge([divisor] * self._sum.shape[2]).reshape(self._sum[rows].shape)
        np.divide(self._sum[rows], written_out, out=integral[rows], casting="same_kind")


def integrate(
    frames: Iterable[Frame], view: FocalView, *, exact: bool = True
) -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
    """Average frames on a virtual raster.

    Args:
        frames: at least one, all with the same channels; taken a few at a time, so that memory does not grow with
            their number.
        view: see :mod:`~aos_gcs.imaging.views`.
        exact: see :class:`ViewIntegral`.

    Returns:
        The integral, shape (H, W, C), NaN where nothing covers, and the number of frames that cover each pixel, shape
        (H, W).

    Raises:
        ImagingError: if there is no frame, or frames differ in their bands.
    """
    remaining = iter(frames)
    batch = list(islice(remaining, BATCH_FRAMES))
    if not batch:
        raise ImagingError("There is no frame to integrate: give at least one.")
    integral = ViewIntegral(view, batch[0].bands, exact=exact)
    while batch:
        integral.add_all(batch)
        # Emptied before it is filled again, so that no more than one batch is held.
        batch.clear()
        batch.extend(islice(remaining, BATCH_FRAMES))
    return integral.take()


def integrate_on_grid(frames: Iterable[Frame], grid: FocalGrid) -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
    """Average frames on a focal grid, see :func:`integrate`; not exact.

    Raises:
        ImagingError: if there is no frame, or frames differ in their bands.
    """
    return integrate(frames, grid_view(grid), exact=False)


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
