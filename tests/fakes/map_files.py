"""Map files of teams: pictures of four coloured quarters about a place, and what an archive shows there."""

from __future__ import annotations

import io
import sqlite3
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

LATITUDE_DEG, LONGITUDE_DEG = 47.5, 14.25
RED, GREEN, BLUE, WHITE = (220, 30, 30), (30, 200, 40), (40, 60, 220), (240, 240, 240)
QUARTERS = {(-1, 1): RED, (1, 1): GREEN, (-1, -1): BLUE, (1, -1): WHITE}
"""Colour by the side of the middle, east and north."""
Pixels = NDArray[np.uint8]


def quarters(side_px: int = 200) -> Pixels:
    """Return the picture, shape (side, side, 3)."""
    half = side_px // 2
    picture = np.zeros((side_px, side_px, 3), dtype=np.uint8)
    for (east, north), colour in QUARTERS.items():
        rows, columns = (
            slice(0, half) if north > 0 else slice(half, None),
            slice(half, None) if east > 0 else slice(0, half),
        )
        picture[rows, columns] = colour
    return picture


def write_raster(
    path: Path, bands: Pixels, *, crs: str | None = "EPSG:32633", cell_m: float = 0.5, **options: Any
) -> Path:
    """Write bands, shape (rows, columns, count), whose middle lies at the place; ``colormap`` is one of rasterio's."""
    import pyproj  # noqa: PLC0415 - tests without the extra are skipped
    import rasterio  # noqa: PLC0415
    from rasterio.transform import Affine  # noqa: PLC0415

    rows, columns, count = bands.shape
    to_crs = pyproj.Transformer.from_crs("EPSG:4326", crs or "EPSG:32633", always_xy=True)
    x, y = to_crs.transform(LONGITUDE_DEG, LATITUDE_DEG)
    transform = Affine(cell_m, 0.0, x - columns * cell_m / 2.0, 0.0, -cell_m, y + rows * cell_m / 2.0)
    colormap, tags = options.pop("colormap", None), options.pop("tags", {})
    profile = {"driver": "GTiff", "height": rows, "width": columns, "count": count, "dtype": bands.dtype.name}
    with rasterio.open(path, "w", crs=crs, transform=transform, **profile | options) as dataset:
        dataset.write(np.moveaxis(bands, -1, 0))
        dataset.update_tags(**tags)
        if colormap is not None:
            dataset.write_colormap(1, colormap)
    return path


def write_kmz(path: Path, files: Mapping[str, bytes], *, kml: str | None = None, rotation_deg: float = 0.0) -> Path:
    """Write a KMZ with an overlay of ``map.png`` about the place, 100 m wide, or with another document."""
    half_deg = 50.0 / 111_320.0
    wide_deg = half_deg / np.cos(np.radians(LATITUDE_DEG))
    box = (
        f"<north>{LATITUDE_DEG + half_deg}</north><south>{LATITUDE_DEG - half_deg}</south>"
        f"<east>{LONGITUDE_DEG + wide_deg}</east><west>{LONGITUDE_DEG - wide_deg}</west>"
        f"<rotation>{rotation_deg}</rotation>"
    )
    overlay = f"<GroundOverlay><Icon><href>map.png</href></Icon><LatLonBox>{box}</LatLonBox></GroundOverlay>"
    document = (
        f'<kml xmlns="http://www.opengis.net/kml/2.2"><Document>{overlay}</Document></kml>' if kml is None else kml
    )
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("doc.kml", document)
        for name, content in files.items():
            archive.writestr(name, content)
    return path


def png(picture: Pixels) -> bytes:
    """Return a picture as a PNG, shape (rows, columns, 3 or 4): red first."""
    order = cv2.COLOR_RGBA2BGRA if picture.shape[2] == 4 else cv2.COLOR_RGB2BGR
    return cv2.imencode(".png", cv2.cvtColor(picture, order))[1].tobytes()


def write_mbtiles(path: Path, tiles: Mapping[tuple[int, int, int], bytes], metadata: Mapping[str, str]) -> Path:
    """Write tiles by zoom, column and row, the row as MBTiles count it: from the south."""
    with sqlite3.connect(path) as connection:
        connection.execute("CREATE TABLE metadata (name text, value text)")
        connection.execute("CREATE TABLE tiles (zoom_level int, tile_column int, tile_row int, tile_data blob)")
        connection.executemany("INSERT INTO metadata VALUES (?, ?)", metadata.items())
        connection.executemany(
            "INSERT INTO tiles VALUES (?, ?, ?, ?)", [(*place, tile) for place, tile in tiles.items()]
        )
    connection.close()
    return path


class ShownMap:
    """An archive, as the page reads it."""

    def __init__(self, path: Path) -> None:
        from pmtiles.reader import MemorySource, Reader  # noqa: PLC0415 - tests without the extra are skipped

        self._reader = Reader(MemorySource(path.read_bytes()))
        self.header: dict[str, Any] = self._reader.header()
        self.metadata: dict[str, Any] = self._reader.metadata()

    def tile(self, zoom: int, column: int, row: int) -> bytes | None:
        """Return a tile as it is stored."""
        content: bytes | None = self._reader.get(zoom, column, row)
        return content

    def colour(self, east_m: float, north_m: float, zoom: int | None = None) -> tuple[int, int, int, int]:
        """Return red, green, blue and opacity at a distance from the place; nothing is black and transparent."""
        zoom = self.header["max_zoom"] if zoom is None else zoom
        latitude_deg = LATITUDE_DEG + north_m / 111_180.0
        longitude_deg = LONGITUDE_DEG + east_m / (111_412.0 * np.cos(np.radians(LATITUDE_DEG)))
        x = (longitude_deg / 360.0 + 0.5) * 2**zoom
        y = (0.5 - np.arcsinh(np.tan(np.radians(latitude_deg))) / (2.0 * np.pi)) * 2**zoom
        content = self.tile(zoom, int(x), int(y))
        if content is None:
            return 0, 0, 0, 0
        pixels = cv2.imdecode(np.frombuffer(io.BytesIO(content).read(), np.uint8), cv2.IMREAD_UNCHANGED)
        blue, green, red, *opacity = pixels[int(y % 1 * 256), int(x % 1 * 256)].tolist()
        return red, green, blue, opacity[0] if opacity else 255
