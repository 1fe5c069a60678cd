"""Videos for the page: not made, only told of as a test says."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator, Sequence
from dataclasses import replace

from aos_gcs.geometry.notations import Notation
from aos_gcs.mission.viewing import ViewerBusyError
from aos_gcs.wall.model import TileName
from aos_gcs.wall.video import VideoPhase, VideoState


class ScriptedVideos:
    """Implements ``VideoControl``; a test moves it on."""

    FILE = b"\0\0\0\x18ftypisom scripted"

    def __init__(self) -> None:
        self.shown = VideoState()
        self.asked: list[tuple[tuple[TileName, ...], Notation]] = []

    async def run(self) -> None:
        """Do nothing until cancelled."""
        await asyncio.Event().wait()

    def state(self) -> VideoState:
        """Return what the test has said."""
        return self.shown

    def begin(self, tiles: Sequence[TileName], notation: Notation) -> VideoState:
        """Begin one, unless one is being made."""
        if self.shown.phase is VideoPhase.MAKING:
            raise ViewerBusyError("A video is being made already; try again in a moment.")
        self.asked.append((tuple(tiles), notation))
        self.shown = VideoState(VideoPhase.MAKING, self.shown.number + 1)
        return self.shown

    def give_up(self) -> VideoState:
        """Give it up."""
        self.shown = VideoState(number=self.shown.number)
        return self.shown

    def read(self) -> tuple[int, Iterator[bytes]] | None:
        """Return the file where it is ready."""
        return (len(self.FILE), iter([self.FILE])) if self.shown.phase is VideoPhase.READY else None

    # --- for tests

    def advance(self, done: float) -> None:
        """Have a share of it done."""
        self.shown = replace(self.shown, done=done)

    def finish(self) -> None:
        """Have it ready."""
        size = len(self.FILE)
        self.shown = replace(self.shown, phase=VideoPhase.READY, done=1.0, duration_s=83.0, bytes=size)

    def fail(self, reason: str) -> None:
        """Have it failed."""
        self.shown = replace(self.shown, phase=VideoPhase.FAILED, reason=reason)
