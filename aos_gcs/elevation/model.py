"""Heights of the ground at any place, from one or several files."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import StrEnum
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aos_gcs.elevation.datum import SIGMA_THROUGH_GRIDS_M, SIGMA_TO_EGM96_M, StatedDatum, VerticalDatum
from aos_gcs.elevation.geoid import Geoid
from aos_gcs.elevation.merged import MergedHeights
from aos_gcs.elevation.suspects import Holes, SuspectedHoles, overlaps, zeros_at_a_step
from aos_gcs.elevation.tile import BLOCK_CELLS, BlockCache, ElevationTile, block_counts
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.extras import load_extra
from aos_gcs.height_rasters import unwrapped

MAX_CACHED_BYTES = 32_000_000
"""Memory of the blocks that were used last: 30 of 512 x 512 heights."""

_SAME_CELL = 1e-6
"""Difference, as a share of a cell, up to which tiles lie on one grid."""

_EARTH_RADIUS_M = 6_371_000.0


class ModelKind(StrEnum):
    """Kind of surface whose heights an elevation model holds. No file states it."""

    TERRAIN = "terrain"
    """The ground, without trees and buildings (DTM)."""
    SURFACE = "surface"
    """Whatever was seen from above (DSM): in forests, crowns."""


SURFACE_WARNING = (
    "The elevation model is a surface model: where trees stand, its heights are those of crowns (median error 13 m "
    "under dense canopy). It shows where not to fly into, not where the ground is."
)
"""Warning to those who use a surface model."""


class ElevationModel:
    """Heights above mean sea level (EGM96), bilinear between the centres of cells.

    Files are opened at once and read in blocks; memory is bounded.
    """

    def __init__(
        self,
        paths: Sequence[Path],
        kind: ModelKind,
        *,
        datum: VerticalDatum | None = None,
        crs: str | None = None,
        geoid: Geoid | None = None,
        egm2008: Geoid | None = None,
    ) -> None:
        """Open the files of a model.

        Args:
            paths: GeoTIFF or ASC files of one coordinate system and one grid.
            kind: what the heights are those of.
            datum: vertical datum of files that state none.
            crs: coordinate system of files that state none.
            geoid: needed for heights above the ellipsoid.
            egm2008: geoid EGM2008; with it and ``geoid`` heights above it become those above EGM96, else they are
                taken as they are.

        Raises:
            InputDataError: if a file cannot be used, states no datum, or does not go with the others.
            ConfigurationError: if no file is given, the datum contradicts a file's own, or its geoid is missing.
        """
        if not paths:
            raise ConfigurationError("An elevation model needs at least one file.")
        self.kind = kind
        self._tiles = tuple(ElevationTile(path, crs) for path in paths)
        self.geoid = geoid
        """The geoid, where its grid is at hand."""
        self._egm2008 = egm2008
        self._cache = BlockCache(MAX_CACHED_BYTES)
        first = self._tiles[0]
        for tile in self._tiles[1:]:
            _refuse_other_grid(first, tile)
        self.datum = _agreed_datum(self._tiles, datum)
        """Datum of the files."""
        if self.datum.datum is VerticalDatum.ELLIPSOID and geoid is None:
            raise ConfigurationError(
                f"The heights of {first.path} are above the ellipsoid, and no grid of the geoid, which relates it to "
                "mean sea level, is installed: the error would be up to 100 m. Install Debian's proj-data, or give "
                "PROJ's grid egm96_15 (--geoid FILE; geoid in a configuration)."
            )
        pyproj: Any = load_extra("pyproj", "geo", "Reading an elevation model")
        self._to_crs = pyproj.Transformer.from_crs("EPSG:4326", first.horizontal_crs, always_xy=True)
        self._turn = 2.0 * math.pi / first.horizontal_crs.axis_info[0].unit_conversion_factor
        """Whole turn in units of a coordinate system of angles."""
        self._refuse_places_off_the_earth()

    @property
    def paths(self) -> tuple[Path, ...]:
        """Files of the model."""
        return tuple(tile.path for tile in self._tiles)

    @property
    def crs_name(self) -> str:
        """Name of the coordinate system."""
        return str(self._tiles[0].crs.name)

    @property
    def sigma_m(self) -> float:
        """Standard deviation that the change of datums adds to the heights."""
        if self.datum.datum is VerticalDatum.EGM2008 and self._is_shifted:
            return SIGMA_THROUGH_GRIDS_M
        return SIGMA_TO_EGM96_M[self.datum.datum]

    @property
    def cell_m(self) -> tuple[float, float]:
        """Size of a cell along x and y, about, in metres on the ground at the middle of the first file."""
        tile = self._tiles[0]
        dx, dy = (abs(step) for step in tile.cell_xy)
        if not tile.crs.is_geographic:
            per_unit = tile.crs.axis_info[0].unit_conversion_factor
            return dx * per_unit, dy * per_unit
        _, south, _, north = tile.bounds
        per_degree_m = math.radians(1.0) * _EARTH_RADIUS_M
        return dx * per_degree_m * math.cos(math.radians((south + north) / 2)), dy * per_degree_m

    @property
    def cells(self) -> int:
        """Number of cells of all files."""
        return sum(tile.rows * tile.columns for tile in self._tiles)

    def _refuse_places_off_the_earth(self) -> None:
        south, west, north, east = bounds_deg = self.bounds_deg()
        # Longitudes up to 360 degrees stand in models that begin at Greenwich, those below -180 in ones across 180.
        if not (np.isfinite(bounds_deg).all() and -90.0 <= south < north <= 90.0 and -360.0 <= west < east <= 360.0):
            raise InputDataError(
                f"The elevation model {self._tiles[0].path} lies off the earth, at latitudes from {south:g} to "
                f"{north:g} and longitudes from {west:g} to {east:g} degrees: its coordinates are not those of "
                f"{self.crs_name}."
            )

    def bounds_deg(self) -> tuple[float, float, float, float]:
        """Return the least latitude and longitude, and the greatest, of all files; across 180 degrees beyond it."""
        boxes: list[tuple[float, ...]] = []
        for tile in self._tiles:
            west, south, east, north = tile.bounds
            along = np.linspace(0.0, 1.0, 9)
            x = np.concatenate([west + along * (east - west)] * 2 + [np.full(9, west), np.full(9, east)])
            y = np.concatenate([np.full(9, south), np.full(9, north)] + [south + along * (north - south)] * 2)
            longitude, latitude = self._to_crs.transform(x, y, direction="INVERSE")
            if not tile.crs.is_geographic:
                longitude = unwrapped(longitude, float(boxes[0][1]) if boxes else float(longitude[4]))
            boxes.append(tuple(map(float, (latitude.min(), longitude.min(), latitude.max(), longitude.max()))))
        corners = np.array(boxes)
        south, west = corners[:, :2].min(axis=0)
        north, east = corners[:, 2:].max(axis=0)
        return float(south), float(west), float(north), float(east)

    def heights_amsl_m(self, latitude_deg: ArrayLike, longitude_deg: ArrayLike) -> NDArray[np.float64]:
        """Return the heights above mean sea level (EGM96) at places; NaN where the model has a hole or ends.

        Raises:
            InputDataError: if a file cannot be read any more, has impossible heights, or contradicts another.
        """
        latitude, longitude = np.broadcast_arrays(
            np.asarray(latitude_deg, dtype=np.float64), np.asarray(longitude_deg, dtype=np.float64)
        )
        shape = latitude.shape
        heights = self._interpolated(*self._coordinates(latitude.ravel(), longitude.ravel())).reshape(shape)
        return heights - self.undulation_m(latitude, longitude) if self._is_shifted else heights

    def row_column(
        self, latitude_deg: NDArray[np.float64], longitude_deg: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return places, shape (n,), as rows and columns of the grid; whole numbers are the centres of cells."""
        row, column = self._tiles[0].row_column(*self._coordinates(latitude_deg, longitude_deg))
        return row, column

    def _coordinates(
        self, latitude_deg: NDArray[np.float64], longitude_deg: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return places, shape (n,), in the coordinate system of the files, whichever turn their longitudes are in."""
        x, y = (np.atleast_1d(axis) for axis in self._to_crs.transform(longitude_deg, latitude_deg))
        x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
        if self._tiles[0].crs.is_geographic:
            west, _, east, _ = self._tiles[0].bounds
            x = unwrapped(x, (west + east) / 2.0, self._turn)
        return x, y

    def cells_of_files(self, rows: NDArray[np.int64], columns: NDArray[np.int64]) -> NDArray[np.float32]:
        """Return the heights of cells, above the files' datum; NaN where the model has a hole or ends.

        Args:
            rows: rows of the grid, consecutive.
            columns: columns of the grid, consecutive.

        Raises:
            InputDataError: if a file cannot be read any more, has impossible heights, or contradicts another.
        """
        merged = MergedHeights((len(rows), len(columns)), np.float32)
        for tile in self._tiles:
            row_offset, column_offset = self._offset(tile)
            first_row, first_column = int(rows[0]) - row_offset, int(columns[0]) - column_offset
            row, row_end = max(0, first_row), min(tile.rows, first_row + len(rows))
            column, column_end = max(0, first_column), min(tile.columns, first_column + len(columns))
            if row >= row_end or column >= column_end:
                continue
            cells = slice(row - first_row, row_end - first_row), slice(column - first_column, column_end - first_column)
            merged.add(cells, tile.read(row, column, row_end - row, column_end - column), tile.path)
        return merged.heights

    def undulation_m(
        self, latitude_deg: NDArray[np.float64], longitude_deg: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return what is to be taken off the files' heights for heights above mean sea level."""
        if self.geoid is None or not self._is_shifted:
            return np.zeros(np.shape(latitude_deg))
        egm96_m = self.geoid.undulation_m(latitude_deg, longitude_deg)
        if self.datum.datum is VerticalDatum.ELLIPSOID or self._egm2008 is None:
            return egm96_m
        return egm96_m - self._egm2008.undulation_m(latitude_deg, longitude_deg)

    @property
    def _is_shifted(self) -> bool:
        """Whether the files' heights are changed to those above EGM96."""
        if self.datum.datum is VerticalDatum.EGM2008:
            return self.geoid is not None and self._egm2008 is not None
        return self.datum.datum is VerticalDatum.ELLIPSOID and self.geoid is not None

    def holes(self, max_cells: int) -> Holes | None:
        """Count the cells without a height; None if there are more than ``max_cells`` cells to look at.

        Raises:
            InputDataError: if a file cannot be read any more, has impossible heights, or contradicts another.
        """
        if self.cells > max_cells:
            return None
        for shared in overlaps([self._box(tile) for tile in self._tiles], BLOCK_CELLS):
            self.cells_of_files(*(np.array(part) for part in shared))
        count, zeros, first, first_zero = 0, 0, None, None
        for tile in self._tiles:
            for block in product(*map(range, block_counts(tile))):
                heights = tile.read_block(*block)
                unknown = np.isnan(heights)
                count += int(unknown.sum())
                if first is None and unknown.any():
                    first = self._place_deg(tile, BLOCK_CELLS * block[0], BLOCK_CELLS * block[1], unknown)
                if not (heights == 0.0).any():
                    continue
                # With the cells about it: patches of missing data may end where blocks do.
                row, column = (max(0, BLOCK_CELLS * at - 1) for at in block)
                rows, columns = min(tile.rows - row, BLOCK_CELLS + 2), min(tile.columns - column, BLOCK_CELLS + 2)
                steps = zeros_at_a_step(tile.read(row, column, rows, columns))
                if steps.any():
                    zeros += int((heights == 0.0).sum())
                    first_zero = first_zero or self._place_deg(tile, row, column, steps)
        return Holes(count, self.cells, first, SuspectedHoles(zeros, first_zero) if first_zero else None)

    def close(self) -> None:
        """Close the files."""
        for tile in self._tiles:
            tile.close()

    def _box(self, tile: ElevationTile) -> tuple[int, int, int, int]:
        row, column = self._offset(tile)
        return row, column, row + tile.rows, column + tile.columns

    def _place_deg(self, tile: ElevationTile, row: int, column: int, wanted: NDArray[np.bool_]) -> tuple[float, float]:
        """Return latitude and longitude of the first wanted cell of a window that begins at a cell of a tile."""
        down, along = np.argwhere(wanted)[0]
        row, column = row + int(down), column + int(along)
        west, south, east, north = tile.bounds
        step_x, step_y = tile.cell_xy
        x = (west if step_x > 0 else east) + (column + 0.5) * step_x
        y = (south if step_y > 0 else north) + (row + 0.5) * step_y
        longitude, latitude = self._to_crs.transform(x, y, direction="INVERSE")
        return float(latitude), (float(longitude) + 180.0) % 360.0 - 180.0

    def _interpolated(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return heights above the files' datum at coordinates, shape (n,).

        Rows and columns count on the grid that all files share, so that neighbours may lie in different files.
        """
        row, column = self._tiles[0].row_column(x, y)
        is_place = np.isfinite(row) & np.isfinite(column)
        row, column = np.where(is_place, row, 0.0), np.where(is_place, column, 0.0)
        top, left = np.floor(row), np.floor(column)
        down, right = row - top, column - left
        # A place within half a cell of an outer edge takes the height of the cell that it lies in.
        own = self._cells(np.rint(row), np.rint(column))
        heights = np.zeros(len(x))
        for row_offset, column_offset in ((0, 0), (0, 1), (1, 0), (1, 1)):
            weight = (down if row_offset else 1.0 - down) * (right if column_offset else 1.0 - right)
            values, is_inside = self._cells_and_extent(top + row_offset, left + column_offset)
            values = np.where(is_inside, values, own)
            heights += np.where(weight > 0.0, weight * values, 0.0)
        return np.where(is_place & self._cells_and_extent(np.rint(row), np.rint(column))[1], heights, np.nan)

    def _cells(self, row: NDArray[np.float64], column: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._cells_and_extent(row, column)[0]

    def _cells_and_extent(
        self, row: NDArray[np.float64], column: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Return the heights of cells of the shared grid, NaN in holes, and whether a file has them, shape (n,)."""
        merged = MergedHeights((len(row),), np.float64)
        is_inside = np.zeros(len(row), dtype=np.bool_)
        for index, tile in enumerate(self._tiles):
            row_offset, column_offset = self._offset(tile)
            rows, columns = (row - row_offset).astype(np.int64), (column - column_offset).astype(np.int64)
            within = (rows >= 0) & (rows < tile.rows) & (columns >= 0) & (columns < tile.columns)
            wanted = np.flatnonzero(within)
            is_inside |= within
            blocks = np.stack((rows[wanted] // BLOCK_CELLS, columns[wanted] // BLOCK_CELLS), axis=1)
            for block_row, block_column in np.unique(blocks, axis=0) if len(wanted) else ():
                block = self._cache.block(index, tile, int(block_row), int(block_column))
                chosen = wanted[(blocks == (block_row, block_column)).all(axis=1)]
                values = block[rows[chosen] % BLOCK_CELLS, columns[chosen] % BLOCK_CELLS]
                merged.add(chosen, values, tile.path)
        return merged.heights, is_inside

    def _offset(self, tile: ElevationTile) -> tuple[int, int]:
        """Return the row and the column of a tile's first cell on the grid of the first tile."""
        first = self._tiles[0]
        corners = [(_first_centre(other)) for other in (first, tile)]
        return tuple(  # type: ignore[return-value]
            round((theirs - ours) / step)
            for ours, theirs, step in zip(corners[0], corners[1], reversed(first.cell_xy), strict=True)
        )


def _first_centre(tile: ElevationTile) -> tuple[float, float]:
    """Return y and x of the centre of a tile's first cell."""
    west, south, east, north = tile.bounds
    step_x, step_y = tile.cell_xy
    return (south if step_y > 0 else north) + step_y / 2, (west if step_x > 0 else east) + step_x / 2


def _refuse_other_grid(first: ElevationTile, other: ElevationTile) -> None:
    if not first.horizontal_crs.equals(other.horizontal_crs):
        ours, theirs = first.horizontal_crs.name, other.horizontal_crs.name
        raise InputDataError(
            f"{other.path} is in {theirs}, but {first.path} in {ours}: warp them to one coordinate system (gdalwarp)."
        )
    same_steps = np.allclose(first.cell_xy, other.cell_xy, rtol=_SAME_CELL)
    shifts = [
        (theirs - ours) / step
        for ours, theirs, step in zip(_first_centre(first), _first_centre(other), reversed(first.cell_xy), strict=True)
    ]
    # Tiles of a thousand cells may differ in the last digits of their corners.
    if not same_steps or any(abs(shift - round(shift)) > 1e-2 for shift in shifts):
        raise InputDataError(
            f"The cells of {other.path} and {first.path} do not lie on one grid: merge them to one file (gdalwarp)."
        )


def _agreed_datum(tiles: Sequence[ElevationTile], given: VerticalDatum | None) -> StatedDatum:
    """Return the datum of all tiles: their own, or the one that is given for those without."""
    stated = {tile.stated_datum for tile in tiles}
    if len(stated) > 1:
        names = sorted({"none" if datum is None else datum.name for datum in stated})
        raise InputDataError(f"The files state different vertical datums: {', '.join(names)}.")
    own = next(iter(stated))
    if own is None:
        if given is None:
            raise InputDataError(
                f"The elevation model {tiles[0].path} does not state its vertical datum: give it (--datum egm96, "
                "egm2008, national or ellipsoid; datum in a configuration). Its provider's description contains it."
            )
        return StatedDatum(given, f"{given}, as stated by the operator")
    if given is not None and given is not own.datum:
        raise ConfigurationError(
            f"The vertical datum of {tiles[0].path} is {own.name} ({own.datum}) according to the file, not {given}."
        )
    return own
