"""Sharing with TAK: the newest state becomes marks when the connection takes them, and nothing waits behind it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import NoReturn

from aos_gcs.errors import InputDataError
from aos_gcs.mission.model.events import NoticeRecord
from aos_gcs.mission.model.sharing import ChannelStatus
from aos_gcs.sharing.channel import PAUSES_S, ChannelError, ProposalChanges, StatusBoard
from aos_gcs.sharing.heights import UndulationM
from aos_gcs.sharing.settings import TakSettings
from aos_gcs.sharing.state import Newest, SeenState
from aos_gcs.sharing.tak.board import MarkBoard
from aos_gcs.sharing.tak.connection import Connection, connect
from aos_gcs.sharing.tak.events import ping_xml
from aos_gcs.sharing.tak.inbox import Inbox
from aos_gcs.sharing.tak.incoming import EventSplitter, is_answer, may_answer, parse_event, pong_utc_s
from aos_gcs.sharing.tak.scene import scene

PING_S = 10.0
"""Interval of pings."""
UNANSWERED_S = 35.0
"""Time without an answer to a ping from which that is said; some servers never answer, and work."""
CLOCK_S = 60.0
"""Difference of the clocks from which it is reported: marks of 10 s would be stale, or from the future."""
_SETTLED_S = 2.0
"""Time after which a connection that was not closed counts as one: a server refuses certificates late."""
_STATE_S = 1.0


class TakChannel:
    """Shares with TAK.

    Args:
        settings: the connection.
        undulation_m: height of the geoid; None: heights are sent as unknown.
        now_s: real seconds of the clock that the processes share.
        utc_s: clock for people.
    """

    def __init__(
        self,
        settings: TakSettings,
        undulation_m: UndulationM | None,
        now_s: Callable[[], float],
        utc_s: Callable[[], float],
    ) -> None:
        self._settings = settings
        self._undulation_m = undulation_m
        self._now_s = now_s
        self._utc_s = utc_s
        self._newest = Newest()
        self._board = MarkBoard()
        self._inbox = Inbox(settings.name, undulation_m, now_s, utc_s)
        self._statuses = StatusBoard("TAK", settings.url, utc_s)
        self._clock_text = ""
        self._answered_at_s = 0.0

    @property
    def status(self) -> ChannelStatus:
        """State of the connection."""
        return self._statuses.status

    def put(self, state: SeenState) -> None:
        """Take a newer state; returns at once."""
        self._newest.put(state)

    def take(self, notice: NoticeRecord) -> None:
        """Ignore a notice: maps show none."""

    def proposals(self) -> ProposalChanges:
        """Return what others have proposed since the last call; nothing unless that is wanted."""
        return self._inbox.changes()

    async def run(self) -> NoReturn:
        """Share until cancelled."""
        failures = 0
        while True:
            began_s = self._now_s()
            try:
                await self._connect_once()
            except ChannelError as error:
                self._statuses.failed(error)
            failures = 1 if self._now_s() - began_s > PING_S else failures + 1
            await asyncio.sleep(PAUSES_S[min(failures, len(PAUSES_S)) - 1])

    async def _connect_once(self) -> None:
        """Connect, and share until the connection is lost, which raises."""
        self._statuses.connecting()
        connection = await connect(self._settings)
        self._board.start_over()
        self._clock_text, self._answered_at_s = "", self._now_s()
        try:
            async with asyncio.TaskGroup() as group:
                group.create_task(self._send(connection))
                group.create_task(self._receive(connection))
        except* ChannelError as errors:
            # What the server said before it closed is the reason, if there is one.
            reasons = sorted(errors.exceptions, key=lambda one: not getattr(one, "is_refused", False))
            raise reasons[0] from None
        finally:
            await connection.close()

    async def _send(self, connection: Connection) -> NoReturn:
        began_s = pinged_s = self._now_s()
        if connection.answers:
            await connection.send([ping_xml(self._settings.name, self._utc_s())])
        while True:
            state = await self._newest.wait(_STATE_S)
            now_s, utc_s = self._now_s(), self._utc_s()
            events = []
            if connection.answers and now_s - pinged_s >= PING_S:
                pinged_s = now_s
                events.append(ping_xml(self._settings.name, utc_s))
            if state is not None:
                present = scene(state, self._settings.name, self._undulation_m, now_s)
                events += self._board.due(present, now_s, utc_s)
            self._statuses.sent(await connection.send(events))
            if not connection.answers or now_s - began_s >= _SETTLED_S:
                self._statuses.connected(self._text(connection))

    async def _receive(self, connection: Connection) -> NoReturn:
        splitter = EventSplitter()
        while True:
            data = await connection.receive()
            if not connection.answers:
                splitter = EventSplitter()  # Each datagram begins anew, whatever the one before was.
            for event in splitter.feed(data):
                self._take(event, connection)
            if self._settings.receive:
                inbox = self._inbox
                self._statuses.received(inbox.received, inbox.refused, inbox.reason)

    def _take(self, event: bytes, connection: Connection) -> None:
        """Take an event of others: an answer to a ping, or what may be a proposal."""
        is_mark = self._settings.receive and self._inbox.admits(event)
        if not is_mark and not may_answer(event):
            return
        try:
            element = parse_event(event)
        except InputDataError as error:
            self._inbox.refuse(str(error))
            return
        if is_answer(element, self._settings.name):
            server_utc_s = pong_utc_s(element)
            if server_utc_s is not None:
                self._clock_text = _clock_text(server_utc_s - self._utc_s())
            self._answered_at_s = self._now_s()
            self._statuses.connected(self._text(connection))
        elif is_mark:
            self._inbox.take(element)

    def _text(self, connection: Connection) -> str:
        text = "Connected" if connection.answers else "Sending; datagrams are not acknowledged"
        if connection.answers and self._now_s() - self._answered_at_s > UNANSWERED_S:
            text += ", but the server answers no pings: it may stand still"
        if self._undulation_m is None:
            text += ". Heights are sent as unknown: no geoid was found; install PROJ's grid of EGM96"
        return text + self._clock_text


def _clock_text(ahead_s: float) -> str:
    """Return what is wrong with the clocks; empty if nothing is."""
    if abs(ahead_s) < CLOCK_S:
        return ""
    direction = "ahead of" if ahead_s > 0.0 else "behind"
    return f". The server's clock is {abs(ahead_s) / 60.0:.0f} min {direction} this machine's: set the clocks"
