"""A tile of the searched ground: sums of colours and temperatures, and directions from which its cells were seen."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError

TILE_M: Final = 32.0
"""Edge of a tile; its corners lie at multiples of it."""
VIEW_CELL_M: Final = 1.0
"""Edge of a cell for which directions are kept: about the place that a person takes up."""
COLOUR_CELL_M: Final = 0.25
"""Edge of a cell for which colours and temperatures are kept."""
COLOURS_PER_CELL: Final = 4
"""Cells of colour along the edge of a cell of views."""
VIEW_CELLS: Final = 32
"""Cells of views along the edge of a tile."""
COLOUR_CELLS: Final = VIEW_CELLS * COLOURS_PER_CELL
MAX_VIEWS: Final = 255
"""Number of views beyond which they are no longer counted."""
_ADDED: Final = frozenset({"latest_s"})
"""Arrays that the files of older versions lack."""

TileIndex = tuple[int, int]
"""Row, counted southwards, and column, eastwards: its corner lies at column · 32 m east, -row · 32 m north."""


@dataclass(frozen=True, slots=True, eq=False)
class Tile:
    """Sums of all frames over a tile; row 0 is the northern edge. Its arrays are changed in place."""

    colour_sum: NDArray[np.uint32]
    """Red, green and blue, rounded, shape (128, 128, 3)."""
    colour_count: NDArray[np.uint16]
    """Frames with a share in it, shape (128, 128)."""
    thermal_sum: NDArray[np.float32]
    """Temperatures or what the camera gives in their place, shape (128, 128)."""
    thermal_count: NDArray[np.uint16]
    seen: NDArray[np.uint8]
    """One bit per square of directions (:mod:`aos_gcs.groundmap.directions`), shape (32, 32, bytes)."""
    views: NDArray[np.uint8]
    """Number of squares that are set, at most ``MAX_VIEWS``, shape (32, 32)."""
    latest_s: NDArray[np.uint32]
    """UTC second of the latest view, shape (32, 32); 0 where there is none, or its time is not known."""

    @classmethod
    def empty(cls, direction_bytes: int) -> Tile:
        """Return a tile that nothing has looked at."""
        return cls(
            colour_sum=np.zeros((COLOUR_CELLS, COLOUR_CELLS, 3), dtype=np.uint32),
            colour_count=np.zeros((COLOUR_CELLS, COLOUR_CELLS), dtype=np.uint16),
            thermal_sum=np.zeros((COLOUR_CELLS, COLOUR_CELLS), dtype=np.float32),
            thermal_count=np.zeros((COLOUR_CELLS, COLOUR_CELLS), dtype=np.uint16),
            seen=np.zeros((VIEW_CELLS, VIEW_CELLS, direction_bytes), dtype=np.uint8),
            views=np.zeros((VIEW_CELLS, VIEW_CELLS), dtype=np.uint8),
            latest_s=np.zeros((VIEW_CELLS, VIEW_CELLS), dtype=np.uint32),
        )

    def means(self) -> NDArray[np.float32]:
        """Return red, green, blue and temperature, means of all frames, shape (128, 128, 4); NaN where none is."""
        values = np.full((COLOUR_CELLS, COLOUR_CELLS, 4), np.nan, dtype=np.float32)
        np.divide(
            self.colour_sum,
            self.colour_count[..., np.newaxis],
            out=values[..., :3],
            where=self.colour_count[..., np.newaxis] > 0,
            casting="unsafe",
        )
        np.divide(self.thermal_sum, self.thermal_count, out=values[..., 3], where=self.thermal_count > 0)
        return values

    def mark_seen(
        self,
        window: tuple[slice, slice],
        squares: NDArray[np.int32],
        counts: NDArray[np.bool_],
        *,
        utc_s: float,
        since_s: float | None,
    ) -> None:
        """Count a view of cells where its direction is new.

        Args:
            window: rows and columns of the tile's cells of views.
            squares: square of directions of each cell, shape of the window.
            counts: cells that the view shows, shape of the window.
            utc_s: time of the view.
            since_s: time from which on views count; cells whose latest one is older lose theirs. None: all count.
        """
        rows, columns = np.nonzero(counts)
        chosen = squares[rows, columns]
        cells = rows + window[0].start, columns + window[1].start
        if since_s is not None:
            is_old = self.latest_s[cells] < since_s
            if is_old.any():
                forgotten = cells[0][is_old], cells[1][is_old]
                self.seen[forgotten] = 0
                self.views[forgotten] = 0
        self.latest_s[cells] = int(utc_s)
        places = *cells, chosen >> 3
        bits = np.left_shift(1, chosen & 7).astype(np.uint8)
        before = self.seen[places]
        self.seen[places] = before | bits
        views = self.views[cells]
        self.views[cells] = views + ((before & bits == 0) & (views < MAX_VIEWS))


def write_tile(path: Path, tile: Tile) -> None:
    """Write a tile as a compressed ``.npz`` file that takes the place of an older one as a whole.

    Raises:
        OSError: the disk does not take it; the older file stays.
    """
    temporary = path.with_suffix(".part")
    # Fast rather than small: sums of noise do not shrink much, and tiles are written again and again.
    with zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for one in fields(tile):
            with archive.open(f"{one.name}.npy", "w") as member:
                np.lib.format.write_array(member, getattr(tile, one.name), allow_pickle=False)
    temporary.replace(path)


def read_tile(path: Path, direction_bytes: int) -> Tile:
    """Read a tile.

    Raises:
        InputDataError: the file cannot be read, or is not a tile with so many bytes of directions; the text names it.
    """
    pattern = Tile.empty(direction_bytes)
    return Tile(**_read_arrays(path, {one.name: getattr(pattern, one.name) for one in fields(pattern)}))


def read_views(path: Path) -> tuple[NDArray[np.uint8], NDArray[np.uint32]]:
    """Read the numbers of views of a tile and the UTC seconds of the latest ones alone, shape (32, 32) each.

    Raises:
        InputDataError: the file cannot be read, or is not a tile; the text names it.
    """
    pattern = Tile.empty(1)
    found = _read_arrays(path, {"views": pattern.views, "latest_s": pattern.latest_s})
    return found["views"], found["latest_s"]


def _read_arrays(path: Path, patterns: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Read arrays of the shapes and types of patterns; one that older versions did not write is its pattern."""
    found = dict(patterns)
    try:
        with zipfile.ZipFile(path) as archive:
            missing = _ADDED - {Path(name).stem for name in archive.namelist()}
            for name in patterns.keys() - missing:
                with archive.open(f"{name}.npy") as member:
                    found[name] = np.lib.format.read_array(member, allow_pickle=False)
    except (OSError, KeyError, ValueError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise InputDataError(f"{path} is not a tile of the searched ground, or is damaged: {error}") from error
    for name, like in patterns.items():
        if found[name].shape != like.shape or found[name].dtype != like.dtype:
            raise InputDataError(
                f"{path}: {name} has shape {found[name].shape} and type {found[name].dtype}, but {like.shape} and "
                f"{like.dtype} are expected."
            )
    return found
