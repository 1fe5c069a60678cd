"""Images that the compiled kernels warp and add to the sums of a raster in one pass."""

from __future__ import annotations

import ctypes
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.model import Pixels
from aos_gcs.imaging.native import library
from aos_gcs.imaging.native.kernels import KINDS, can_warp, divide

Added = tuple[NDArray[np.uint8], bool]
"""Flag of each image, 1 if it covers anything, else 0, and whether a sum is no finite number."""


@dataclass(frozen=True, slots=True, eq=False)
class LensMap:
    """Pixels of a lens for those of its ideal camera and of a rim around them."""

    u: NDArray[np.float32]
    """Shape (H + 2 rim, W + 2 rim), contiguous; NaN where the lens images none."""
    v: NDArray[np.float32]
    """Shape and meaning as of ``u``."""
    rim_px: int
    """Width of the rim."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaneLayer:
    """An image on a plane's raster."""

    image: Pixels
    H_raster2image: NDArray[np.float64]
    """Homography from the raster's cells (column, row, 1) to pixels of the ideal camera, shape (3, 3)."""
    spans: NDArray[np.int32]
    """First column that the ideal camera covers and the one behind the last, per row of the raster, shape (rows, 2)."""
    lens: LensMap | None = None
    """None: the camera is ideal."""


@dataclass(frozen=True, slots=True, eq=False)
class PointLayer:
    """An image on a raster whose cells have one point each."""

    image: Pixels
    P: NDArray[np.float64]
    """Projection from points (x, y, z, 1) to homogeneous pixels of the ideal camera, shape (3, 4)."""
    seen_blocks: NDArray[np.bool_]
    """Blocks of 32 x 32 cells that the image may see."""
    lens: LensMap | None = None
    """None: the camera is ideal."""


class Layers(ABC):
    """Images of one type that are added together."""

    def __init__(self, compiled: ctypes.CDLL, images: Sequence[Pixels]) -> None:
        self._compiled, self._images = compiled, images
        self._kind, self._bands = KINDS[images[0].dtype], images[0].shape[2]

    def add(self, band: tuple[int, int], total: Pixels, count: NDArray[np.uint16]) -> Added:
        """Add the images to some rows.

        Args:
            band: first row and the one behind the last.
            total: their sums, float32, shape (rows, columns, bands), contiguous.
            count: their numbers of images, shape (rows, columns), contiguous.
        """
        covers = np.empty(len(self._images), dtype=np.uint8)
        return covers, bool(self._add(band, total, count, covers))

    def mean(self, band: tuple[int, int], mean: Pixels, count: NDArray[np.uint16]) -> Added:
        """Write the means of some rows, NaN where nothing covers.

        Args:
            band: see :meth:`add`.
            mean: memory of the means, as that of sums there.
            count: memory of the numbers of images.
        """
        mean[:], count[:] = 0.0, 0
        added = self.add(band, mean, count)
        divide(mean, count, mean)
        return added

    @abstractmethod
    def _add(self, band: tuple[int, int], total: Pixels, count: NDArray[np.uint16], covers: NDArray[np.uint8]) -> int:
        """Add the images, write whether they cover anything, and return whether a sum is no finite number."""


class PlaneLayers(Layers):
    """Images on the raster of a plane."""

    def __init__(self, compiled: ctypes.CDLL, layers: Sequence[PlaneLayer]) -> None:
        super().__init__(compiled, [own.image for own in layers])
        self._kept = [(np.ascontiguousarray(own.spans), own.lens) for own in layers]
        self._has_lens = any(own.lens is not None for own in layers)
        self._structures = ((_LensImage if self._has_lens else _PlaneImage) * len(layers))()
        for own, layer, (spans, lens) in zip(self._structures, layers, self._kept, strict=True):
            own.pixels, own.spans = layer.image.ctypes.data, spans.ctypes.data
            own.H = (ctypes.c_double * 9)(*layer.H_raster2image.reshape(-1))
            own.height, own.width = layer.image.shape[:2]
            if lens is not None:
                own.lens = _lens(lens)

    @classmethod
    def of(cls, layers: Sequence[PlaneLayer]) -> PlaneLayers | None:
        """Return images to be added together; None where there is no kernel for them."""
        compiled = library.loaded()
        return cls(compiled, layers) if compiled and _are_alike([own.image for own in layers]) else None

    def mean(self, band: tuple[int, int], mean: Pixels, count: NDArray[np.uint16]) -> Added:
        """See :class:`Layers`; in one pass where no image has a lens."""
        if self._has_lens:
            return super().mean(band, mean, count)
        covers = np.empty(len(self._images), dtype=np.uint8)
        return covers, bool(self._call(self._compiled.aos_mean_of_warped, band, mean, count, covers))

    def _add(self, band: tuple[int, int], total: Pixels, count: NDArray[np.uint16], covers: NDArray[np.uint8]) -> int:
        compiled = self._compiled
        add = compiled.aos_add_through_lenses if self._has_lens else compiled.aos_add_warped
        return self._call(add, band, total, count, covers)

    def _call(
        self,
        function: Callable[..., int],
        band: tuple[int, int],
        total: Pixels,
        count: NDArray[np.uint16],
        covers: NDArray[np.uint8],
    ) -> int:
        memory = total.ctypes.data, count.ctypes.data, covers.ctypes.data
        number, columns = len(self._images), count.shape[1]
        return function(self._structures, number, self._kind, self._bands, *band, columns, *memory)


