"""A viewer of the wall: what it watches, and what it was sent last."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final, Protocol

from aos_gcs.errors import InputDataError
from aos_gcs.wall.model import MAX_TILES, Slot, TileName, WallSettings

HEARTBEAT_S: Final = 1.0
"""Longest silence: ages go on, and a page that hears nothing for longer knows that it is cut off."""
MIN_RATE_HZ: Final = 0.1
_SHORTEST_WAIT_S: Final = 0.001
"""A shorter one may end before the time that it waits for, by the rounding of times."""
EARLY: Final = 0.9
"""Share of the interval between two pictures of a tile after which the next one is due."""


@dataclass(frozen=True, slots=True)
class WallUpdate:
    """What a viewer is to be told."""

    pictures: Mapping[TileName, Slot]
    """Tiles with newer pictures than the viewer has."""
    shown: Mapping[TileName, Slot]
    """What each watched tile shows; tiles without a picture are left out."""


class Tiles(Protocol):
    """Tiles as viewers see them."""

    settings: WallSettings

    @property
    def gap_s(self) -> float:
        """Shortest time between two messages with pictures to a viewer."""
        ...

    def slot(self, tile: TileName, *, is_large: bool) -> Slot | None:
        """Return the newest picture of a tile; None while there is none."""
        ...


class Watch:
    """One viewer; made by ``Wall.watch``."""

    def __init__(self, wall: Tiles, now_s: Callable[[], float]) -> None:
        self._wall = wall
        self._now_s = now_s
        self._changed = asyncio.Event()
        self._sent: dict[TileName, tuple[int, float]] = {}
        """Version that each tile was sent last, and when."""
        self._sent_at_s = -math.inf
        self._told_at_s = -math.inf
        self._rate_hz = wall.settings.rate_hz
        self.tiles: tuple[TileName, ...] = ()
        self.is_large = False

    def choose(self, tiles: tuple[TileName, ...], *, is_large: bool = False, rate_hz: float | None = None) -> None:
        """Watch these tiles from now on, at most so often per second as wanted and as the settings allow.

        Raises:
            InputDataError: there are too many, or more than one large one.
        """
        if len(tiles) > MAX_TILES:
            raise InputDataError(f"tiles: at most {MAX_TILES} can be watched at a time, not {len(tiles)}")
        if is_large and len(tiles) > 1:
            raise InputDataError("large: only a single tile can be watched in this size")
        most_hz = self._wall.settings.rate_hz
        self._rate_hz = most_hz if rate_hz is None else min(most_hz, max(MIN_RATE_HZ, rate_hz))
        if is_large != self.is_large:
            self._sent.clear()
        self.tiles, self.is_large = tuple(dict.fromkeys(tiles)), is_large
        self._sent = {tile: sent for tile, sent in self._sent.items() if tile in tiles}
        self.nudge_now()

    def nudge(self) -> None:
        """Note that there may be something new. Until the next message is allowed, that is not looked at."""
        if self._now_s() >= self._free_s:
            self._changed.set()

    def nudge_now(self) -> None:
        """Have the next message go out at once, with or without pictures."""
        self._told_at_s = -math.inf
        self._changed.set()

    async def take(self) -> WallUpdate:
        """Wait for newer pictures of tiles that are due by the rate; without any, until a heartbeat is due."""
        while True:
            self._changed.clear()
            now_s, free_s = self._now_s(), self._free_s
            newer = self._newer()
            due_s = {tile: max(free_s, self._due_s(tile)) for tile in newer}
            due = {tile: slot for tile, slot in newer.items() if now_s >= due_s[tile]}
            if due:
                self._sent_at_s = now_s
                self._sent |= {tile: (slot.version, now_s) for tile, slot in due.items()}
                return self._told(due)
            beat_s = self._told_at_s + HEARTBEAT_S
            if now_s >= beat_s:
                return self._told({})
            until_s = min([beat_s, *([free_s] if now_s < free_s else due_s.values())])
            try:
                async with asyncio.timeout(max(_SHORTEST_WAIT_S, until_s - now_s)):
                    await self._changed.wait()
            except TimeoutError:
                continue

    @property
    def _free_s(self) -> float:
        """Time from which the next message with pictures is allowed."""
        return self._sent_at_s + self._wall.gap_s

    def _newer(self) -> dict[TileName, Slot]:
        return {tile: slot for tile, slot in self._shown() if slot.version != self._last(tile)[0]}

    def _shown(self) -> Iterator[tuple[TileName, Slot]]:
        for tile in self.tiles:
            if (slot := self._wall.slot(tile, is_large=self.is_large)) is not None:
                yield tile, slot

    def _due_s(self, tile: TileName) -> float:
        return self._last(tile)[1] + EARLY / self._rate_hz

    def _last(self, tile: TileName) -> tuple[int, float]:
        return self._sent.get(tile, (0, -math.inf))

    def _told(self, pictures: Mapping[TileName, Slot]) -> WallUpdate:
        self._told_at_s = self._now_s()
        return WallUpdate(pictures, dict(self._shown()))
