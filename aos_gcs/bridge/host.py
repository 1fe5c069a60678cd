"""The flight's side: tells the interface what happens, and carries out the commands that come from it."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, Final

from aos_gcs.bridge.calls import MissionCalls
from aos_gcs.bridge.messages import MAX_REQUEST_BYTES, REQUESTS, pack, read_message, unpack
from aos_gcs.bridge.outbox import BridgeOutbox
from aos_gcs.mission.control import MissionCommands, MissionView
from aos_gcs.mission.model.events import Event, EventKind, NoticeRecord, PicturesRecord
from aos_gcs.mission.model.proposals import Proposal
from aos_gcs.mission.model.sharing import ChannelStatus
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import PictureKind
from aos_gcs.mission.notices import notices_to_keep
from aos_gcs.planning.settings import MissionSettings

_log = logging.getLogger(__name__)

PAUSE_S: Final = 0.005
"""Pause after each message of the interface: however many it sends, the flight's loop stays free."""
_WRITE_AHEAD_BYTES: Final = 65_536


class MissionHost:
    """Serves a mission's ports to one interface at a time.

    Nothing here waits for the interface but the task that sends to it: while that waits, states are dropped for newer
    ones, and with many events waiting the interface is told everything anew.

    Args:
        view: mission to show.
        commands: commands to it.
        now_s: real seconds of a clock that all processes of this machine share.
        requests: messages that the interface may send, with their forms.
        on_sharing: called with the states of live sharing.
        on_proposals: called with the system by which others have proposed something, their proposals, and what they
            deleted.
    """

    def __init__(
        self,
        view: MissionView,
        commands: MissionCommands,
        now_s: Callable[[], float],
        requests: Mapping[str, Any] = REQUESTS,
        *,
        on_sharing: Callable[[tuple[ChannelStatus, ...]], None] = lambda _: None,
        on_proposals: Callable[[str, tuple[Proposal, ...], tuple[str, ...]], None] = lambda *_: None,
    ) -> None:
        self._view = view
        self._commands = commands
        self._now_s = now_s
        self._requests = requests
        self._on_sharing = on_sharing
        self._on_proposals = on_proposals
        self._notices: list[NoticeRecord] = []
        self._seq = 0
        self._published_at_s = now_s()
        """Time at which the mission last published its state."""
        self._outbox: BridgeOutbox | None = None
        self._sent_settings: MissionSettings | None = None

    async def run(self) -> None:
        """Follow the mission until cancelled."""
        with self._view.subscribe() as events:
            async for event in events:
                self._take(event)

    async def serve(
        self,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
        on_alive: Callable[[bool], None] = lambda _: None,
    ) -> None:
        """Talk to an interface until it is gone; commands in progress are carried out to their end.

        Args:
            reader: its messages.
            writer: takes ours.
            on_alive: called when it has said that it is alive, with whether it serves clients.

        Raises:
            MalformedMessageError: it has sent what is no message.
        """
        self._outbox = outbox = BridgeOutbox(self._greeting)
        calls = MissionCalls(self._commands, partial(self._answer, outbox))
        writer.transport.set_write_buffer_limits(high=_WRITE_AHEAD_BYTES)
        sending = asyncio.create_task(self._send(outbox, writer))
        try:
            while (payload := await read_message(reader, MAX_REQUEST_BYTES)) is not None:
                name, values = unpack(payload, self._requests)
                if name == "alive":
                    on_alive(*values)
                elif name == "sharing":
                    self._on_sharing(*values)
                elif name == "proposals":
                    self._on_proposals(*values)
                else:
                    calls.begin(name, *values)
                await asyncio.sleep(PAUSE_S)
        finally:
            sending.cancel()
            self._outbox = None

    async def _send(self, outbox: BridgeOutbox, writer: asyncio.StreamWriter) -> None:
        try:
            while True:
                message = await outbox.take()
                if self._sent_settings is not self._commands.settings:
                    message = self._settings() + message
                writer.write(message)
                await writer.drain()
        except ConnectionError:
            pass  # the reader sees the end, too
        except Exception:
            _log.exception("The dashboard receives no more events")
            writer.close()

    # --- what happens -------------------------------------------------------------------------------------------------

    def _take(self, event: Event) -> None:
        outbox = self._outbox
        if outbox is not None and 0 < self._seq < event.seq - 1:
            outbox.start_over()
        self._seq = event.seq
        if isinstance(event.data, MissionSnapshot):
            self._published_at_s = self._now_s()
        elif isinstance(event.data, NoticeRecord):
            acknowledged = (each.notice_id for each in self._view.snapshot().acknowledgements)
            self._notices = notices_to_keep([*self._notices, event.data], acknowledged)
        if outbox is None:
            return
        if isinstance(event.data, PicturesRecord):
            for kind in event.data.kinds:
                outbox.put_event(partial(self._picture, kind))
        if event.kind is EventKind.SNAPSHOT:
            outbox.put_state(partial(self._state_event, event))
        else:
            outbox.put_event(partial(pack, f"event {event.kind}", event.seq, event.utc_s, event.data))

    def _state_event(self, event: Event) -> bytes:
        # The present state: the event's own may be older than what an answer has brought meanwhile.
        return pack(f"event {event.kind}", event.seq, event.utc_s, self._view.snapshot(), self._published_at_s)

    def _greeting(self) -> Iterator[bytes]:
        """Return all that has happened until now, message by message; what happens from now on follows as events."""
        self._sent_settings = self._commands.settings
        welcome = self._published_at_s, self._view.snapshot(), self._sent_settings, tuple(self._notices)
        steps, seq = list(self._view.steps()), self._seq

        def messages() -> Iterator[bytes]:
            yield pack("welcome", *welcome)
            for step in steps:
                yield pack("step", step)
            yield from filter(None, map(self._picture, PictureKind))
            yield pack("ready", seq)

        return messages()

    def _picture(self, kind: PictureKind) -> bytes:
        picture = self._view.picture(kind)
        return b"" if picture is None else pack("picture", picture)

    def _settings(self) -> bytes:
        self._sent_settings = self._commands.settings
        return pack("settings", self._sent_settings)

    def _answer(self, outbox: BridgeOutbox, name: str, *values: Any) -> None:
        """Send the answer to a command behind the state that it has led to."""
        outbox.put_answer(lambda: pack("state", self._published_at_s, self._view.snapshot()) + pack(name, *values))
