"""Messages of the wall."""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from aos_gcs.api.models.wall import ThermalScaleModel, TilePictureModel, WallMessage
from aos_gcs.wall.board import Wall
from aos_gcs.wall.model import PALETTE, Slot, TileKind, TileName
from aos_gcs.wall.watch import WallUpdate

SHARED_FOR_S: Final = 0.1
"""Time for which a message is sent to further viewers: its ages are those of its time of sending."""
_MOST_KEPT: Final = 8
_LENGTH: Final = struct.Struct("!I")


@dataclass(frozen=True, slots=True)
class NumberedMessage:
    """A binary message, and the number by which viewers answer it."""

    number: int
    sent_s: float
    """Time of its ages, by the service's clock that never jumps."""
    data: bytes


class WallMessages:
    """Messages to the viewers of a wall, encoded once for all who are to be told the same.

    Args:
        wall: what they watch.
        now_s: clock of the service that never jumps.
    """

    def __init__(self, wall: Wall, now_s: Callable[[], float]) -> None:
        self._wall = wall
        self._now_s = now_s
        self._count = 0
        self._kept: dict[tuple[tuple[int, ...], tuple[int, ...], str], NumberedMessage] = {}

    def message(self, update: WallUpdate, *, refused: str, after: int) -> NumberedMessage:
        """Return the message of an update.

        Args:
            update: what the viewer is to be told.
            refused: why its latest request was refused; empty otherwise.
            after: number of the message that it was sent last; the one that is returned has a greater one.
        """
        # A version stands for one picture of one tile in one size.
        key = _versions(update.pictures), _versions(update.shown), refused
        now_s = self._now_s()
        kept = self._kept.get(key)
        if kept is not None and kept.number > after and now_s - kept.sent_s <= SHARED_FOR_S:
            return kept
        self._count += 1
        made = NumberedMessage(self._count, now_s, self._encode(update, now_s, refused))
        self._kept.pop(key, None)
        self._kept[key] = made
        if len(self._kept) > _MOST_KEPT:
            del self._kept[next(iter(self._kept))]
        return made

    def _encode(self, update: WallUpdate, sent_s: float, refused: str) -> bytes:
        wall = self._wall
        head = WallMessage(
            number=self._count,
            sent_s=round(sent_s, 3),
            live=wall.source.until_utc_s is None,
            stale_s=wall.settings.stale_s,
            rate_hz=wall.settings.rate_hz,
            tiles=list(map(str, wall.tiles())),
            ages_s={str(tile): round(wall.age_s(slot), 2) for tile, slot in update.shown.items()},
            pictures=[_picture(tile, slot) for tile, slot in update.pictures.items()],
            refused=refused,
        )
        text = head.model_dump_json().encode()
        return b"".join([_LENGTH.pack(len(text)), text, *(slot.picture.jpeg for slot in update.pictures.values())])


def _versions(slots: Mapping[TileName, Slot]) -> tuple[int, ...]:
    return tuple(slot.version for slot in slots.values())


def _picture(tile: TileName, slot: Slot) -> TilePictureModel:
    picture, place = slot.picture, slot.place
    scale = picture.scale
    return TilePictureModel(
        tile=str(tile),
        bytes=len(picture.jpeg),
        width_px=picture.width_px,
        height_px=picture.height_px,
        utc_s=slot.utc_s,
        latitude_deg=None if place is None else place.latitude_deg,
        longitude_deg=None if place is None else place.longitude_deg,
        at_camera=place is not None and place.is_camera,
        palette=PALETTE if tile.kind is TileKind.THERMAL else None,
        scale=None
        if scale is None
        else ThermalScaleModel(low=round(scale.low, 2), high=round(scale.high, 2), celsius=scale.is_celsius),
    )
