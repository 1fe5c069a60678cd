"""PMTiles archives of tiles, written beside their place and put there when they are complete.

Source: PMTiles Version 3 Specification.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from enum import StrEnum
from pathlib import Path
from typing import Any

from aos_gcs.basemaps.mercator import WorldBox
from aos_gcs.errors import ConfigurationError
from aos_gcs.extras import load_extra


class TileFormat(StrEnum):
    """What tiles hold, by the names of the PMTiles library."""

    VECTOR = "MVT"
    PNG = "PNG"
    JPEG = "JPEG"
    WEBP = "WEBP"


class TileArchive:
    """An archive being written. Tiles come in any order; each at most once."""

    def __init__(self, writer: Any, library: Any) -> None:
        self._writer, self._library = writer, library
        self.tiles = 0
        """Number of tiles so far."""

    def add(self, zoom: int, column: int, row: int, content: bytes) -> None:
        """Add a tile."""
        self._writer.write_tile(self._library.zxy_to_tileid(zoom, column, row), content)
        self.tiles += 1

    def finish(
        self, kind: TileFormat, box: WorldBox, metadata: Mapping[str, object], *, is_gzipped: bool = False
    ) -> None:
        """Write directories and header; the archive has a tile at least.

        Args:
            kind: what the tiles hold.
            box: extent of the map.
            metadata: name, attribution and so on.
            is_gzipped: whether the tiles are compressed with gzip.
        """
        west, south, east, north = box.degrees()
        compression = self._library.Compression
        header = {
            "tile_type": self._library.TileType[kind],
            "tile_compression": compression.GZIP if is_gzipped else compression.NONE,
            "min_lon_e7": round(west * 1e7),
            "min_lat_e7": round(south * 1e7),
            "max_lon_e7": round(east * 1e7),
            "max_lat_e7": round(north * 1e7),
            "center_zoom": 0,
            "center_lon_e7": round((west + east) / 2.0 * 1e7),
            "center_lat_e7": round((south + north) / 2.0 * 1e7),
        }
        self._writer.finalize(header, dict(metadata))


@contextmanager
def tile_archive(path: Path) -> Iterator[TileArchive]:
    """Write an archive; it is in its place once the context has been left without an error, and nothing is before.

    Args:
        path: new file; an existing one is replaced.

    Raises:
        ConfigurationError: the pmtiles library is not installed, or the file cannot be written.
    """
    purpose = "Writing a base map"
    library: Any = load_extra("pmtiles.tile", "geo", purpose)
    writing: Any = load_extra("pmtiles.writer", "geo", purpose)
    try:
        with ExitStack() as stack:
            folder = stack.enter_context(tempfile.TemporaryDirectory(dir=path.parent, prefix=".basemap-"))
            partial = Path(folder) / path.name
            with partial.open("wb") as output:
                writer = writing.Writer(output)
                # The library keeps the tiles in the system's folder for temporary files, which may be too small.
                writer.tile_f.close()
                writer.tile_f = stack.enter_context((Path(folder) / "tiles").open("w+b"))
                yield TileArchive(writer, library)
            partial.replace(path)
    except OSError as error:
        raise ConfigurationError(f"{path} cannot be written: {error.strerror or error}.") from error
