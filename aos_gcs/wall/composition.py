"""Pictures of the whole wall, with place and time burnt in: what a video of it consists of."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from math import ceil, sqrt
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.notations import Notation, written
from aos_gcs.wall.model import TileKind, TileName, TilePicture, ViewedPlace

WIDTH_PX: Final = 480
_IMAGE_PX: Final = 360
_CAPTION_PX: Final = 62
_LINE_PX: Final = 19
_FONT: Final = cv2.FONT_HERSHEY_SIMPLEX
_WHITE, _YELLOW, _BLACK = (255, 255, 255), (61, 197, 255), (0, 0, 0)
"""Colours as blue, green and red."""


@dataclass(frozen=True, slots=True)
class Shot:
    """One recorded picture of a tile, still on the disk."""

    utc_s: float
    place: ViewedPlace | None
    load: Callable[[], TilePicture] = field(repr=False)


@dataclass(slots=True)
class PictureSequence:
    """All pictures of one tile in the order of their times."""

    tile: TileName
    shots: Sequence[Shot]
    _index: int = -1
    _scaled: NDArray[np.uint8] | None = None
    _caption: str = ""
    unreadable: int = 0
    """Number of pictures that are damaged, in whose place the one before is shown."""
    _shown: Shot | None = None

    def seek(self, utc_s: float) -> None:
        """Go to the newest picture of a time, not before the one that is shown."""
        index = bisect_right(self.shots, utc_s, key=lambda shot: shot.utc_s) - 1
        if index == self._index:
            return
        self._index = index
        shot = self.shots[index]
        try:
            picture = shot.load()
        except InputDataError:
            self.unreadable += 1
            return
        self._shown, self._scaled, self._caption = shot, _fitted(picture), _scale_text(picture, self.tile.kind)

    def draw(self, canvas: NDArray[np.uint8], utc_s: float, notation: Notation, stale_s: float) -> None:
        """Draw the tile onto its part of the whole, shape (rows, columns, 3)."""
        canvas[:] = 16
        of = "Integral" if self.tile.vehicle_id is None else f"Vehicle {self.tile.vehicle_id}"
        lines = [f"{of}, {self.tile.kind}"]
        if self._shown is None or self._scaled is None:
            lines.append("no image yet")
        else:
            age_s = utc_s - self._shown.utc_s
            is_old = age_s >= stale_s
            canvas[:_IMAGE_PX] = self._scaled // 2 if is_old else self._scaled
            if is_old:
                canvas[_IMAGE_PX - 24 : _IMAGE_PX] = _YELLOW
                _write(canvas, f"OUTDATED IMAGE: {age_s:.0f} s", _IMAGE_PX - 7, _BLACK)
            lines[0] += self._caption
            lines += [_place_text(self._shown.place, notation), f"{_clock(self._shown.utc_s)}, {age_s:.0f} s ago"]
        for number, line in enumerate(lines, start=1):
            _write(canvas, line, _IMAGE_PX + number * _LINE_PX, _WHITE)


def wall_size(tiles: int) -> tuple[int, int]:
    """Return width and height in pixels of the picture of so many tiles."""
    columns = ceil(sqrt(tiles))
    return columns * WIDTH_PX, ceil(tiles / columns) * (_IMAGE_PX + _CAPTION_PX)


def compose(tracks: Sequence[PictureSequence], utc_s: float, notation: Notation, stale_s: float) -> NDArray[np.uint8]:
    """Return the wall at a time, shape (rows, columns, 3), blue, green and red; times must not go back."""
    width_px, height_px = wall_size(len(tracks))
    whole = np.zeros((height_px, width_px, 3), dtype=np.uint8)
    columns = width_px // WIDTH_PX
    for number, track in enumerate(tracks):
        row, column = divmod(number, columns)
        top, left = row * (_IMAGE_PX + _CAPTION_PX), column * WIDTH_PX
        if track.shots and track.shots[0].utc_s <= utc_s:
            track.seek(utc_s)
        track.draw(whole[top : top + _IMAGE_PX + _CAPTION_PX, left : left + WIDTH_PX], utc_s, notation, stale_s)
    return whole


def _fitted(picture: TilePicture) -> NDArray[np.uint8]:
    """Return a picture in the middle of its part, as large as it fits."""
    image = cv2.imdecode(np.frombuffer(picture.jpeg, dtype=np.uint8), cv2.IMREAD_COLOR)
    part = np.zeros((_IMAGE_PX, WIDTH_PX, 3), dtype=np.uint8)
    if image is None:
        return part
    rows, columns = image.shape[:2]
    factor = min(_IMAGE_PX / rows, WIDTH_PX / columns)
    width_px, height_px = max(1, round(columns * factor)), max(1, round(rows * factor))
    top, left = (_IMAGE_PX - height_px) // 2, (WIDTH_PX - width_px) // 2
    part[top : top + height_px, left : left + width_px] = cv2.resize(image, (width_px, height_px))
    return part


def _write(canvas: NDArray[np.uint8], text: str, baseline_px: int, colour: tuple[int, int, int]) -> None:
    """Write a line; OpenCV's letters are those of ASCII."""
    ascii_text = text.replace("\N{DEGREE SIGN}", " ").encode("ascii", "replace").decode()
    cv2.putText(canvas, ascii_text, (8, baseline_px), _FONT, 0.5, colour, 1, cv2.LINE_AA)


def _scale_text(picture: TilePicture, kind: TileKind) -> str:
    if picture.scale is None:
        return ", relative scale" if kind is TileKind.THERMAL else ""
    unit = " C" if picture.scale.is_celsius else ""
    return f", {picture.scale.low:.1f} to {picture.scale.high:.1f}{unit}"


def _place_text(place: ViewedPlace | None, notation: Notation) -> str:
    if place is None:
        return "place unknown"
    text = written(place.latitude_deg, place.longitude_deg, notation)
    return f"camera at {text}" if place.is_camera else text


def _clock(utc_s: float) -> str:
    return datetime.fromtimestamp(utc_s, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
