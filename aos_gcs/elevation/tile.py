"""One file of an elevation model, read in blocks when they are needed."""

from __future__ import annotations

import logging
import math
import threading
import warnings
from collections import OrderedDict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.elevation.datum import StatedDatum, stated_datum
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.extras import load_extra
from aos_gcs.height_rasters import check_file, check_heights, gdal_reason, read_heights, refuse_impossible

BLOCK_CELLS = 512
"""Edge of the blocks that are read."""

_GDAL_OPTIONS = {"GDAL_CACHEMAX": 32}
"""GDAL's own memory of what was read, in MB: by default it takes a twentieth of the machine's."""

_MAX_BLOCK_BYTES = 64_000_000
"""Largest part of a file that is read at once."""


class ElevationTile:
    """A raster of heights; rows and columns are those of its cells."""

    def __init__(self, path: Path, crs: str | None = None) -> None:
        """Open a GeoTIFF or an ASC file without reading its heights.

        Args:
            path: the file.
            crs: coordinate system of a file that states none, such as ``EPSG:31255``.

        Raises:
            InputDataError: if the file is unreadable, has no coordinate system or place, is turned, is stored in blocks
                that are too large, or its heights are not in metres.
            ConfigurationError: if rasterio or pyproj is not installed, or the coordinate system is not known.
        """
        self._rasterio: Any = load_extra("rasterio", "geo", "Reading an elevation model")
        pyproj: Any = load_extra("pyproj", "geo", "Reading an elevation model")
        # It logs what GDAL says before it raises the same words.
        logging.getLogger("rasterio").setLevel(logging.CRITICAL)
        self.path = path
        name = f"The elevation model {path}"
        check_file(path, name)
        try:
            with (
                warnings.catch_warnings(action="ignore", category=self._rasterio.errors.NotGeoreferencedWarning),
                self._rasterio.Env(**_GDAL_OPTIONS),
            ):
                self._dataset = self._rasterio.open(path, num_threads="2")
        except self._rasterio.errors.RasterioError as error:
            raise InputDataError(f"{name} cannot be read: {gdal_reason(error)}.") from error
        if self._dataset.crs is None and crs is None:
            raise InputDataError(
                f"The elevation model {path} states no coordinate system: give it (--crs EPSG:CODE; crs in a "
                "configuration), or put its .prj file beside it."
            )
        self.crs = self._system(pyproj, crs)
        transform = self._dataset.transform
        if transform.is_identity:
            raise InputDataError(f"The elevation model {path} is a picture whose place is not known.")
        if transform.b != 0.0 or transform.d != 0.0:
            raise InputDataError(f"The elevation model {path} is turned: warp it to rows from west to east (gdalwarp).")
        self.stated_datum: StatedDatum | None = stated_datum(self.crs, str(path))
        check_heights(self._dataset, path, name)
        self._refuse_large_blocks()
        self.rows, self.columns = int(self._dataset.height), int(self._dataset.width)
        self.cell_xy = float(transform.a), float(transform.e)
        """Steps of a column along x and of a row along y, in units of the coordinate system."""
        self._corner_xy = float(transform.c), float(transform.f)
        self._lock = threading.Lock()

    def _system(self, pyproj: Any, given: str | None) -> Any:
        """Return the coordinate system of the file, else the one that is given.

        Raises:
            ConfigurationError: the one that is given is not known, has no places, or contradicts the file.
        """
        own = self._dataset.crs
        try:
            told = None if given is None else pyproj.CRS.from_user_input(given)
            crs: Any = told if own is None else pyproj.CRS.from_user_input(own.to_wkt())
        except pyproj.exceptions.CRSError as error:
            text = f"of {self.path}" if given is None else repr(given)
            raise ConfigurationError(
                f"The coordinate system {text} is not known: use one such as EPSG:31255."
            ) from error
        if not (crs.is_geographic or crs.is_projected):
            raise ConfigurationError(f"{crs.name} has no places in a plane or in degrees: use one such as EPSG:31255.")
        horizontal = crs.sub_crs_list[0] if crs.is_compound else crs.to_2d()
        if told is not None and not told.to_2d().equals(horizontal, ignore_axis_order=True):
            raise ConfigurationError(
                f"{self.path} is in {horizontal.name} according to the file, not in {told.name}: leave --crs out."
            )
        return crs

    @property
    def horizontal_crs(self) -> Any:
        """Coordinate system without heights, ``pyproj.CRS``."""
        return self.crs.sub_crs_list[0] if self.crs.is_compound else self.crs.to_2d()

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Smallest x, smallest y, greatest x and greatest y of the outer edges."""
        xs = sorted((self._corner_xy[0], self._corner_xy[0] + self.columns * self.cell_xy[0]))
        ys = sorted((self._corner_xy[1], self._corner_xy[1] + self.rows * self.cell_xy[1]))
        return xs[0], ys[0], xs[1], ys[1]

    def row_column(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        """Return places as rows and columns, whole numbers at the centres of cells."""
        return (
            (y - self._corner_xy[1]) / self.cell_xy[1] - 0.5,
            (x - self._corner_xy[0]) / self.cell_xy[0] - 0.5,
        )

    def read_block(self, block_row: int, block_column: int) -> NDArray[np.float32]:
        """Return a block of heights; as for ``read``."""
        row, column = block_row * BLOCK_CELLS, block_column * BLOCK_CELLS
        return self.read(row, column, min(BLOCK_CELLS, self.rows - row), min(BLOCK_CELLS, self.columns - column))

    def read(self, row: int, column: int, rows: int, columns: int) -> NDArray[np.float32]:
        """Return a window of heights, shape (rows, columns), metres; NaN where they are not known.

        Raises:
            InputDataError: if the file cannot be read any more, or has impossible heights.
        """
        window = self._rasterio.windows.Window(column, row, columns, rows)
        try:
            with self._lock, self._rasterio.Env(**_GDAL_OPTIONS):
                heights = read_heights(self._dataset, window).astype(np.float32, copy=False)
                if self._dataset.nodata is None and not heights.all():
                    self._blank_unwritten(heights, row, column)
        except self._rasterio.errors.RasterioError as error:
            raise InputDataError(f"The elevation model {self.path} cannot be read: {gdal_reason(error)}.") from error
        refuse_impossible(heights, f"The elevation model {self.path}")
        return heights

    def _blank_unwritten(self, heights: NDArray[np.float32], row: int, column: int) -> None:
        """Make holes of the parts of a GeoTIFF that were never written, which GDAL reads as zeros."""
        if self._dataset.driver != "GTiff":
            return
        deep, wide = self._dataset.block_shapes[0]
        for y in range(row // deep, -(-(row + heights.shape[0]) // deep)):
            for x in range(column // wide, -(-(column + heights.shape[1]) // wide)):
                if self._dataset.get_tag_item(f"BLOCK_OFFSET_{x}_{y}", "TIFF", bidx=1) is None:
                    top, left = max(0, y * deep - row), max(0, x * wide - column)
                    heights[top : (y + 1) * deep - row, left : (x + 1) * wide - column] = np.nan

    def _refuse_large_blocks(self) -> None:
        rows, columns = self._dataset.block_shapes[0]
        block_bytes = rows * columns * np.dtype(self._dataset.dtypes[0]).itemsize
        if block_bytes > _MAX_BLOCK_BYTES:
            raise InputDataError(
                f"The elevation model {self.path} is stored in blocks of {rows} x {columns} heights, "
                f"{block_bytes / 1e6:,.0f} MB each, which are read as a whole: store it in tiles (gdal_translate -co "
                "TILED=YES IN OUT)."
            )

    def close(self) -> None:
        """Close the file."""
        self._dataset.close()


class BlockCache:
    """The blocks that were used last, of all tiles, up to a number of bytes."""

    def __init__(self, max_bytes: int) -> None:
        self._max_bytes = max_bytes
        self._blocks: OrderedDict[tuple[int, int, int], NDArray[np.float32]] = OrderedDict()
        self._bytes = 0
        self._lock = threading.Lock()

    def block(self, index: int, tile: ElevationTile, row: int, column: int) -> NDArray[np.float32]:
        """Return a block of a tile, which has an index of its own."""
        key = index, row, column
        with self._lock:
            if key in self._blocks:
                self._blocks.move_to_end(key)
                return self._blocks[key]
        block = tile.read_block(row, column)
        with self._lock:
            if key not in self._blocks:
                self._blocks[key] = block
                self._bytes += block.nbytes
            while self._bytes > self._max_bytes and len(self._blocks) > 1:
                _, oldest = self._blocks.popitem(last=False)
                self._bytes -= oldest.nbytes
        return block


def block_counts(tile: ElevationTile) -> tuple[int, int]:
    """Return how many blocks a tile has along its rows' and its columns' axis."""
    return math.ceil(tile.rows / BLOCK_CELLS), math.ceil(tile.columns / BLOCK_CELLS)
