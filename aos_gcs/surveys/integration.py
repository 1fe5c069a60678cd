"""Integration of the tiles of a survey: frames are read one after the other, memory is bounded by the tiles held."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.imaging.integral import BATCH_FRAMES, ViewIntegral
from aos_gcs.imaging.model import Detector, Frame
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.trimmed import integrate_trimmed
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.imaging.workers import ahead_map, parallel_map
from aos_gcs.surveys.images import LazyFrames, read_frame
from aos_gcs.surveys.levels import add_levels, levels
from aos_gcs.surveys.model import SurveyImage
from aos_gcs.surveys.significance import AnomalySums
from aos_gcs.surveys.tiles import RasterTile, Window

TERRAIN_BYTES = 64
"""Memory per cell: its point in double and single precision, and what finding it takes."""

BATCH_BYTES = 16_000_000
"""Memory of the images that are added to a tile at once: its sums stay in the cache meanwhile."""

Advance = Callable[[int], None]
"""Function that reports a number of further images (or tiles) as done."""

Read: TypeAlias = tuple[Frame, Frame | None] | str
"""An image and its levels of anomaly, None if nothing is marked; the reason if it is broken."""


class Reading(Protocol):
    """Source of the images that tiles need."""

    def batches(self, indices: Sequence[int]) -> Iterator[list[tuple[int, Read]]]:
        """Read images in the order of their ascending indices, some at a time."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Work:
    """Data and settings for the computation of every tile; can be sent to another process."""

    images: tuple[SurveyImage, ...]
    bands: tuple[str, ...]
    surface: FocalSurface
    exact: bool = True
    """See :class:`~aos_gcs.imaging.integral.ViewIntegral`."""
    trim: float | None = None
    """None: the mean; otherwise see :func:`~aos_gcs.imaging.trimmed.integrate_trimmed`."""
    detector: Detector | None = None
    """Detector of the anomalies that are summed per cell; None: none."""
    min_score: float | None = None
    """Score of the lowest level of anomaly; None: see :func:`~aos_gcs.surveys.levels.base_score`."""
    skip_broken: bool = False
    """Leave out images that cannot be read, instead of failing."""
    max_bytes: int = 1_000_000_000
    """Largest size of the sums or values held at a time."""

    @property
    def cell_bytes(self) -> int:
        """Memory that a cell takes until its tile is done."""
        sums = 8 if self.exact else 4
        marks = 0 if self.detector is None else 6
        return len(self.bands) * (sums + 4) + 4 + marks + (TERRAIN_BYTES if isinstance(self.surface, Terrain) else 0)


@dataclass(frozen=True, slots=True, eq=False)
class TileResult:
    """A tile that is done."""

    window: Window
    integral: NDArray[np.float32]
    """Shape (rows, columns, C), NaN where nothing covers."""
    coverage: NDArray[np.uint16]
    anomalies: AnomalySums | None
    """Marks of the detector; None without one."""
    used: frozenset[int]
    """Indices of the images that cover a part of it."""
    broken: dict[int, str]
    """Reasons why images could not be read, by their indices."""


class _TileSums:
    """A tile's sums while frames come in."""

    def __init__(self, work: Work, tile: RasterTile) -> None:
        self.images = frozenset(tile.images)
        self._tile = tile
        self._view = tile.view(work.surface)
        self._integral = ViewIntegral(self._view, work.bands, exact=work.exact)
        self._anomalies = AnomalySums.none(self._view.shape) if work.detector is not None else None
        self._used: set[int] = set()

    def add(self, read: Iterable[tuple[int, Frame, Frame | None]]) -> None:
        """Add those images of a batch that may see the tile."""
        own = [one for one in read if one[0] in self.images]
        for (index, _, levels_of), covers in zip(own, self._add_frames([one[1] for one in own]), strict=True):
            if covers:
                self._used.add(index)
                if levels_of is not None and self._anomalies is not None:
                    add_levels(self._anomalies, levels_of, self._view)

    def _add_frames(self, frames: list[Frame]) -> list[bool]:
        """Add frames, and tell of each whether it covers anything: the same whatever the batch."""
        if all(frame.image.dtype.kind in "ui" for frame in frames):
            return self._integral.add_all(frames) if frames else []
        # Sums of a batch in which pixels are missing would be rounded otherwise than one after the other.
        return [self._integral.add(frame) for frame in frames]

    def result(self, broken: dict[int, str]) -> TileResult:
        integral = self._integral
        return TileResult(
            self._tile.window, integral.mean(), integral.coverage, self._anomalies, frozenset(self._used), broken
        )


