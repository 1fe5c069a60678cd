"""All channels of a mission: each gets the newest state, and the flight's process hears how they do."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from typing import NoReturn, Protocol

from aos_gcs.errors import AosError, ConfigurationError
from aos_gcs.mission.control import MissionView
from aos_gcs.mission.model.events import JumpRecord, NoticeRecord
from aos_gcs.mission.model.sharing import ChannelStatus
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.sharing.channel import Channel
from aos_gcs.sharing.heights import undulations
from aos_gcs.sharing.settings import SharingSettings, TakTransport
from aos_gcs.sharing.state import SeenState
from aos_gcs.sharing.tak.channel import TakChannel
from aos_gcs.sharing.tak.connection import tls_context

TELL_S = 1.0
"""Interval in which the states of the channels are told."""


class Source(MissionView, Protocol):
    """A mission in another process, and where the states of live sharing are told."""

    heard_at_s: float
    """Time at which the mission last published its state, in real seconds of a clock that processes share."""

    def tell_sharing(self, statuses: tuple[ChannelStatus, ...]) -> None:
        """Tell the flight's process the states of live sharing."""
        ...


def check_sharing(settings: SharingSettings) -> None:
    """Refuse what cannot be used, before anything is opened.

    Raises:
        ConfigurationError: a file cannot be used; the text names the field.
    """
    if settings.tak is None:
        return
    try:
        undulations(settings.tak.geoid)
    except AosError as error:
        raise ConfigurationError(f"tak.geoid: {error}") from error
    if settings.tak.transport is TakTransport.TLS:
        tls_context(settings.tak)


def make_channels(
    settings: SharingSettings, now_s: Callable[[], float], utc_s: Callable[[], float]
) -> tuple[Channel, ...]:
    """Return the channels of a mission.

    Args:
        settings: systems to share with.
        now_s: real seconds of the clock that the processes share.
        utc_s: clock for people.
    """
    channels: list[Channel] = []
    if settings.tak is not None:
        channels.append(TakChannel(settings.tak, undulations(settings.tak.geoid), now_s, utc_s))
    return tuple(channels)


async def share(source: Source, channels: Sequence[Channel]) -> NoReturn:
    """Run all channels until cancelled.

    Args:
        source: mission to share.
        channels: systems to share with.
    """
    with source.subscribe() as events:
        state = SeenState(source.snapshot(), source.heard_at_s)
        for channel in channels:
            channel.put(state)
        async with asyncio.TaskGroup() as group:
            for channel in channels:
                group.create_task(channel.run())
            group.create_task(_tell(source, channels))
            async for event in events:
                if isinstance(event.data, MissionSnapshot | JumpRecord):
                    state = SeenState(source.snapshot(), source.heard_at_s)
                    for channel in channels:
                        channel.put(state)
                elif isinstance(event.data, NoticeRecord):
                    for channel in channels:
                        channel.take(event.data)
    raise AssertionError("the events of a mission in another process do not end")


async def _tell(source: Source, channels: Sequence[Channel]) -> NoReturn:
    while True:
        source.tell_sharing(tuple(channel.status for channel in channels))
        await asyncio.sleep(TELL_S)
