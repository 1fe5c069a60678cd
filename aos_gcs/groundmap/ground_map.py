"""The searched ground of a mission: tiles in memory while they are in use, and in a folder.

Buffered: yes, ``TILES_IN_MEMORY`` tiles, and those that the latest ``FRAMES_IN_USE`` frames have touched; when full:
the one that was touched the longest ago goes to the disk, and comes back when a frame shows it again. The numbers of
views of all tiles and the times of the latest ones stay in memory, 5 kB each, and the forest floor in few cells.
"""

from __future__ import annotations

import json
import logging
import math
import shutil
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError, RecordingError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.groundmap.directions import ViewDirections
from aos_gcs.groundmap.floor import ForestFloor
from aos_gcs.groundmap.projected import GroundView, project_frame
from aos_gcs.groundmap.tile import (
    COLOURS_PER_CELL,
    VIEW_CELLS,
    Tile,
    TileIndex,
    read_tile,
    read_views,
    write_tile,
)
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.views import FocalSurface

TILES_IN_MEMORY: Final = 64
"""Tiles of 0.1 ha that are held at once; they take 48 MB, and a line of ten vehicles 20 m apart touches 40 in 100 m."""
FRAMES_IN_USE: Final = 256
"""Latest frames whose tiles stay in memory: a line of a hundred vehicles would else fetch tiles with each frame."""
HEADER_NAME: Final = "ground.json"
FORMAT: Final = 1
_COLOUR_BANDS: Final = ("red", "green", "blue")

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class GroundHeader:
    """Facts about a whole map."""

    origin: GeodeticPosition
    """Origin of the frame in which its tiles lie."""
    direction_step: float
    """Edge of a square of directions, see :mod:`aos_gcs.groundmap.directions`."""
    frames: int = 0
    """Frames on the map, those of former sorties included."""
    format: int = FORMAT


class GroundMap:
    """Searched ground; made by :func:`open_map`.

    Args:
        folder: folder of its tiles.
        header: facts about it, as in the folder.
        stored: numbers of views of all its tiles, and the UTC seconds of the latest ones, shape (32, 32) each.
    """

    def __init__(
        self,
        folder: Path,
        header: GroundHeader,
        stored: Mapping[TileIndex, tuple[NDArray[np.uint8], NDArray[np.uint32]]],
    ) -> None:
        self.header = header
        self._folder = folder
        self._directions = ViewDirections(header.direction_step)
        self._views = {index: views for index, (views, _) in stored.items()}
        self._latest_s = {index: latest_s for index, (_, latest_s) in stored.items()}
        self._tiles: OrderedDict[TileIndex, Tile] = OrderedDict()
        """Tiles in memory, the one touched last at the end."""
        self._unwritten: set[TileIndex] = set()
        self._last_frames: dict[TileIndex, int] = {}
        """Number of the latest frame that has touched a tile in memory; none where it was read only."""
        self._floor = ForestFloor(stored)

    @property
    def views(self) -> dict[TileIndex, NDArray[np.uint8]]:
        """Numbers of views of all tiles, however old, shape (32, 32) each."""
        return self._views

    @property
    def latest_s(self) -> int:
        """UTC second of the latest view; 0 where there is none, or no time is known."""
        return max((int(times_s.max()) for times_s in self._latest_s.values()), default=0)

    def views_since(self, since_s: float | None) -> Mapping[TileIndex, NDArray[np.uint8]]:
        """Return the numbers of views that count, shape (32, 32) per tile: 0 where the latest view is too old.

        Args:
            since_s: UTC time from which on views count; those whose time is not known do not. None: all count.
        """
        if since_s is None:
            return self._views
        first_s = math.ceil(since_s)
        return {index: np.where(self._latest_s[index] < first_s, 0, views) for index, views in self._views.items()}

    def add(self, frame: Frame, surface: FocalSurface, utc_s: float = 0.0, since_s: float | None = None) -> None:
        """Add a frame.

        Args:
            frame: frame with its pose.
            surface: surface that it shows.
            utc_s: time at which it was taken; 0: not known.
            since_s: UTC time from which on views count, before this one; None: all count.

        Raises:
            ImagingError: it shows nothing of the ground; nothing was added.
            RecordingError: there is no room in memory, and the disk takes no tile; part of it may be missing.
        """
        projected = project_frame(frame, surface, self._directions)
        for index, here, there in _shares(projected):
            tile = self._tile(index)
            self._unwritten.add(index)
            self._last_frames[index] = self.header.frames
            self._floor.mark(index)
            tile.mark_seen(there, projected.squares[here], projected.seen[here], utc_s=utc_s, since_s=since_s)
            _add_values(tile, frame.bands, projected, here, there)
        self.header = replace(self.header, frames=self.header.frames + 1)

    def flush(self) -> None:
        """Write all that has changed.

        Raises:
            RecordingError: the disk does not take it; what it has not taken is tried again with the next flush.
        """
        for index in sorted(self._unwritten):
            self._write(index)
        try:
            _write_header(self._folder, self.header)
        except OSError as error:
            raise _not_written(self._folder, error) from error

    def tile(self, index: TileIndex) -> Tile | None:
        """Return a tile for reading; None where nothing was searched."""
        return self._tile(index) if index in self._views else None

    def floor(self) -> ForestFloor:
        """Return the forest floor as it is now; of a map that goes on, :attr:`ForestFloor.stale` is read later."""
        self._floor.catch_up(self._tiles.items(), self._read)
        return self._floor

    def _read(self, index: TileIndex) -> Tile:
        return _read_or_drop(tile_path(self._folder, index), Tile.empty(self._directions.byte_count))

    def _tile(self, index: TileIndex) -> Tile:
        if index in self._tiles:
            self._tiles.move_to_end(index)
            return self._tiles[index]
        while len(self._tiles) >= TILES_IN_MEMORY:
            oldest = next(iter(self._tiles))
            if self._last_frames.get(oldest, -FRAMES_IN_USE) > self.header.frames - FRAMES_IN_USE:
                break
            if oldest in self._unwritten:
                self._write(oldest)
            self._last_frames.pop(oldest, None)
            self._floor.keep(oldest, self._tiles[oldest])
            del self._tiles[oldest]
        tile = self._read(index) if index in self._views else Tile.empty(self._directions.byte_count)
        # The map's own numbers and times of views are those of the tile, so that both change together.
        self._tiles[index], self._views[index], self._latest_s[index] = tile, tile.views, tile.latest_s
        return tile

    def _write(self, index: TileIndex) -> None:
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            write_tile(tile_path(self._folder, index), self._tiles[index])
        except OSError as error:
            raise _not_written(self._folder, error) from error
        self._unwritten.discard(index)


