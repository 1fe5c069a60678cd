"""The forest floor for operators: what all frames together show of the ground, with the canopy blurred away.

Buffered: yes, the means of all tiles that were seen, in cells so large that the whole takes at most 2 MB; when full:
all cells become twice as large.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.groundmap.tile import TILE_M, Tile, TileIndex
from aos_gcs.imaging.pictures import COLOUR_BANDS, MAX_CELLS, RasterPicture, encode_png, shade_integral

FINEST_CELLS: Final = 64
"""Cells along the edge of a tile while the map is small: of half a metre."""
READ_AT_ONCE: Final = 32
"""Tiles on the disk that are read for one picture: those of a map that goes on are shown little by little."""

Means = NDArray[np.float16]
"""Red, green, blue and temperature of a tile, shape (n, n, 4); NaN where no frame has one."""


class ForestFloor:
    """Reduced means of the tiles of a map, and the picture that they make.

    Args:
        stored: tiles on the disk, which are read as they are needed.
    """

    def __init__(self, stored: Iterable[TileIndex] = ()) -> None:
        self._means: dict[TileIndex, Means] = {}
        self._stale: set[TileIndex] = set()
        self._cells = FINEST_CELLS
        self._first: TileIndex = (0, 0)
        self._last: TileIndex = (0, 0)
        """Corners of the picture, of no meaning without tiles."""
        for index in stored:
            self.mark(index)

    @property
    def stale(self) -> frozenset[TileIndex]:
        """Tiles whose means are not known, or older than the tile."""
        return frozenset(self._stale)

    def mark(self, index: TileIndex) -> None:
        """Note that a tile has changed, or is new."""
        if not (self._stale or self._means):
            self._first = self._last = index
        self._stale.add(index)
        self._first = min(self._first[0], index[0]), min(self._first[1], index[1])
        self._last = max(self._last[0], index[0]), max(self._last[1], index[1])
        tiles = (self._last[0] - self._first[0] + 1) * (self._last[1] - self._first[1] + 1)
        while self._cells > 1 and tiles * self._cells**2 > MAX_CELLS:
            self._cells //= 2
            self._means = {each: _halved(means) for each, means in self._means.items()}

    def keep(self, index: TileIndex, tile: Tile) -> None:
        """Take the means of a tile over, if it has changed."""
        if index in self._stale:
            self._stale.discard(index)
            self._means[index] = reduced_means(tile, self._cells)

    def catch_up(self, held: Iterable[tuple[TileIndex, Tile]], read: Callable[[TileIndex], Tile]) -> None:
        """Take over the tiles in memory that have changed, and some of those on the disk.

        Args:
            held: tiles in memory.
            read: reads a tile from the disk.
        """
        for index, tile in held:
            self.keep(index, tile)
        for index in sorted(self._stale)[:READ_AT_ONCE]:
            self.keep(index, read(index))

    def picture(self) -> RasterPicture | None:
        """Return the picture ``floor``; None before the first tile.

        Colours where a frame has them, else temperatures in greys, both stretched to the contrast that is there;
        transparent where no frame has either.
        """
        if not self._means:
            return None
        (top, left), (bottom, right), n = self._first, self._last, self._cells
        values = np.full(((bottom - top + 1) * n, (right - left + 1) * n, 4), np.nan, dtype=np.float32)
        for (row, column), means in self._means.items():
            y, x = (row - top) * n, (column - left) * n
            values[y : y + n, x : x + n] = means
        return RasterPicture(
            kind="floor",
            png=encode_png(_shaded(values)),
            west_m=left * TILE_M,
            south_m=-(bottom + 1) * TILE_M,
            east_m=(right + 1) * TILE_M,
            north_m=-top * TILE_M,
        )


def reduced_means(tile: Tile, cells: int) -> Means:
    """Return the means of a tile over all frames, in fewer cells.

    Args:
        tile: tile.
        cells: number of cells along its edge; divides 128.
    """
    sums = np.dstack((tile.colour_sum, tile.thermal_sum)).astype(np.float32)
    return _ratio(sums, np.dstack((tile.colour_count, tile.thermal_count)).astype(np.float32), cells)


def _halved(means: Means) -> Means:
    """Return means in half as many cells along each edge; those without a value take no part."""
    known = ~np.isnan(means)
    sums = np.where(known, means, np.float16(0.0)).astype(np.float32)
    return _ratio(sums, known[..., [0, 3]].astype(np.float32), len(means) // 2)


def _ratio(sums: NDArray[np.float32], counts: NDArray[np.float32], cells: int) -> Means:
    """Return the ratio of sums, shape (n, n, 4), to counts of colours and temperatures, shape (n, n, 2), by blocks."""
    # Means of blocks in place of their sums: the ratio is the same.
    size = cells, cells
    total = cv2.resize(sums, size, interpolation=cv2.INTER_AREA)
    weight = cv2.resize(counts, size, interpolation=cv2.INTER_AREA)[..., [0, 0, 0, 1]]
    ratio = np.full(total.shape, np.nan, dtype=np.float32)
    np.divide(total, weight, out=ratio, where=weight > 0.0)
    largest = np.finfo(np.float16).max
    return ratio.clip(-largest, largest).astype(np.float16)


def _shaded(values: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return means, shape (H, W, 4), as RGBA, shape (H, W, 4)."""
    colours = shade_integral(values[..., :3], COLOUR_BANDS)
    lacks = np.isnan(values[..., 0])
    if np.isnan(values[..., 3][lacks]).all():
        return colours
    greys = shade_integral(values[..., 3:], ("thermal",))
    return np.where(lacks[..., np.newaxis], greys, colours)
