"""Source of the wall: the mission that is shown, in flight or replayed, and its record."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.mission.control import MissionView
from aos_gcs.mission.model.steps import Picture, PictureKind


class ReplayedTime(Protocol):
    """Time of a replay."""

    @property
    def utc_s(self) -> float:
        """Present time in the recording."""
        ...


class WallSource:
    """What the wall takes its pictures from.

    Args:
        mission: mission that is shown.
        folder: returns its folder; another one when a replay shows another sortie.
        utc_s: clock of this machine.
        replay: replay of the mission; None for one in flight.
    """

    def __init__(
        self,
        mission: MissionView,
        folder: Callable[[], Path],
        utc_s: Callable[[], float],
        replay: ReplayedTime | None = None,
    ) -> None:
        self._mission = mission
        self._folder = folder
        self._utc_s = utc_s
        self._replay = replay
        self._ahead_s = 0.0

    @property
    def folder(self) -> Path:
        """Folder of the mission's record."""
        return self._folder()

    @property
    def until_utc_s(self) -> float | None:
        """Time until which frames are shown; None: all that there are."""
        return None if self._replay is None else self._replay.utc_s

    def now_utc_s(self) -> float:
        """Return the mission's present time: simulated ones run ahead of this machine's clock."""
        return self._utc_s() + self._ahead_s if self._replay is None else self._replay.utc_s

    async def follow(self) -> None:
        """Follow the mission's clock until cancelled."""
        with self._mission.subscribe() as events:
            async for event in events:
                if event.utc_s > 0.0:  # others are made by the bridge
                    self._ahead_s = event.utc_s - self._utc_s()

    def picture(self, kind: PictureKind) -> Picture | None:
        """Return the latest raster of a kind, if there is one."""
        with suppress(OSError):  # of a record that has gone
            return self._mission.picture(kind)
        return None

    def picture_utc_s(self, picture: Picture) -> float:
        """Return the time of the step that a raster shows; now, for one whose step has not been told yet."""
        started_utc_s = self._mission.snapshot().started_utc_s
        for step in reversed(self._mission.steps()):
            if step.step == picture.step and started_utc_s is not None:
                return started_utc_s + step.elapsed_s
        return self.now_utc_s()

    def ground_amsl_m(self) -> float | None:
        """Return the height of the mission's focal plane above mean sea level; None while it is unknown."""
        snapshot = self._mission.snapshot()
        if snapshot.origin is None:
            return None
        return snapshot.origin.altitude_amsl_m + (0.0 if snapshot.focus is None else snapshot.focus.height_m)

    def origin(self) -> GeodeticPosition | None:
        """Return the mission's origin; None while it is unknown."""
        return self._mission.snapshot().origin
