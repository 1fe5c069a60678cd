"""Base maps to test with: PMTiles archives of one tile, and vector tiles, written by their specifications.

Sources: PMTiles Version 3 Specification; Mapbox Vector Tile Specification 2.1.
"""

from __future__ import annotations

import gzip
import json
import math
import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from aos_gcs.geometry.geodesy import GeodeticPosition

MVT, PNG = 1, 2
_HEADER_LENGTH = 127
_NONE, _GZIP = 1, 2
_EXTENT = 4096
_LINE, _POLYGON = 2, 3
_VARINT, _BYTES = 0, 2


@dataclass(frozen=True, slots=True)
class Tile:
    """A tile of the Web Mercator pyramid."""

    zoom: int
    column: int
    row: int

    @property
    def number(self) -> int:
        """Place of the tile on the Hilbert curves of all zoom levels, as archives count."""
        number, x, y = ((1 << 2 * self.zoom) - 1) // 3, self.column, self.row
        for level in reversed(range(self.zoom)):
            side = 1 << level
            right, lower = x & side > 0, y & side > 0
            number += side * side * ((3 * right) ^ lower)
            x, y = x & (side - 1), y & (side - 1)
            if not lower:
                x, y = (side - 1 - y, side - 1 - x) if right else (y, x)
        return number

    def point(self, place: GeodeticPosition) -> tuple[int, int]:
        """Return the coordinates of a place within the tile, x to the right, y down."""
        x, y = mercator(place)
        scale = 1 << self.zoom
        return round((x * scale - self.column) * _EXTENT), round((y * scale - self.row) * _EXTENT)


def mercator(place: GeodeticPosition) -> tuple[float, float]:
    """Return a place on the map of the world, 0 to 1 from west to east and from north to south."""
    latitude_rad = math.radians(place.latitude_deg)
    return place.longitude_deg / 360.0 + 0.5, 0.5 - math.asinh(math.tan(latitude_rad)) / (2.0 * math.pi)


def tile_at(place: GeodeticPosition, zoom: int) -> Tile:
    """Return the tile that holds a place."""
    x, y = mercator(place)
    return Tile(zoom, int(x * 2**zoom), int(y * 2**zoom))


@dataclass(frozen=True, slots=True)
class Shape:
    """A line, or the ring of a polygon without its last corner, clockwise as seen on the map."""

    places: Sequence[GeodeticPosition]
    is_area: bool
    properties: Mapping[str, str]


def vector_tile(tile: Tile, layers: Mapping[str, Sequence[Shape]]) -> bytes:
    """Return a vector tile with these layers."""
    return b"".join(_field(3, _layer(tile, name, shapes)) for name, shapes in layers.items())


def pmtiles(
    content: bytes, tile_type: int, tile: Tile = Tile(0, 0, 0), layers: Sequence[str] = (), attribution: str = ""
) -> bytes:
    """Return an archive of one tile."""
    # One entry: the tile's number, run length 1, its length, and offset 0 stored as 1.
    root = gzip.compress(b"".join(map(_varint, (1, tile.number, 1, len(content), 1))), mtime=0)
    said = {"vector_layers": [{"id": name, "fields": {}} for name in layers], "attribution": attribution}
    metadata = gzip.compress(json.dumps(said).encode(), mtime=0)
    metadata_at = _HEADER_LENGTH + len(root)
    tiles_at = metadata_at + len(metadata)
    sections = (_HEADER_LENGTH, len(root), metadata_at, len(metadata), 0, 0, tiles_at, len(content))
    header = struct.pack("<7sB8Q3Q", b"PMTiles", 3, *sections, 1, 1, 1)
    header += struct.pack("<6B", 1, _GZIP, _NONE, tile_type, tile.zoom, tile.zoom)
    header += struct.pack("<4iB2i", -1800000000, -850000000, 1800000000, 850000000, tile.zoom, 0, 0)
    return header + root + metadata + content


def _layer(tile: Tile, name: str, shapes: Sequence[Shape]) -> bytes:
    keys = sorted({key for shape in shapes for key in shape.properties})
    values = sorted({value for shape in shapes for value in shape.properties.values()})
    features = [
        _field(2, _packed(n for key, value in shape.properties.items() for n in (keys.index(key), values.index(value))))
        + _field(3, _POLYGON if shape.is_area else _LINE)
        + _field(4, _packed(_commands([tile.point(place) for place in shape.places], shape.is_area)))
        for shape in shapes
    ]
    parts = [_field(15, 2), _field(1, name.encode())]
    parts += [_field(2, feature) for feature in features]
    parts += [_field(3, key.encode()) for key in keys]
    parts += [_field(4, _field(1, value.encode())) for value in values]
    return b"".join([*parts, _field(5, _EXTENT)])


def _commands(points: Sequence[tuple[int, int]], is_area: bool) -> list[int]:
    """Move to the first point, draw lines to the others, close."""
    steps = zip([(0, 0), *points], points, strict=False)
    first, *others = [[_zigzag(b - a) for a, b in zip(start, end, strict=True)] for start, end in steps]
    drawn = [1 | 1 << 3, *first, 2 | len(others) << 3, *(number for pair in others for number in pair)]
    return [*drawn, 7 | 1 << 3] if is_area else drawn


def _zigzag(number: int) -> int:
    return (number << 1) ^ (number >> 31)


def _packed(numbers: Iterable[int]) -> bytes:
    return b"".join(map(_varint, numbers))


def _field(number: int, value: int | bytes) -> bytes:
    if isinstance(value, int):
        return _varint(number << 3 | _VARINT) + _varint(value)
    return _varint(number << 3 | _BYTES) + _varint(len(value)) + value


def _varint(number: int) -> bytes:
    encoded = bytearray()
    while number > 0x7F:
        encoded.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes([*encoded, number])
