"""Integral images: means of all frames that cover a point (spec, section 1).

Source: Kurmi, Schedl and Bimber, *Airborne Optical Sectioning*, Journal of Imaging 4(8), 2018.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence, Sized
from functools import partial
from itertools import islice
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.imaging.model import Frame, Pixels, Viewpoint
from aos_gcs.imaging.native.kernels import divide
from aos_gcs.imaging.native.layers import Layers, LensMap, PlaneLayer, PlaneLayers, PointLayer, PointLayers
from aos_gcs.imaging.points import PointProjection
from aos_gcs.imaging.undistort import RIM_PX, lens_map
from aos_gcs.imaging.views import FocalView
from aos_gcs.imaging.warp import PlaneProjection
from aos_gcs.imaging.warped import Projection, sample
from aos_gcs.imaging.workers import parallel_map

BAND_ROWS = 128
"""Rows of the raster that one thread sums up: lower bands fit into smaller caches, but cost more calls."""

BATCH_FRAMES = 10
"""Frames that are added to a band, one after the other, while its sums are in the cache, and held at a time."""

Projected: TypeAlias = tuple[Pixels, Projection | None]
"""An image, and where it lies on the raster."""


class ViewIntegral:
    """Running sums of frames on a virtual raster; adding or removing a frame costs one warp."""

    def __init__(self, view: FocalView, bands: tuple[str, ...], *, exact: bool = True) -> None:
        """Begin with no frame.

        Args:
            view: see :mod:`~aos_gcs.imaging.views`.
            bands: bands of all frames to come.
            exact: bilinear at double precision, sums included. Otherwise OpenCV's single precision (before OpenCV 5:
                coordinates in steps of 1/32 pixel), and the map of a lens is interpolated between whole pixels.
        """
        self.coverage = np.zeros(view.shape, dtype=np.uint16)
        self._view, self._bands, self._exact = view, bands, exact
        self._sum = np.zeros((*view.shape, len(bands)), dtype=np.float64 if exact else np.float32)
        self._is_empty = True

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
        projected = [(frame.image, self._view.project(frame)) for frame in frames]
        layers = None if self._exact else _layers(projected, self._view)
        gapless = all(_is_finite(frame.image, look=not self._is_empty) for frame in frames)
        per_band = parallel_map(
            partial(self._add_to_band, projected, layers, gapless=gapless), _bands_of_rows(self._view)
        )
        self._is_empty = False
        return [any(seen) for seen in zip(*per_band, strict=True)]

    def remove(self, frame: Frame) -> None:
        """Take away a frame that has been added; without its image and pose unchanged, the sums go wrong.

        Raises:
            ImagingError: if it cannot have been added, because cells it covers are not covered.
        """
        check_frame(frame, self._bands)
        projected = [(frame.image, self._view.project(frame))]
        layers = None if self._exact else _layers(projected, self._view)
        gapless = _is_finite(frame.image, look=False)
        # In the bands that it was added in: what is taken away is then the same to the last digit.
        own = [
            (slice(*band), *self._sums_of_band(projected, layers, band, gapless=gapless)[:2])
            for band in _bands_of_rows(self._view)
        ]
        if any((self.coverage[rows] < count).any() for rows, _, count in own):
            raise ImagingError(f"The frame of vehicle {frame.vehicle_id} is not part of the integral.")
        for rows, total, count in own:
            self.coverage[rows] -= count
            self._sum[rows] -= total

    def mean(self) -> NDArray[np.float32]:
        """Return the integral, shape (H, W, C), NaN where nothing covers."""
        return self._divide(np.empty(self._sum.shape, dtype=np.float32))

    def take(self) -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
        """Return the integral and the coverage, and begin anew: as ``mean``, with less memory and time."""
        total, coverage = self._sum, self.coverage
        mean = self._divide(total if total.dtype == np.float32 else np.empty(total.shape, dtype=np.float32))
        self._sum, self.coverage = np.zeros(total.shape, total.dtype), np.zeros(coverage.shape, coverage.dtype)
        self._is_empty = True
        return mean, coverage

    def _divide(self, integral: NDArray[np.float32]) -> NDArray[np.float32]:
        parallel_map(partial(self._divide_band, integral), _bands_of_rows(self._view))
        return integral

    def _add_to_band(
        self, projected: Sequence[Projected], layers: Layers | None, band: tuple[int, int], *, gapless: bool
    ) -> list[bool]:
        """Add images to a band of rows, and tell of each whether it covers anything there."""
        rows = slice(*band)
        if self._is_empty or gapless:
            sums = self._sum[rows], self.coverage[rows]
            return self._sums_of_band(projected, layers, band, sums, gapless=gapless)[2]
        total, count, covering = self._sums_of_band(projected, layers, band, gapless=gapless)
        self._sum[rows] += total
        self.coverage[rows] += count
        return covering

    def _sums_of_band(
        self,
        projected: Sequence[Projected],
        layers: Layers | None,
        band: tuple[int, int],
        sums: tuple[Pixels, NDArray[np.uint16]] | None = None,
        *,
        gapless: bool,
    ) -> tuple[Pixels, NDArray[np.uint16], list[bool]]:
        """Return sums and numbers of images in a band of rows, and of each image whether it covers anything there.

        Args:
            projected: the images.
            layers: see :func:`_layers`.
            band: first row and the one behind the last.
            sums: sums and numbers of images to which these are added, all 0 unless these are gapless; None: new ones.
            gapless: the images are known to be finite everywhere.
        """
        rows = slice(*band)
        total, count = sums or (np.zeros_like(self._sum[rows]), np.zeros_like(self.coverage[rows]))
        if layers is None:
            covering = [self._add_layer(own, band, total, count, leave_out_gaps=False) for own in projected]
            # Few images have gaps: to look for them in the sums costs less than in every image.
            with_gaps = not gapless and not math.isfinite(cv2.sumElems(total.reshape(total.shape[0], -1))[0])
        else:
            covers, has_gaps = layers.add(band, total, count)
            covering, with_gaps = [bool(own) for own in covers], has_gaps and not gapless
        if with_gaps:
            total[:], count[:] = 0, 0
            covering = [self._add_layer(own, band, total, count, leave_out_gaps=True) for own in projected]
        return total, count, covering

    def _add_layer(
        self,
        projected: Projected,
        band: tuple[int, int],
        total: Pixels,
        count: NDArray[np.uint16],
        *,
        leave_out_gaps: bool,
    ) -> bool:
        """Add an image to the sums and the coverage of a band of rows, and tell whether it covers anything there."""
        image, projection = projected
        warped = None if projection is None else sample(image, projection, *band, exact=self._exact)
        if warped is None:
            return False
        if leave_out_gaps:
            warped = warped.without_gaps()
        window = slice(warped.window[0].start - band[0], warped.window[0].stop - band[0]), warped.window[1]
        count[window] += 1 if warped.covered is None else warped.covered
        cv2.accumulate(warped.values, total[window], warped.covered)
        return warped.covered is None or bool(warped.covered.any())

    def _divide_band(self, integral: NDArray[np.float32], band: tuple[int, int]) -> None:
        rows = slice(*band)
        if divide(self._sum[rows], self.coverage[rows], integral[rows]):
            return
        # Dividing by NaN marks uncovered cells. A table of rows of equal numbers, as broadcasting along a very short
        # axis takes three times as long.
        divisors = np.arange(int(self.coverage[rows].max()) + 1, dtype=np.float32)
        divisors[0] = np.nan
        table = np.repeat(divisors[:, np.newaxis], self._sum.shape[2], axis=1)
        np.divide(self._sum[rows], np.take(table, self.coverage[rows], axis=0), out=integral[rows], casting="same_kind")


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
    if len(batch) < BATCH_FRAMES or (isinstance(frames, Sized) and len(frames) == len(batch)):
        return integrate_batch(batch, view, exact=exact)
    integral = ViewIntegral(view, batch[0].bands, exact=exact)
    while batch:
        integral.add_all(batch)
        # Emptied before it is filled again, so that no more than one batch is held.
        batch.clear()
        batch.extend(islice(remaining, BATCH_FRAMES))
    return integral.take()


def integrate_batch(
    frames: Sequence[Frame], view: FocalView, *, exact: bool = True
) -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
    """Return what :func:`integrate` does, of a few frames that are held all at once: in one pass where it can be."""
    bands = frames[0].bands
    if not exact:
        for frame in frames:
            check_frame(frame, bands)
        layers = _layers([(frame.image, view.project(frame)) for frame in frames], view)
        if layers is not None:
            mean, coverage = np.empty((*view.shape, len(bands)), np.float32), np.empty(view.shape, np.uint16)
            if not any(parallel_map(partial(_mean_of_band, layers, mean, coverage), _bands_of_rows(view))):
                return mean, coverage
    integral = ViewIntegral(view, bands, exact=exact)
    integral.add_all(frames)
    return integral.take()


def _mean_of_band(
    layers: Layers, mean: NDArray[np.float32], coverage: NDArray[np.uint16], band: tuple[int, int]
) -> bool:
    """Write means and numbers of images of a band of rows, and tell whether images have gaps there."""
    rows = slice(*band)
    return layers.mean(band, mean[rows], coverage[rows])[1]


def _layers(projected: Sequence[Projected], view: FocalView) -> Layers | None:
    """Return images for the kernel that adds all at once; None where there is none for them."""
    if any(isinstance(projection, PointProjection) for _, projection in projected):
        return _point_layers(projected)
    layers = []
    for image, projection in projected:
        if projection is None:
            layers.append(PlaneLayer(image, np.eye(3), np.zeros((view.shape[0], 2), dtype=np.int32)))
        elif isinstance(projection, PlaneProjection):
            lens = _lens(projection.camera)
            layers.append(PlaneLayer(image, projection.H_raster2image, projection.spans, lens))
        else:
            return None
    return PlaneLayers.of(layers)


def _point_layers(projected: Sequence[Projected]) -> Layers | None:
    seen = [own for _, own in projected if isinstance(own, PointProjection)]
    points, nothing = seen[0].points, np.zeros_like(seen[0].seen_blocks)
    layers = []
    for image, projection in projected:
        if isinstance(projection, PointProjection):
            layers.append(PointLayer(image, projection.P, projection.seen_blocks, _lens(projection.camera)))
        else:
            layers.append(PointLayer(image, np.eye(3, 4), nothing))
    return PointLayers.of(layers, points.points32_m, points.known)


def _lens(camera: CameraModel) -> LensMap | None:
    return None if camera.distortion is None else LensMap(*lens_map(camera), RIM_PX)


def _is_finite(image: Pixels, *, look: bool) -> bool:
    """Tell whether an image is known to be finite everywhere: integers are; others only if they are looked at."""
    return image.dtype.kind in "ui" or (look and math.isfinite(cv2.sumElems(image.reshape(image.shape[0], -1))[0]))


def _bands_of_rows(view: FocalView) -> Iterator[tuple[int, int]]:
    rows = view.shape[0]
    return ((first, min(first + BAND_ROWS, rows)) for first in range(0, rows, BAND_ROWS))


def check_frame(frame: Frame, bands: tuple[str, ...]) -> None:
    """Refuse a frame that does not fit its own camera or the bands of the others.

    Raises:
        ImagingError: naming the vehicle and what differs.
    """
    check_shape(frame, frame.image.shape, bands)


def check_shape(view: Viewpoint, shape: tuple[int, ...], bands: tuple[str, ...]) -> None:
    """Refuse a frame whose image has a shape that does not fit, as :func:`check_frame`."""
    expected = view.camera.height_px, view.camera.width_px, len(view.bands)
    if shape != expected:
        raise ImagingError(
            f"The image of vehicle {view.vehicle_id} has shape {shape}, but its camera and bands ask for {expected}."
        )
    if view.bands != bands:
        raise ImagingError(
            f"The frame of vehicle {view.vehicle_id} has the bands {', '.join(view.bands)}, others have "
            f"{', '.join(bands)}: only frames with the same bands can be integrated."
        )
