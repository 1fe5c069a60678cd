"""Messages of the wall."""

from __future__ import annotations

import struct
from typing import Final

from aos_gcs.api.models.wall import ThermalScaleModel, TilePictureModel, WallMessage
from aos_gcs.wall.model import PALETTE, Slot, TileKind, TileName, WallSettings
from aos_gcs.wall.watch import WallUpdate

_LENGTH: Final = struct.Struct("!I")


def wall_message(
    update: WallUpdate, settings: WallSettings, *, number: int, sent_s: float, is_live: bool, refused: str
) -> bytes:
    """Return the binary message of an update: head and pictures."""
    head = WallMessage(
        number=number,
        sent_s=round(sent_s, 3),
        live=is_live,
        stale_s=settings.stale_s,
        rate_hz=settings.rate_hz,
        tiles=list(map(str, update.tiles)),
        ages_s={str(tile): round(age_s, 2) for tile, age_s in update.ages_s.items()},
        pictures=[_picture(tile, slot) for tile, slot in update.pictures.items()],
        refused=refused,
    )
    text = head.model_dump_json().encode()
    return b"".join([_LENGTH.pack(len(text)), text, *(slot.picture.jpeg for slot in update.pictures.values())])


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