def open_map(folder: Path, origin: GeodeticPosition, direction_step: float, carried: Path | None = None) -> GroundMap:
    """Open the map in a folder, begin it with a copy of a former one, or begin an empty one.

    Args:
        folder: folder of its tiles; made with the first flush.
        origin: origin of the mission's frame.
        direction_step: edge of a square of directions; a map that goes on keeps its own.
        carried: folder of a former map of the same origin; one of another origin is left where it is.

    Raises:
        InputDataError: the folder holds a map of another origin, or a file that is none; the text names it.
        RecordingError: the former map cannot be copied.
    """
    if carried is not None and not (folder / HEADER_NAME).exists() and (carried / HEADER_NAME).exists():
        former = read_header(carried)
        if former.origin == origin:
            _copy(carried, folder)
    if not (folder / HEADER_NAME).exists():
        return GroundMap(folder, GroundHeader(origin, direction_step), {})
    stored = read_map(folder)
    if stored.header.origin != origin:
        raise InputDataError(f"{folder}: the map of searched ground belongs to another origin.")
    return stored


def read_map(folder: Path) -> GroundMap:
    """Return the map in a folder as it was written last.

    Raises:
        InputDataError: there is none, or its head is damaged; the text names the file.
    """
    return GroundMap(folder, read_header(folder), dict(_stored_views(folder)))


def read_header(folder: Path) -> GroundHeader:
    """Read the facts about the map in a folder.

    Raises:
        InputDataError: there is none, or the file is damaged; the text names it.
    """
    path = folder / HEADER_NAME
    try:
        content: dict[str, Any] = json.loads(path.read_text("utf-8"))
        header = GroundHeader(
            origin=GeodeticPosition(**content["origin"]),
            direction_step=float(content["direction_step"]),
            frames=int(content["frames"]),
            format=int(content["format"]),
        )
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise InputDataError(f"{path} is not the head of a map of searched ground, or is damaged: {error}") from error
    if header.format != FORMAT:
        raise InputDataError(f"{path}: format {header.format} is unknown; this version reads {FORMAT}.")
    if not (math.isfinite(header.direction_step) and header.direction_step > 0.0):
        raise InputDataError(f"{path}: direction_step must be positive, got {header.direction_step}.")
    return header