class PointLayers(Layers):
    """Images on a raster whose cells have one point each."""

    def __init__(
        self,
        compiled: ctypes.CDLL,
        layers: Sequence[PointLayer],
        points_m: NDArray[np.float32],
        known: NDArray[np.uint8],
    ) -> None:
        super().__init__(compiled, [own.image for own in layers])
        self._points_m, self._known = points_m, known
        self._kept = [(np.ascontiguousarray(own.seen_blocks), own.lens) for own in layers]
        self._structures = (_PointImage * len(layers))()
        for own, layer, (seen_blocks, lens) in zip(self._structures, layers, self._kept, strict=True):
            own.pixels, own.seen_blocks = layer.image.ctypes.data, seen_blocks.ctypes.data
            if lens is not None:
                own.lens = _lens(lens)
            own.P = (ctypes.c_double * 12)(*layer.P.reshape(-1))
            own.height, own.width = layer.image.shape[:2]

    @classmethod
    def of(
        cls, layers: Sequence[PointLayer], points_m: NDArray[np.float32], known: NDArray[np.uint8]
    ) -> PointLayers | None:
        """Return images to be added together; None where there is no kernel for them.

        Args:
            layers: the images.
            points_m: points of the raster's cells, relative to the origin of the projections, shape (rows, columns,
                3), contiguous.
            known: 1 where a cell has a point, shape (rows, columns), contiguous.
        """
        compiled = library.loaded()
        if not compiled or not _are_alike([own.image for own in layers]):
            return None
        return cls(compiled, layers, points_m, known)

    def _add(self, band: tuple[int, int], total: Pixels, count: NDArray[np.uint16], covers: NDArray[np.uint8]) -> int:
        return int(
            self._compiled.aos_add_points(
                self._points_m.ctypes.data,
                self._known.ctypes.data,
                count.shape[1],
                self._structures,
                len(self._images),
                self._kind,
                self._bands,
                *band,
                total.ctypes.data,
                count.ctypes.data,
                covers.ctypes.data,
            )
        )


def _are_alike(images: Sequence[Pixels]) -> bool:
    """Tell whether there is a kernel for images, all of them together."""
    return bool(images) and all(map(can_warp, images)) and len({(own.dtype, own.shape[2]) for own in images}) == 1


class _LensMap(ctypes.Structure):
    _fields_ = (
        ("u", ctypes.c_void_p),
        ("v", ctypes.c_void_p),
        ("height", ctypes.c_int64),
        ("width", ctypes.c_int64),
        ("rim", ctypes.c_int64),
    )


def _lens(lens: LensMap) -> _LensMap:
    return _LensMap(lens.u.ctypes.data, lens.v.ctypes.data, *lens.u.shape, lens.rim_px)


_PLANE_FIELDS = (
    ("pixels", ctypes.c_void_p),
    ("spans", ctypes.c_void_p),
    ("H", ctypes.c_double * 9),
    ("height", ctypes.c_int64),
    ("width", ctypes.c_int64),
)


class _PlaneImage(ctypes.Structure):
    _fields_ = _PLANE_FIELDS


class _LensImage(ctypes.Structure):
    _fields_ = (*_PLANE_FIELDS, ("lens", _LensMap))


class _PointImage(ctypes.Structure):
    _fields_ = (
        ("pixels", ctypes.c_void_p),
        ("seen_blocks", ctypes.c_void_p),
        ("P", ctypes.c_double * 12),
        ("height", ctypes.c_int64),
        ("width", ctypes.c_int64),
        ("lens", _LensMap),
    )
