"""Pyramids of tiles: the finest zoom from the pictures themselves, every coarser one from the four tiles below it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Final, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.basemaps.archive import TileArchive, TileFormat
from aos_gcs.basemaps.mercator import TILE_PX, WorldBox, zoom_of
from aos_gcs.errors import InputDataError

Rgba = NDArray[np.uint8]
"""A tile's pixels: red, green, blue, opacity; shape (256, 256, 4)."""
Advance = Callable[[int], None]

MAX_TILES: Final = 500_000
"""Greatest number of tiles of the finest zoom."""
KIND: Final = TileFormat.WEBP

_QUALITY = 85
_COARSER = 3
"""Number of zooms beyond the one at which the map is about as wide as one tile, for a look from far away."""


class TileSource(Protocol):
    """A picture of the ground."""

    @property
    def box(self) -> WorldBox:
        """Extent on the map of the world."""
        ...

    @property
    def pixel(self) -> float:
        """Width of its pixels as a share of the world's."""
        ...

    def tile(self, zoom: int, column: int, row: int) -> Rgba | None:
        """Return its pixels in a tile; None if it has none there.

        Raises:
            InputDataError: its file cannot be read any more.
        """
        ...


class Pyramid:
    """Tiles of several sources, of which later ones lie on top of earlier ones."""

    def __init__(self, sources: Sequence[TileSource], max_zoom: int | None = None) -> None:
        """Choose the zooms.

        Args:
            sources: pictures, at least one.
            max_zoom: finest zoom; None: that of the finest picture.

        Raises:
            InputDataError: there would be too many tiles.
        """
        self._sources = tuple(sources)
        self.box = self._sources[0].box
        for source in self._sources[1:]:
            self.box = self.box.joined(source.box)
        self.max_zoom = max(zoom_of(source.pixel) for source in sources) if max_zoom is None else max_zoom
        widest = max(self.box.east - self.box.west, self.box.south - self.box.north)
        self.min_zoom = max(0, min(self.max_zoom, zoom_of(widest / TILE_PX) - _COARSER))
        self.count = self._count()
        """Number of tiles of the finest zoom."""

    def write(self, archive: TileArchive, advance: Advance) -> None:
        """Render all tiles into an archive.

        Args:
            archive: takes them.
            advance: is told the tiles of the finest zoom that are done.

        Raises:
            InputDataError: a file cannot be read any more, or there is nothing to be seen in any.
        """
        for row, column in self._places(self.min_zoom):
            self._render(archive, advance, (self.min_zoom, column, row))
        if archive.tiles == 0:
            raise InputDataError("The files have no visible pixels: a map would be empty.")

    def _count(self) -> int:
        count = 0
        for columns, rows in (source.box.tiles(self.max_zoom) for source in self._sources):
            count += len(columns) * len(rows)
        if count > MAX_TILES:
            raise InputDataError(
                f"A map to zoom {self.max_zoom} would have {count:,} tiles; {MAX_TILES:,} are allowed: give a smaller "
                "--max-zoom, or fewer files."
            )
        return sum(1 for _ in self._finest(self.min_zoom, self._places(self.min_zoom)))

    def _finest(self, zoom: int, places: Iterator[tuple[int, int]]) -> Iterator[tuple[int, int]]:
        """Yield the tiles of the finest zoom below some tiles."""
        for row, column in places:
            if not any(source.box.meets(zoom, column, row) for source in self._sources):
                continue
            if zoom == self.max_zoom:
                yield row, column
            else:
                yield from self._finest(zoom + 1, _children(row, column))

    def _places(self, zoom: int) -> Iterator[tuple[int, int]]:
        columns, rows = self.box.tiles(zoom)
        return ((row, column) for row in rows for column in columns)

    def _render(self, archive: TileArchive, advance: Advance, place: tuple[int, int, int]) -> Rgba | None:
        """Render a tile and all below it; at most four tiles of each zoom are in memory at a time."""
        zoom, column, row = place
        sources = [source for source in self._sources if source.box.meets(zoom, column, row)]
        if not sources:
            return None
        if zoom == self.max_zoom:
            pixels = _composed(source.tile(zoom, column, row) for source in sources)
            advance(1)
        else:
            below = [self._render(archive, advance, (zoom + 1, x, y)) for y, x in _children(row, column)]
            pixels = _merged(below)
        if pixels is not None:
            archive.add(zoom, column, row, _encoded(pixels))
        return pixels


def _children(row: int, column: int) -> Iterator[tuple[int, int]]:
    return ((2 * row + down, 2 * column + right) for down in (0, 1) for right in (0, 1))


def _composed(layers: Iterator[Rgba | None]) -> Rgba | None:
    """Return pictures on top of one another, None if nothing is to be seen."""
    composed: Rgba | None = None
    for layer in layers:
        if layer is None or not layer[..., 3].any():
            continue
        composed = layer if composed is None else _over(layer, composed)
    return composed


def _over(upper: Rgba, lower: Rgba) -> Rgba:
    """Return one picture on top of another: by their colours times opacities, as Porter and Duff (1984) do."""
    above, below = upper.astype(np.float32) / 255.0, lower.astype(np.float32) / 255.0
    share = below[..., 3:] * (1.0 - above[..., 3:])
    opacity = above[..., 3:] + share
    colour = (above[..., :3] * above[..., 3:] + below[..., :3] * share) / np.maximum(opacity, 1e-6)
    return np.asarray(np.rint(np.concatenate((colour, opacity), axis=-1) * 255.0), dtype=np.uint8)


def _merged(below: Sequence[Rgba | None]) -> Rgba | None:
    """Return four neighbouring tiles as one of half the resolution; what is transparent lends no colour."""
    if all(tile is None for tile in below):
        return None
    empty = np.zeros((TILE_PX, TILE_PX, 4), dtype=np.uint8)
    north_west, north_east, south_west, south_east = (empty if tile is None else tile for tile in below)
    whole = np.vstack((np.hstack((north_west, north_east)), np.hstack((south_west, south_east)))).astype(np.float32)
    whole[..., :3] *= whole[..., 3:] / 255.0
    half = np.asarray(cv2.resize(whole, (TILE_PX, TILE_PX), interpolation=cv2.INTER_AREA), dtype=np.float32)
    half[..., :3] /= np.maximum(half[..., 3:] / 255.0, 1e-3)
    return np.asarray(np.rint(half.clip(0.0, 255.0)), dtype=np.uint8)


def _encoded(pixels: Rgba) -> bytes:
    coded = cv2.cvtColor(pixels, cv2.COLOR_RGBA2BGRA)
    return cv2.imencode(".webp", coded, [cv2.IMWRITE_WEBP_QUALITY, _QUALITY])[1].tobytes()