def tile_path(folder: Path, index: TileIndex) -> Path:
    """Return the path of a tile."""
    return folder / f"tile_{index[0]}_{index[1]}.npz"


def _shares(projected: GroundView) -> Iterator[tuple[TileIndex, tuple[slice, slice], tuple[slice, slice]]]:
    """Yield the tiles that a frame may show: index, window of the frame's cells of views, window of the tile's."""
    rows, columns = projected.seen.shape
    for tile_row, frame_rows, tile_rows in _stretches(projected.row, rows):
        for tile_column, frame_columns, tile_columns in _stretches(projected.column, columns):
            here = frame_rows, frame_columns
            if projected.seen[here].any():
                yield (tile_row, tile_column), here, (tile_rows, tile_columns)


def _stretches(first: int, count: int) -> Iterator[tuple[int, slice, slice]]:
    """Yield the tiles along one axis: number, stretch of the frame's cells, stretch of the tile's."""
    for tile in range(first // VIEW_CELLS, (first + count - 1) // VIEW_CELLS + 1):
        start, stop = max(first, tile * VIEW_CELLS), min(first + count, (tile + 1) * VIEW_CELLS)
        yield tile, slice(start - first, stop - first), slice(start - tile * VIEW_CELLS, stop - tile * VIEW_CELLS)


def _add_values(
    tile: Tile, bands: tuple[str, ...], projected: GroundView, here: tuple[slice, slice], there: tuple[slice, slice]
) -> None:
    """Add colours and temperatures of a window of a frame's cells to that of a tile."""
    source, target = _finer(here), _finer(there)
    covered, values = projected.covered[source], projected.values[source]
    names = ("grey",) * 3 if "grey" in bands else _COLOUR_BANDS
    if set(names) <= set(bands):
        colours = values[..., [bands.index(name) for name in names]]
        tile.colour_sum[target] += np.where(covered[..., np.newaxis], np.rint(colours).clip(0.0), 0.0).astype(np.uint32)
        tile.colour_count[target] += covered
    if "thermal" in bands:
        tile.thermal_sum[target] += np.where(covered, values[..., bands.index("thermal")], np.float32(0.0))
        tile.thermal_count[target] += covered


def _finer(window: tuple[slice, slice]) -> tuple[slice, slice]:
    """Return the cells of colour of a window of cells of views."""
    rows, columns = window
    return (
        slice(rows.start * COLOURS_PER_CELL, rows.stop * COLOURS_PER_CELL),
        slice(columns.start * COLOURS_PER_CELL, columns.stop * COLOURS_PER_CELL),
    )


def _read_or_drop(path: Path, empty: Tile) -> Tile:
    """Read a tile; one that is damaged counts as not searched."""
    try:
        return read_tile(path, empty.seen.shape[2])
    except InputDataError as error:
        _log.warning("counted as not searched: %s", error)
        return empty


def _stored_views(folder: Path) -> Iterator[tuple[TileIndex, tuple[NDArray[np.uint8], NDArray[np.uint32]]]]:
    for path in sorted(folder.glob("tile_*.npz")):
        try:
            _, row, column = path.stem.split("_")
            yield (int(row), int(column)), read_views(path)
        except (InputDataError, ValueError) as error:
            _log.warning("counted as not searched: %s", error)


def _copy(carried: Path, folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for path in sorted(carried.glob("tile_*.npz")):
            shutil.copyfile(path, folder / path.name)
        # Last: without it the copy counts as none, and is made again.
        shutil.copyfile(carried / HEADER_NAME, folder / HEADER_NAME)
    except OSError as error:
        raise _not_written(folder, error) from error


def _write_header(folder: Path, header: GroundHeader) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    temporary = folder / f"{HEADER_NAME}.part"
    temporary.write_text(json.dumps(asdict(header)), "utf-8")
    temporary.replace(folder / HEADER_NAME)


def _not_written(folder: Path, error: OSError) -> RecordingError:
    return RecordingError(f"The map of searched ground cannot be written to {folder}: {error.strerror or error}.")
