"""The web hook: one signed request for each message, in order, repeated until it is taken."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import NoReturn

from aos_gcs.mission.model.events import NoticeRecord
from aos_gcs.mission.model.sharing import ChannelStatus
from aos_gcs.ports import Severity
from aos_gcs.sharing.channel import ChannelError, SendsOnly, StatusBoard
from aos_gcs.sharing.http import Request, Requests
from aos_gcs.sharing.settings import WebhookSettings, without_secrets
from aos_gcs.sharing.state import SeenState
from aos_gcs.sharing.webhook.messages import (
    FindingChanges,
    HookMessage,
    alert_message,
    finding_message,
    started_message,
)
from aos_gcs.sharing.webhook.queue import HookQueue

PAUSES_S = (1.0, 2.0, 4.0, 8.0)
"""Pauses before a message is sent again, by the number of failures; the last one goes on."""
_UNUSABLE = frozenset({400, 409, 413, 415, 422})
"""Statuses by which a receiver refuses one message, not us: it is given up, and the next one follows."""
_REMEDY = "check its address and the secret"
_ALERTS = frozenset({Severity.NEWS, Severity.WARNING, Severity.CRITICAL})


class WebhookChannel(SendsOnly):
    """Delivers messages to the web hook.

    Args:
        settings: where they go.
        secret: by which they are signed.
        client: makes the requests.
        utc_s: clock for people.
    """

    def __init__(self, settings: WebhookSettings, secret: str, client: Requests, utc_s: Callable[[], float]) -> None:
        self._settings = settings
        self._secret = secret
        self._client = client
        self._utc_s = utc_s
        self._changes = FindingChanges()
        self._queue = HookQueue()
        self._mission_id = ""
        self._statuses = StatusBoard("Web hook", without_secrets(settings.url), utc_s)

    @property
    def status(self) -> ChannelStatus:
        """State of the deliveries."""
        return self._statuses.status

    def put(self, state: SeenState) -> None:
        """Queue what has happened to findings; returns at once."""
        snapshot, utc_s = state.snapshot, self._utc_s()
        if snapshot.mission_id != self._mission_id:
            self._mission_id = snapshot.mission_id
            self._put(started_message(snapshot.mission_id, utc_s))
        for event, finding in self._changes.since(snapshot):
            self._put(finding_message(event, finding, snapshot, utc_s))

    def take(self, notice: NoticeRecord) -> None:
        """Queue an alert; returns at once."""
        if notice.severity in _ALERTS:
            self._put(alert_message(notice, self._mission_id, self._utc_s()))

    def _put(self, message: HookMessage) -> None:
        former = self._queue.lost
        self._queue.put(message)
        self._statuses.lost(self._queue.lost - former)

    async def run(self) -> NoReturn:
        """Deliver until cancelled."""
        failures = 0
        try:
            while True:
                message = await self._queue.first()
                try:
                    await self._deliver(message)
                    failures = 0
                except ChannelError as error:
                    self._statuses.failed(error)
                    await asyncio.sleep(PAUSES_S[min(failures, len(PAUSES_S) - 1)])
                    failures += 1
        finally:
            await self._client.close()

    async def _deliver(self, message: HookMessage) -> None:
        """Deliver a message, or give it up where the receiver takes us but not this message.

        Raises:
            ChannelError: it was not delivered, and is to be sent again.
        """
        headers = message.headers(self._secret, self._utc_s())
        answer = await self._client.request(Request("POST", self._settings.url, message.body, headers))
        if answer.is_success:
            self._queue.remove(message)
            self._statuses.sent()
            self._statuses.connected("Messages are taken")
        elif answer.status in _UNUSABLE:
            self._queue.remove(message)
            self._statuses.lost()
            self._statuses.connected(f"The receiver has refused the message {message.message_id} ({answer.status})")
        else:
            raise answer.error(_REMEDY)
