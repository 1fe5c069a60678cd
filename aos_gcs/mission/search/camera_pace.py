"""Pace of each camera in flight, and the choice between interval capture and requests."""

from __future__ import annotations

from dataclasses import dataclass

from aos_gcs.imaging.model import IntervalCapture
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.journal import Announcer
from aos_gcs.ports import Severity

WINDOW_S = 10.0
"""Least time over which the pace of a camera is judged, ..."""
_WINDOW_PERIODS = 5.0
"""... and the periods of its rate that have to fit into it."""
SLOW = 0.5
"""Share of the wanted rate below which a camera is slow."""


@dataclass(slots=True)
class _Window:
    begin_s: float
    frames: int = 0


class CameraPace:
    """Judges the pace of the cameras of one mission, and says once of each what is wrong with it.

    Single images are requested from a camera whose interval capture is too slow: many have a least time between two
    images of an interval.

    Args:
        settings: wanted rate, and whether cameras may take images by themselves.
        journal: told of slow cameras, and of those that take images on request only.
    """

    def __init__(self, settings: ImagingSettings, journal: Announcer) -> None:
        self._rate_hz = settings.rate_hz
        self._is_interval_wanted = settings.interval_capture is IntervalCapture.AUTO
        self._journal = journal
        self._without_interval: set[int] = set()
        self._windows: dict[int, _Window] = {}
        self._named: set[int] = set()

    def takes_interval(self, vehicle_id: int) -> bool:
        """Return whether to have a camera take images by itself."""
        return self._is_interval_wanted and vehicle_id not in self._without_interval

    def give_up_interval(self, vehicle_id: int, reason: str) -> None:
        """Request single images from a camera for the rest of the mission."""
        if vehicle_id not in self._without_interval:
            self._without_interval.add(vehicle_id)
            text = f"each image of its camera is requested, without interval capture: {reason}"
            self._journal.notice(Severity.INFO, text, vehicle_id)

    def begin(self, vehicle_id: int, now_s: float) -> None:
        """Note that a camera begins to take frames in flight."""
        self._windows[vehicle_id] = _Window(now_s)

    def note_frame(self, vehicle_id: int, now_s: float) -> None:
        """Note a frame that can be used; act where too few have come."""
        window = self._windows[vehicle_id]
        window.frames += 1
        span_s = now_s - window.begin_s
        if span_s < max(WINDOW_S, _WINDOW_PERIODS / self._rate_hz):
            return
        self.begin(vehicle_id, now_s)
        pace_hz = window.frames / span_s
        if pace_hz >= SLOW * self._rate_hz:
            return
        if self.takes_interval(vehicle_id):
            self.give_up_interval(vehicle_id, f"{pace_hz:.1f} images per second instead of {self._rate_hz:g}")
        elif vehicle_id not in self._named:
            self._named.add(vehicle_id)
            text = f"its camera delivers {pace_hz:.1f} images per second instead of {self._rate_hz:g}"
            self._journal.notice(Severity.WARNING, text, vehicle_id)
