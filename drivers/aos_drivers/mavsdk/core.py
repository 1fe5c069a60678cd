"""The library MAVSDK, connected to the event loop: its callbacks come from threads of its own."""

from __future__ import annotations

import asyncio
import json
import logging
import math
import queue
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from typing import Any

from mavsdk import Configuration, LogLevel, Mavsdk, log_subscribe
from mavsdk.plugins.mavlink_direct import MavlinkMessage
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.heartbeat import OUR_COMPONENT_ID

_BUFFERED_PACKETS = 4096
_log = logging.getLogger(__name__)
_LEVELS = {
    LogLevel.DEBUG: logging.DEBUG,
    LogLevel.INFO: logging.DEBUG,
    LogLevel.WARN: logging.INFO,
    LogLevel.ERROR: logging.WARNING,
}


@asynccontextmanager
async def open_core(system_id: int) -> AsyncIterator[tuple[Mavsdk, Feeder]]:
    """Yield a MAVSDK that acts as ground station ``system_id``, and its feeder: it has no sockets of its own."""
    log_subscribe(_take_log)
    core = Mavsdk(Configuration.create_manual(system_id, OUR_COMPONENT_ID, False))
    try:
        core.add_any_connection("raw://")
        feeder = Feeder(core)
        try:
            yield core, feeder
        finally:
            await asyncio.to_thread(feeder.close)
    finally:
        # It waits for callbacks that are under way, which may wait for the interpreter.
        await asyncio.to_thread(core.destroy)


class Feeder:
    """Thread that passes packets to MAVSDK.

    Each hand-over lets MAVSDK's threads run their callbacks, and taking the interpreter back from them costs up to some
    milliseconds: the event loop must not wait for it. Buffered: up to 4096 packets. Buffer full policy: the newest
    packet is lost, as on a radio.
    """

    def __init__(self, core: Mavsdk) -> None:
        """Start the thread; ``close`` ends it."""
        self._core = core
        self._packets: queue.Queue[bytes | None] = queue.Queue(_BUFFERED_PACKETS)
        self._thread = threading.Thread(target=self._run, name="mavsdk-feeder", daemon=True)
        self._thread.start()

    def feed(self, packet: bytes) -> None:
        """Pass a whole packet, without waiting."""
        with suppress(queue.Full):
            self._packets.put_nowait(packet)

    def close(self) -> None:
        """Wait until everything has been passed, and end the thread."""
        self._packets.put(None)
        self._thread.join()

    def _run(self) -> None:
        while (packet := self._packets.get()) is not None:
            self._core.pass_received_raw_bytes(packet)


class LoopDispatcher:
    """Dispatcher of calls from any thread to the event loop. Policy: calls after ``close`` are dropped."""

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._is_open = True

    def close(self) -> None:
        """Drop everything from now on."""
        self._is_open = False

    def to_loop(self, function: Callable[..., None]) -> Callable[..., None]:
        """Return a callback for MAVSDK that calls ``function`` on the loop with its arguments but the last.

        The last is the ``user_data`` of MAVSDK's C interface.
        """

        def callback(*arguments: Any) -> None:
            if self._is_open:
                self._loop.call_soon_threadsafe(self._call, function, arguments[:-1])

        return callback

    def _call(self, function: Callable[..., None], arguments: tuple[Any, ...]) -> None:
        if self._is_open:
            function(*arguments)


def message_from_direct(direct: MavlinkMessage) -> mavlink.MAVLink_message:
    """Return the message of MAVSDK's JSON; its null is a float that is not a number."""
    kind = getattr(mavlink, f"MAVLink_{direct.message_name.lower()}_message")
    values = json.loads(direct.fields_json)
    return kind(**{name: math.nan if values.get(name) is None else values[name] for name in kind.fieldnames})


def direct_from_message(message: mavlink.MAVLink_message, system_id: int, component_id: int) -> MavlinkMessage:
    """Return the message as MAVSDK takes it, for a component of a vehicle. Its JSON has null for not-a-number."""
    values = {name: getattr(message, name) for name in message.fieldnames}
    text = json.dumps({name: None if _is_nan(value) else value for name, value in values.items()})
    return MavlinkMessage(message.get_type(), 0, 0, system_id, component_id, text)


def _is_nan(value: object) -> bool:
    return isinstance(value, float) and math.isnan(value)


def _take_log(level: LogLevel, text: str, _file: str | None, _line: int) -> bool:
    _log.log(_LEVELS[level], "MAVSDK: %s", text)
    return True
