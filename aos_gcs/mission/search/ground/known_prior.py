"""The prior and the segments of a mission in flight: read once, as their files may change or go."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.mission.journal import Journal
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Severity
from aos_gcs.prior.file import Polygon, prior_over
from aos_gcs.prior.model import AreaPrior
from aos_gcs.prior.segments import Segment, segments_about


class KnownPrior:
    """Prior within the search area of the settings that a mission flies by, and its segments.

    Args:
        settings: returns these settings.
        journal: tells operators when a file cannot be used.
    """

    def __init__(self, settings: Callable[[], MissionSettings], journal: Journal) -> None:
        self._settings = settings
        self._journal = journal
        self._read: tuple[tuple[str, GeodeticPosition, Polygon], AreaPrior | None] | None = None
        """What was read, and for what."""
        self._segments: tuple[tuple[str, GeodeticPosition], tuple[Segment, ...]] | None = None

    async def over(self, origin: GeodeticPosition) -> AreaPrior | None:
        """Return the prior; None where there is none, or it cannot be used any more: then all places are as likely.

        Args:
            origin: origin of the mission's frame.
        """
        settings = self._settings()
        name, area_enu_m = settings.search.prior, settings.area_enu_m
        if name is None or not area_enu_m:
            return None
        if self._read is not None and self._read[0] == (name, origin, area_enu_m):
            return self._read[1]
        prior = None
        try:
            prior = await asyncio.to_thread(prior_over, name, origin, area_enu_m)
        except (ConfigurationError, InputDataError) as error:
            text = f"The prior cannot be used, all places count as equally likely: {error}"
            self._journal.notice(Severity.WARNING, text)
        self._read = ((name, origin, area_enu_m), prior)
        return prior

    async def segments(self, origin: GeodeticPosition) -> tuple[Segment, ...]:
        """Return the segments; none where none are named, or their file cannot be used any more.

        Args:
            origin: origin of the mission's frame.
        """
        name = self._settings().search.segments
        if name is None:
            return ()
        if self._segments is not None and self._segments[0] == (name, origin):
            return self._segments[1]
        segments: tuple[Segment, ...] = ()
        try:
            segments = await asyncio.to_thread(segments_about, name, origin)
        except InputDataError as error:
            self._journal.notice(Severity.WARNING, f"The segments cannot be used: {error}")
        self._segments = ((name, origin), segments)
        return segments
