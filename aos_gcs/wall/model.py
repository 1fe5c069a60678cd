"""Tiles of the wall: their names, their pictures, and what is known of the frames that they show."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final, Self

from aos_gcs.geometry.heights import AmslM

PALETTE: Final = "inferno"
"""Colours of temperatures, from black to yellow."""
MAX_TILES: Final = 24
"""Greatest number of tiles that one viewer may watch."""
_NAME: Final = re.compile(r"(all|\d{1,3})\.(colour|thermal)")
_MAX_VEHICLE_ID: Final = 255


class TileKind(StrEnum):
    """Content of a tile."""

    COLOUR = "colour"
    """Or grey."""
    THERMAL = "thermal"


@dataclass(frozen=True, slots=True, order=True)
class TileName:
    """A camera's tile, or one of the integral."""

    vehicle_id: int | None
    """None: the integral of all cameras."""
    kind: TileKind

    def __str__(self) -> str:
        return f"{'all' if self.vehicle_id is None else self.vehicle_id}.{self.kind}"

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the name that a text such as ``3.thermal`` or ``all.colour`` stands for.

        Raises:
            ValueError: it is none; the text says what names look like.
        """
        match = _NAME.fullmatch(text)
        if match is None or (match[1] != "all" and int(match[1]) > _MAX_VEHICLE_ID):
            raise ValueError(f"{text[:40]!r} is no tile; tiles are named 3.colour, 3.thermal, all.colour, all.thermal")
        return cls(None if match[1] == "all" else int(match[1]), TileKind(match[2]))


@dataclass(frozen=True, slots=True)
class WallSettings:
    """Limits of what the wall costs, and when a picture counts as old."""

    rate_hz: float = 2.0
    """Greatest number of pictures per tile and second."""
    width_px: int = 320
    """Width of tiles."""
    follow_width_px: int = 960
    """Width of a tile that fills the screen."""
    stale_s: float = 5.0
    """Age from which a picture is marked as old."""


@dataclass(frozen=True, slots=True)
class ViewedPlace:
    """Place that a picture shows in its middle."""

    latitude_deg: float
    longitude_deg: float
    is_camera: bool = False
    """Whether it is that of the camera, where the middle of the picture shows no ground that is known."""


@dataclass(frozen=True, slots=True)
class FrameFacts:
    """A recorded frame without its image."""

    number: int
    """Number in the record; later frames have greater ones."""
    vehicle_id: int
    utc_s: float
    """Time of exposure."""
    kinds: tuple[TileKind, ...]
    latitude_deg: float
    longitude_deg: float
    altitude_amsl_m: AmslM
    axis_enu: tuple[float, float, float]
    """Direction in which the camera looks, a unit vector."""


@dataclass(frozen=True, slots=True)
class Order:
    """A camera's tile that is due in a size."""

    tile: TileName
    width_px: int
    known: int
    """Number of the camera's newest frame that is known; 0 where there is none."""
    former: int
    """Number of the frame that was rendered last, or could not be; 0 where there is none."""


@dataclass(frozen=True, slots=True)
class ThermalScale:
    """Values of the darkest and the brightest colour of a thermal picture."""

    low: float
    high: float
    is_celsius: bool
    """Whether they are degrees Celsius; else they are the camera's own levels."""


@dataclass(frozen=True, slots=True)
class TilePicture:
    """A picture in the size of a tile."""

    jpeg: bytes = field(repr=False)
    width_px: int
    height_px: int
    scale: ThermalScale | None
    """None for colours, and for temperatures whose scale is relative."""


@dataclass(frozen=True, slots=True)
class RenderedFrame:
    """Orders that one frame was rendered for, one at least."""

    vehicle_id: int
    number: int
    orders: tuple[Order, ...]
    pictures: tuple[TilePicture, ...]
    """One per order; none where the frame is damaged."""
    fault: str = ""


@dataclass(frozen=True, slots=True)
class Look:
    """What one look at the record has found and made."""

    newest: tuple[FrameFacts, ...]
    rendered: tuple[RenderedFrame, ...]
    is_complete: bool
    """Whether all orders were seen to."""


@dataclass(frozen=True, slots=True)
class Slot:
    """Newest picture of a tile in one size."""

    version: int
    """Counts all pictures of the wall: later ones have greater numbers."""
    picture: TilePicture
    utc_s: float
    """Time of the exposure, or of the step."""
    seen_at_s: float
    """Time at which the wall has found it, by its own clock."""
    place: ViewedPlace | None
