"""Packets of a vehicle that cannot be taken in, by a defect of this program: each costs itself and no other."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterable

from pymavlink.dialects.v20 import ardupilotmega as mavlink

_log = logging.getLogger(__name__)

_PAUSE_S = 60.0
"""Time between two notices: the same report may fail many times a second."""


class ReportFailures:
    """Number and latest reason of what was lost of one vehicle, or of nobody in particular."""

    def __init__(self) -> None:
        self.count = 0
        self._latest: tuple[str, Exception] | None = None
        """Name and error of the latest one that has not been told yet."""
        self._told_at_s = -math.inf

    def take_in(
        self,
        reports: Iterable[tuple[mavlink.MAVLink_message, float]],
        update: Callable[[mavlink.MAVLink_message, float], None],
    ) -> None:
        """Call ``update`` for each report with its time; go on with the next one after an error."""
        for message, at_s in reports:
            try:
                update(message, at_s)
            except Exception as error:  # whatever it is: the other reports tell where the vehicle is
                self.note(message.get_type(), error)

    def note(self, name: str, error: Exception) -> None:
        """Count an error at something named."""
        self.count += 1
        self._latest = name, error

    def text(self, now_s: float) -> str | None:
        """Return, at most once a minute, what has failed since the last text, for a notice; log it with its trace."""
        if self._latest is None or now_s - self._told_at_s < _PAUSE_S:
            return None
        (name, error), self._latest, self._told_at_s = self._latest, None, now_s
        _log.error("%s has failed", name, exc_info=error)
        return (
            f"this station failed at {self.count} packets or requests so far, at last {name}: {error!r}. All others "
            "count: compare what is shown with the vehicle, and return it if in doubt"
        )
