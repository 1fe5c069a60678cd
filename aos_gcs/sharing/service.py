"""All channels of a mission: each gets the newest state, and the flight's process hears how they do."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NoReturn, Protocol

from aos_gcs.errors import AosError, ConfigurationError
from aos_gcs.mission.control import MissionView
from aos_gcs.mission.model.events import EventData, JumpRecord, NoticeRecord
from aos_gcs.mission.model.proposals import Proposal
from aos_gcs.mission.model.sharing import ChannelStatus
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.sharing.caltopo.channel import MapChannel, PositionChannel
from aos_gcs.sharing.caltopo.requests import Credential
from aos_gcs.sharing.channel import Channel
from aos_gcs.sharing.heights import undulations
from aos_gcs.sharing.http import Client, https_context
from aos_gcs.sharing.secrets import read_secret
from aos_gcs.sharing.settings import CaltopoSettings, SharingSettings, TakSettings, TakTransport
from aos_gcs.sharing.state import SeenState
from aos_gcs.sharing.tak.channel import TakChannel
from aos_gcs.sharing.tak.connection import tls_context
from aos_gcs.sharing.webhook.channel import WebhookChannel

WEBHOOK_SECRET = "AOS_GCS_WEBHOOK_SECRET"  # noqa: S105 - the name of the variable
CONNECT_KEY = "AOS_GCS_CALTOPO_CONNECT_KEY"
CALTOPO_SECRET = "AOS_GCS_CALTOPO_SECRET"  # noqa: S105 - the name of the variable
NEWS_S = 120.0
"""Age of a notice from which it is not passed on any more by a process that has just begun."""
TELL_S = 1.0
"""Interval in which the states of the channels are told."""


class Source(MissionView, Protocol):
    """A mission in another process, and where the states of live sharing are told."""

    heard_at_s: float
    """Time at which the mission last published its state, in real seconds of a clock that processes share."""

    notices: list[NoticeRecord]
    """Notices so far that are kept."""

    def tell_sharing(self, statuses: tuple[ChannelStatus, ...]) -> None:
        """Tell the flight's process the states of live sharing."""
        ...

    def tell_proposals(self, source: str, proposals: tuple[Proposal, ...], withdrawn: tuple[str, ...]) -> None:
        """Tell the flight's process what others have proposed by a channel."""
        ...


def make_channels(
    settings: SharingSettings,
    environment: Mapping[str, str],
    now_s: Callable[[], float],
    utc_s: Callable[[], float],
) -> tuple[Channel, ...]:
    """Return the channels of a mission; nothing is opened before they run.

    Args:
        settings: systems to share with.
        environment: variables of the environment, which may hold secrets.
        now_s: real seconds of the clock that the processes share.
        utc_s: clock for people.

    Raises:
        ConfigurationError: a file or a secret cannot be used; the text names the field.
    """
    channels: list[Channel] = []
    if settings.tak is not None:
        channels.append(_tak(settings.tak, now_s, utc_s))
    if (webhook := settings.webhook) is not None:
        secret = read_secret("webhook.secret_file", webhook.secret_file, WEBHOOK_SECRET, environment)
        client = Client(https_context("webhook.ca_file", webhook.ca_file))
        channels.append(WebhookChannel(webhook, secret, client, utc_s))
    if settings.caltopo is not None:
        channels += _caltopo(settings.caltopo, environment, now_s, utc_s)
    return tuple(channels)


def _caltopo(
    settings: CaltopoSettings, environment: Mapping[str, str], now_s: Callable[[], float], utc_s: Callable[[], float]
) -> Iterator[Channel]:
    context = https_context("caltopo.url", None)
    if settings.positions:
        key = read_secret("caltopo.connect_key_file", settings.connect_key_file, CONNECT_KEY, environment)
        yield PositionChannel(settings, key, Client(context), now_s, utc_s)
    if settings.map is not None and settings.credential_id is not None:
        field = "caltopo.credential_secret_file"
        secret = read_secret(field, settings.credential_secret_file, CALTOPO_SECRET, environment)
        credential = Credential.from_text(settings.credential_id, secret)
        yield MapChannel(settings, credential, Client(context), now_s, utc_s)


def _tak(settings: TakSettings, now_s: Callable[[], float], utc_s: Callable[[], float]) -> Channel:
    if settings.transport is TakTransport.TLS:
        tls_context(settings)  # Refused here; each connection reads the files again, since certificates are renewed.
    try:
        undulation_m = undulations(settings.geoid)
    except AosError as error:
        raise ConfigurationError(f"tak.geoid: {error}") from error
    return TakChannel(settings, undulation_m, now_s, utc_s)


async def share(source: Source, channels: Sequence[Channel], utc_s: Callable[[], float]) -> NoReturn:
    """Run all channels until cancelled.

    Args:
        source: mission to share.
        channels: systems to share with.
        utc_s: clock for people.
    """
    with source.subscribe() as events:
        state = SeenState(source.snapshot(), source.heard_at_s)
        for channel in channels:
            channel.put(state)
        async with asyncio.TaskGroup() as group:
            for channel in channels:
                group.create_task(channel.run())
            group.create_task(_tell(source, channels))
            latest = _pass_on(source.notices, channels, _latest_told(source.notices, utc_s()))
            async for event in events:
                if isinstance(event.data, MissionSnapshot | JumpRecord):
                    state = SeenState(source.snapshot(), source.heard_at_s)
                    for channel in channels:
                        channel.put(state)
                latest = _pass_on(_notices(event.data), channels, latest)
    raise AssertionError("the events of a mission in another process do not end")


def _pass_on(notices: Sequence[NoticeRecord], channels: Sequence[Channel], latest: int) -> int:
    """Give the channels the notices with later numbers than this one, and return the latest number."""
    for notice in notices:
        if notice.notice_id > latest:
            latest = notice.notice_id
            for channel in channels:
                channel.take(notice)
    return latest


def _latest_told(notices: Sequence[NoticeRecord], utc_s: float) -> int:
    """Return the number of the latest notice that is not news at the start: a process that is replaced misses some."""
    return max((one.notice_id for one in notices if utc_s - one.utc_s > NEWS_S), default=0)


def _notices(data: EventData) -> Sequence[NoticeRecord]:
    """Return the notices of an event; after a loss of events, those that are kept."""
    if isinstance(data, JumpRecord):
        return data.notices
    return (data,) if isinstance(data, NoticeRecord) else ()


async def _tell(source: Source, channels: Sequence[Channel]) -> NoReturn:
    while True:
        source.tell_sharing(tuple(channel.status for channel in channels))
        for channel in channels:
            if changes := channel.proposals():
                source.tell_proposals(changes.source, changes.proposals, changes.withdrawn)
        await asyncio.sleep(TELL_S)
