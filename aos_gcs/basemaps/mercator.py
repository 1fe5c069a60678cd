"""The square map of the world in Web Mercator: from 0 to 1 from west to east and from north to south.

Source: EPSG:3857; the numbering of tiles is that of PMTiles and of all web maps: (0, 0) is the north-western one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

TILE_PX: Final = 256
MAX_ZOOM: Final = 22
"""Finest zoom that the dashboard shows: 3 cm at middle latitudes."""
HALF_WORLD_M: Final = math.pi * 6378137.0
"""Half the width of the world in metres of EPSG:3857."""
MAX_LATITUDE_DEG = math.degrees(math.atan(math.sinh(math.pi)))


@dataclass(frozen=True, slots=True)
class WorldBox:
    """A rectangle on the map of the world."""

    west: float
    north: float
    east: float
    south: float

    def joined(self, other: WorldBox) -> WorldBox:
        """Return the smallest rectangle around both."""
        return WorldBox(
            min(self.west, other.west),
            min(self.north, other.north),
            max(self.east, other.east),
            max(self.south, other.south),
        )

    def meets(self, zoom: int, column: int, row: int) -> bool:
        """Return whether a tile has a part of it."""
        tiles = 1 << zoom
        is_across = self.west * tiles < column + 1 and self.east * tiles > column
        return is_across and self.north * tiles < row + 1 and self.south * tiles > row

    def tiles(self, zoom: int) -> tuple[range, range]:
        """Return the columns and the rows of the tiles that have a part of it."""
        tiles = 1 << zoom

        def within(low: float, high: float) -> range:
            return range(max(0, math.floor(low * tiles)), min(tiles, math.ceil(high * tiles)))

        return within(self.west, self.east), within(self.north, self.south)

    def degrees(self) -> tuple[float, float, float, float]:
        """Return western longitude, southern latitude, eastern longitude and northern latitude."""
        x, y = np.array([self.west, self.east]), np.array([self.south, self.north])
        longitudes, latitudes = to_degrees(x, y)
        return float(longitudes[0]), float(latitudes[0]), float(longitudes[1]), float(latitudes[1])


def from_degrees(longitude_deg: FloatArray, latitude_deg: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return places on the map of the world, x and y; latitudes beyond its edges count as on them."""
    latitude_rad = np.radians(np.clip(latitude_deg, -MAX_LATITUDE_DEG, MAX_LATITUDE_DEG))
    return longitude_deg / 360.0 + 0.5, 0.5 - np.arcsinh(np.tan(latitude_rad)) / (2.0 * math.pi)


def to_degrees(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return longitudes and latitudes of places on the map of the world."""
    return (x - 0.5) * 360.0, np.degrees(np.arctan(np.sinh((0.5 - y) * 2.0 * math.pi)))


def pixel_centres(zoom: int, column: int, row: int) -> tuple[FloatArray, FloatArray]:
    """Return x, shape (256,), and y, shape (256,), of the centres of a tile's pixels on the map of the world."""
    tiles, shares = 1 << zoom, (np.arange(TILE_PX) + 0.5) / TILE_PX
    return (column + shares) / tiles, (row + shares) / tiles


def zoom_of(pixel: float) -> int:
    """Return the zoom whose pixels are not coarser than this share of the world, up to a tenth, at most the finest."""
    return min(MAX_ZOOM, max(0, math.ceil(math.log2(1.0 / (TILE_PX * pixel)) - 0.14)))
