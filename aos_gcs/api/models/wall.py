"""Messages of the WebSocket ``/api/wall``, and videos of the wall.

The service sends binary messages: the length of the head in four bytes, most significant first, the head as JSON
(``WallMessage``), and the JPEG files that it names, one behind the other. Clients send text: ``WallRequest`` to choose
tiles, and ``WallAnswer`` when they have shown a message. The next message comes after that answer only, with what is
the newest by then: pictures never queue on a slow link.
"""

from __future__ import annotations

from typing import Annotated, Final, Literal

from pydantic import Field, StrictBool, TypeAdapter

from aos_gcs.api.models.base import WireModel
from aos_gcs.geometry.notations import Notation
from aos_gcs.wall.video import VideoPhase

TileText = Annotated[str, Field(max_length=12, description="3.colour, 3.thermal, all.colour or all.thermal.")]


class WallRequest(WireModel):
    """Tiles that this client watches from now on."""

    kind: Literal["watch"] = "watch"
    tiles: Annotated[list[TileText], Field(max_length=64)]
    large: StrictBool = Field(default=False, description="Whether the one tile comes in the size for a full screen.")
    rate_hz: float | None = Field(
        default=None, gt=0.0, le=100.0, allow_inf_nan=False, description="Pictures per tile and second, at most."
    )


class WallAnswer(WireModel):
    """A message was received and shown."""

    kind: Literal["shown"] = "shown"
    number: int


class ThermalScaleModel(WireModel):
    """Values of the darkest and the brightest colour."""

    low: float
    high: float
    celsius: bool = Field(description="Whether they are degrees Celsius; else levels of the camera.")


class TilePictureModel(WireModel):
    """A picture that follows the head."""

    tile: str
    bytes: int = Field(description="Length of its JPEG file.")
    width_px: int
    height_px: int
    utc_s: float = Field(description="Time of the exposure; of an integral, of its step.")
    latitude_deg: float | None = Field(description="Place in the middle of the picture; null while unknown.")
    longitude_deg: float | None
    at_camera: bool = Field(description="Whether that is the place of the camera, since it shows no known ground.")
    palette: str | None = Field(description="Colours of temperatures; null for other pictures.")
    scale: ThermalScaleModel | None = Field(description="Null where colours are relative.")


class WallMessage(WireModel):
    """Head of a message of the wall."""

    number: int = Field(description="Counts the messages to all clients; the answer names it.")
    sent_s: float = Field(description="Time of the ages, by a clock of the service that never jumps.")
    live: bool = Field(description="Whether time goes on by itself; false in a replay.")
    stale_s: float = Field(description="Age from which pictures are to be marked as old.")
    rate_hz: float = Field(description="Pictures per tile and second, at most.")
    tiles: list[str] = Field(description="All tiles that there are.")
    ages_s: dict[str, float] = Field(description="Age of what each watched tile shows.")
    pictures: list[TilePictureModel]
    refused: str = Field(description="Why the latest request was refused; empty otherwise.")


class VideoRequest(WireModel):
    """A video to make of the record so far."""

    tiles: Annotated[list[TileText], Field(max_length=64)] = Field(
        default_factory=list, description="In the order of the grid; none: all of the record, at most 24."
    )
    notation: Notation = Field(default=Notation.DECIMAL, description="Notation of the places in the video.")


class VideoModel(WireModel):
    """State of the video that was asked for last."""

    phase: VideoPhase
    number: int = Field(description="Counts the videos that were asked for; 0 before the first.")
    done: float = Field(description="Share of the pictures that are written, 0 to 1.")
    tiles: list[str] = Field(description="Tiles of a video that is ready.")
    duration_s: float
    bytes: int = Field(description="Size of a video that is ready.")
    unreadable: int = Field(description="Number of recorded pictures that could not be read.")
    reason: str = Field(description="Why it failed; empty otherwise.")


WALL_CLIENT_MESSAGE: Final[TypeAdapter[WallRequest | WallAnswer]] = TypeAdapter(
    Annotated[WallRequest | WallAnswer, Field(discriminator="kind")]
)
WALL_MESSAGE: Final[TypeAdapter[WallMessage]] = TypeAdapter(WallMessage)
