"""MBTiles files, whose tiles are copied as they are.

Source: MBTiles Specification 1.3.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from aos_gcs.basemaps.archive import TileArchive, TileFormat
from aos_gcs.basemaps.mercator import WorldBox, from_degrees
from aos_gcs.basemaps.pyramid import Advance
from aos_gcs.errors import InputDataError

_KINDS = {
    "png": TileFormat.PNG,
    "jpg": TileFormat.JPEG,
    "jpeg": TileFormat.JPEG,
    "webp": TileFormat.WEBP,
    "pbf": TileFormat.VECTOR,
}
_GZIP = b"\x1f\x8b"
_MAX_TILE_BYTES = 8 * 1024 * 1024


class TileDatabase:
    """An MBTiles file."""

    def __init__(self, connection: sqlite3.Connection, path: Path) -> None:
        """Read what the file says of itself.

        Raises:
            InputDataError: it is no MBTiles file, is empty, or holds tiles of a kind that the page does not show.
        """
        self._connection, self._path = connection, path
        self._metadata = {str(name): str(value) for name, value in self._rows("SELECT name, value FROM metadata")}
        stated = self._metadata.get("format", "")
        if stated not in _KINDS:
            raise InputDataError(
                f"{path} holds tiles of the kind {stated or 'unknown'!r}, not one of {', '.join(_KINDS)}."
            )
        self.kind = _KINDS[stated]
        ((self.count,),) = self._rows("SELECT count(*) FROM tiles")
        """Number of its tiles."""
        if self.count == 0:
            raise InputDataError(f"{path} holds no tiles.")

    def copy_to(self, archive: TileArchive, advance: Advance) -> None:
        """Copy all tiles and what is said of them."""
        is_gzipped = False
        for zoom, column, row, content in self._rows("SELECT zoom_level, tile_column, tile_row, tile_data FROM tiles"):
            tile, number = bytes(content), (1 << zoom) - 1 - row  # rows count from the south
            if len(tile) > _MAX_TILE_BYTES or not (
                0 <= zoom <= 24 and 0 <= column < 1 << zoom and 0 <= number < 1 << zoom
            ):
                raise InputDataError(f"{self._path}: the tile {zoom}/{column}/{row} is damaged.")
            is_gzipped = is_gzipped or tile.startswith(_GZIP)
            archive.add(zoom, column, number, tile)
            advance(1)
        archive.finish(self.kind, self._box(), self._described(), is_gzipped=is_gzipped)

    def _box(self) -> WorldBox:
        """Return the extent that the file states, else that of its finest tiles."""
        try:
            west, south, east, north = map(float, self._metadata["bounds"].split(","))
        except (KeyError, ValueError):
            return self._box_of_tiles()
        x, y = from_degrees(np.array([west, east]), np.array([south, north]))
        return WorldBox(float(x[0]), float(y[1]), float(x[1]), float(y[0]))

    def _box_of_tiles(self) -> WorldBox:
        ((zoom, west, east, low, high),) = self._rows(
            "SELECT zoom_level, min(tile_column), max(tile_column), min(tile_row), max(tile_row) FROM tiles "
            "WHERE zoom_level = (SELECT max(zoom_level) FROM tiles)"
        )
        tiles = 1 << zoom
        return WorldBox(west / tiles, (tiles - 1 - high) / tiles, (east + 1) / tiles, (tiles - low) / tiles)

    def _described(self) -> dict[str, object]:
        described: dict[str, object] = {
            name: self._metadata[name] for name in ("name", "attribution", "description") if name in self._metadata
        }
        try:
            described |= json.loads(self._metadata.get("json", "{}"))
        except (ValueError, TypeError) as error:
            raise InputDataError(f"{self._path}: its metadata are damaged: {error}.") from error
        return described

    def _rows(self, query: str) -> Iterator[tuple[Any, ...]]:
        try:
            yield from self._connection.execute(query)
        except sqlite3.Error as error:
            raise InputDataError(f"{self._path} is no MBTiles file that can be read: {error}.") from error


@contextmanager
def open_mbtiles(path: Path) -> Iterator[TileDatabase]:
    """Open an MBTiles file for reading.

    Raises:
        InputDataError: it is none.
    """
    try:
        connection = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)
    except sqlite3.Error as error:
        raise InputDataError(f"{path} is no MBTiles file that can be read: {error}.") from error
    with closing(connection):
        yield TileDatabase(connection, path)
