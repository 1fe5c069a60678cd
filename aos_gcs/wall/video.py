"""Videos of the wall for the API: one at a time, made of the record while everything else goes on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from aos_gcs.geometry.notations import Notation
from aos_gcs.wall.model import TileName


class VideoPhase(StrEnum):
    """What there is of a video."""

    NONE = "none"
    """None was asked for, or it was given up."""
    MAKING = "making"
    READY = "ready"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class VideoState:
    """State of the video that was asked for last."""

    phase: VideoPhase = VideoPhase.NONE
    number: int = 0
    """Counts the videos that were asked for; 0 before the first."""
    done: float = 0.0
    """Share of the pictures that are written, 0 to 1."""
    tiles: tuple[TileName, ...] = ()
    """Tiles of a video that is ready."""
    duration_s: float = 0.0
    """Duration of a video that is ready."""
    bytes: int = 0
    """Size of a video that is ready."""
    unreadable: int = 0
    """Number of recorded pictures that could not be read."""
    reason: str = ""
    """Why it failed."""


class VideoControl(Protocol):
    """Videos of the wall for the API."""

    async def run(self) -> None:
        """Make what is asked for, until cancelled."""
        ...

    def state(self) -> VideoState:
        """Return what there is."""
        ...

    def begin(self, tiles: Sequence[TileName], notation: Notation) -> VideoState:
        """Begin a video of the record so far, which takes the place of the one before.

        Args:
            tiles: tiles in the order of the grid; none: all of the record, at most 24.
            notation: notation of the places.

        Raises:
            ConfigurationError: the library for video is not installed.
            ViewerBusyError: one is being made.
        """
        ...

    def give_up(self) -> VideoState:
        """End what is being made, or remove what is ready."""
        ...

    def read(self) -> tuple[int, Iterator[bytes]] | None:
        """Return the size and the parts of the video; None where none is ready.

        The parts stay readable when the video is removed meanwhile; they must be read to the end or closed.
        """
        ...
