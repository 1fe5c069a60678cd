"""Video of the wall, made of the record of a mission."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from math import ceil
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.extras import load_extra
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.notations import Notation
from aos_gcs.mission.model.events import EventKind, PicturesRecord
from aos_gcs.mission.model.steps import Picture, PictureKind
from aos_gcs.store.reader import MissionReader
from aos_gcs.wall.composition import WIDTH_PX, PictureSequence, Shot, compose, wall_size
from aos_gcs.wall.model import MAX_TILES, FrameFacts, TileKind, TileName, TilePicture, WallSettings
from aos_gcs.wall.places import raster_place, viewed_place
from aos_gcs.wall.rendering import frame_facts, render_frame, render_raster

RATE_HZ: Final = 2
"""Pictures of the wall per second; the video runs as fast as the mission did."""
LONGEST_S: Final = 6 * 3600
"""Longest video; a record whose times are farther apart is damaged."""
_CODECS: Final = ("libx264", "mpeg4")
"""Encoders, the best one first; not every build of the library has all."""
_RASTERS: Final = {PictureKind.INTEGRAL: TileKind.COLOUR, PictureKind.THERMAL: TileKind.THERMAL}


@dataclass(frozen=True, slots=True)
class VideoFacts:
    """What a video holds."""

    tiles: tuple[TileName, ...]
    duration_s: float
    unreadable: int
    """Number of recorded pictures that could not be read."""


def write_wall_video(
    folder: Path,
    file: BinaryIO,
    tiles: Sequence[TileName] = (),
    notation: Notation = Notation.DECIMAL,
    note: Callable[[float], None] | None = None,
    *,
    threads: int = 0,
) -> VideoFacts:
    """Write the wall of a mission folder as an MP4, with place, time and age of each picture burnt in.

    Args:
        folder: mission folder, also of a mission that is in flight.
        file: file to write, which can be sought in.
        tiles: tiles in the order of the grid; none: all of the record, at most 24.
        notation: notation of the places.
        note: called after each picture with the share that is done, 0 to 1; what it raises ends the work.
        threads: threads of the encoder; 0: as many as it likes.

    Raises:
        ConfigurationError: the library for video is not installed, or the record has no such tile.
        InputDataError: the record is damaged, or has no pictures.
        OSError: the file cannot be written.
    """
    av = load_extra("av", "video", "A video of the wall")
    with MissionReader(folder) as reader:
        shots = _shots(reader)
    tracks = [PictureSequence(tile, shots[tile]) for tile in _chosen(shots, tiles, folder)]
    begin_s = min(track.shots[0].utc_s for track in tracks)
    end_s = max(track.shots[-1].utc_s for track in tracks)
    if end_s - begin_s > LONGEST_S:
        raise InputDataError(f"{folder}: the pictures lie more than {LONGEST_S // 3600} h apart; the times are damaged")
    pictures = ceil((end_s - begin_s) * RATE_HZ) + RATE_HZ
    stale_s = WallSettings().stale_s

    def whole() -> Iterator[NDArray[np.uint8]]:
        for number in range(pictures):
            yield compose(tracks, begin_s + number / RATE_HZ, notation, stale_s)
            if note is not None:
                note((number + 1) / pictures)

    output = _Output(file)
    try:
        _encode(av, output, wall_size(len(tracks)), whole(), threads)
    except av.error.FFmpegError as error:
        cause = output.failure or error
        raise OSError(cause.errno, f"the video cannot be written: {cause.strerror}") from error
    unreadable = sum(track.unreadable for track in tracks)
    return VideoFacts(tuple(track.tile for track in tracks), pictures / RATE_HZ, unreadable)


def _chosen(shots: dict[TileName, list[Shot]], tiles: Sequence[TileName], folder: Path) -> Sequence[TileName]:
    if not shots:
        raise InputDataError(f"{folder} has no pictures; they come with the first step of a search")
    missing = [str(tile) for tile in tiles if tile not in shots]
    if missing:
        there = ", ".join(map(str, sorted(shots, key=_order)))
        raise ConfigurationError(f"The record has no tile {', '.join(missing)}; it has {there}.")
    if len(tiles) > MAX_TILES:
        raise ConfigurationError(f"A video has {MAX_TILES} tiles at most, not {len(tiles)}.")
    return list(dict.fromkeys(tiles)) or sorted(shots, key=_order)[:MAX_TILES]


def _order(tile: TileName) -> tuple[int, str]:
    return -1 if tile.vehicle_id is None else tile.vehicle_id, tile.kind


def _shots(reader: MissionReader) -> dict[TileName, list[Shot]]:
    """Return all recorded pictures by tile, in the order of their times."""
    snapshot = reader.last_snapshot()
    origin = None if snapshot is None else snapshot.origin
    height_m = 0.0 if snapshot is None or snapshot.focus is None else snapshot.focus.height_m
    ground_amsl_m = None if origin is None else origin.altitude_amsl_m + height_m
    found: dict[TileName, list[Shot]] = {}
    for entry in reader.frames():
        facts = frame_facts(entry)
        for kind in facts.kinds:
            shot = Shot(facts.utc_s, viewed_place(facts, ground_amsl_m), partial(_frame, reader.folder, facts, kind))
            found.setdefault(TileName(facts.vehicle_id, kind), []).append(shot)
    for tile, shot in _rasters(reader, origin):
        found.setdefault(tile, []).append(shot)
    return {tile: sorted(shots, key=lambda shot: shot.utc_s) for tile, shots in found.items()}


def _rasters(reader: MissionReader, origin: GeodeticPosition | None) -> Iterator[tuple[TileName, Shot]]:
    for event in reader.events(EventKind.PICTURES):
        record = event.data
        if not isinstance(record, PicturesRecord):
            continue
        bounds_m = record.west_m, record.south_m, record.east_m, record.north_m
        for kind in record.kinds:
            if kind in _RASTERS:
                place = raster_place(Picture(kind, record.step, b"", *bounds_m), origin)
                load = partial(_raster, reader.folder, record.step, kind)
                yield TileName(None, _RASTERS[kind]), Shot(event.utc_s, place, load)


def _frame(folder: Path, facts: FrameFacts, kind: TileKind) -> TilePicture:
    (picture,) = render_frame(folder, facts.number, [(kind, WIDTH_PX)])
    return picture


def _raster(folder: Path, step: int, kind: PictureKind) -> TilePicture:
    with MissionReader(folder) as reader:
        png = reader.picture(step, kind)
    return render_raster(png or b"", WIDTH_PX)


class _Output:
    """A file that remembers why it could not be written: the library has words of its own for that."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.seek = file.seek
        self.tell = file.tell
        self.failure: OSError | None = None

    def write(self, data: bytes) -> int:
        """Write to the file."""
        try:
            return self._file.write(data)
        except OSError as error:
            self.failure = self.failure or error
            raise


def _encode(
    av: Any, file: _Output, size_px: tuple[int, int], pictures: Iterator[NDArray[np.uint8]], threads: int
) -> None:
    codec = next((name for name in _CODECS if name in av.codecs_available), None)
    if codec is None:
        raise ConfigurationError(f"This build of the library av has none of the encoders {', '.join(_CODECS)}.")
    with av.open(file, "w", format="mp4") as container:
        stream = container.add_stream(codec, rate=Fraction(RATE_HZ))
        stream.width, stream.height = size_px
        stream.pix_fmt = "yuv420p"
        stream.codec_context.thread_count = threads
        if codec == _CODECS[0]:
            stream.options = {"crf": "25", "preset": "veryfast"}
        for picture in pictures:
            for packet in stream.encode(av.VideoFrame.from_ndarray(picture, format="bgr24")):
                container.mux(packet)
        for packet in stream.encode():
            container.mux(packet)