def integrate_tiles(
    work: Work, tiles: Sequence[RasterTile], advance: Advance = lambda _: None, reading: Reading | None = None
) -> list[TileResult]:
    """Integrate some tiles at the same time, so that an image that several of them see is read once.

    Args:
        work: data and settings that the tiles have in common.
        tiles: to be integrated.
        advance: see :data:`Advance`.
        reading: reads their images; None: this function does. Not used where values are left out, as images are gone
            through several times then.

    Raises:
        InputDataError: if an image cannot be read, and broken ones are not skipped.
        ImagingError: if a view does not have the surface in front of it.
    """
    if work.trim is not None:
        return [_trimmed(work, tile, advance) for tile in tiles]
    sums = parallel_map(partial(_TileSums, work), tiles)
    broken: dict[int, str] = {}
    for batch in (reading or _OwnReading(work, tiles)).batches(seen_images(tiles)):
        broken |= {index: read for index, read in batch if isinstance(read, str)}
        frames = [(index, *read) for index, read in batch if not isinstance(read, str)]
        for total in sums:
            total.add(frames)
        advance(len(batch))
    return [total.result(broken) for total in sums]


def seen_images(tiles: Iterable[RasterTile]) -> list[int]:
    """Return the indices of the images that may see any of the tiles, ascending."""
    return sorted({index for tile in tiles for index in tile.images})


class _OwnReading:
    """Reads images for one process alone."""

    def __init__(self, work: Work, tiles: Sequence[RasterTile]) -> None:
        self._work = work
        self._cell_m = tiles[0].cell_m

    def batches(self, indices: Sequence[int]) -> Iterator[list[tuple[int, Read]]]:
        batch: list[tuple[int, Read]] = []
        held_bytes = 0
        read_one = partial(read_with_levels, self._work, self._cell_m)
        for index, read in zip(indices, ahead_map(read_one, indices), strict=True):
            batch.append((index, read))
            held_bytes += 0 if isinstance(read, str) else read[0].image.nbytes
            if len(batch) == BATCH_FRAMES or held_bytes >= BATCH_BYTES:
                yield batch
                batch, held_bytes = [], 0
        if batch:
            yield batch


def read_with_levels(work: Work, cell_m: float | None, index: int) -> Read:
    """Read an image, and look for its levels of anomaly where they are asked for.

    Raises:
        InputDataError: if it cannot be read, and broken ones are not skipped.
    """
    frame = _read(work, index)
    return frame if isinstance(frame, str) else (frame, _levels(work, frame, cell_m))


def _levels(work: Work, frame: Frame, cell_m: float | None) -> Frame | None:
    """Return the levels of anomaly of a frame in its place; None if nothing is marked."""
    if work.detector is None:
        return None
    return levels(frame, work.detector, work.surface, work.min_score, cell_m)


def _trimmed(work: Work, tile: RasterTile, advance: Advance) -> TileResult:
    broken: dict[int, str] = {}
    if work.skip_broken:
        # Frames are gone through several times: which of them can be read has to be known before.
        for index in tile.images:
            if isinstance(read := _read(work, index), str):
                broken[index] = read
    readable = [index for index in tile.images if index not in broken]
    view = tile.view(work.surface)
    anomalies = AnomalySums.none(view.shape) if work.detector is not None else None
    if not readable or work.trim is None:
        integral = np.full((*view.shape, len(work.bands)), np.nan, dtype=np.float32)
        return TileResult(tile.window, integral, np.zeros(view.shape, dtype=np.uint16), anomalies, frozenset(), broken)
    frames = LazyFrames([work.images[index] for index in readable], work.bands)
    integral, coverage = integrate_trimmed(frames, view, work.trim, exact=work.exact, max_bytes=work.max_bytes)
    if anomalies is not None:
        for frame in frames:
            levels_of = _levels(work, frame, tile.cell_m)
            if levels_of is not None:
                add_levels(anomalies, levels_of, view)
    advance(len(tile.images))
    used = frozenset(readable) if coverage.any() else frozenset()
    return TileResult(tile.window, integral, coverage, anomalies, used, broken)


def _read(work: Work, index: int) -> Frame | str:
    """Return an image; the reason if it is broken, and such are skipped."""
    try:
        return read_frame(work.images[index], work.bands, index)
    except InputDataError as error:
        if not work.skip_broken:
            raise
        return str(error)
