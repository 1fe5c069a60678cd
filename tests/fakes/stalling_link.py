"""A network between browser and service that stalls: connections stay open, and nothing passes until it goes on."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from urllib.parse import urlsplit


class StallingLink:
    """TCP proxy whose directions can be stalled; what is sent meanwhile arrives late."""

    def __init__(self, port: int) -> None:
        self._port = port
        self._up, self._down = asyncio.Event(), asyncio.Event()
        self._open: set[asyncio.Task[None]] = set()
        self.url = ""
        self.go_on()

    def stall(self, *, down: bool = True) -> None:
        """Pass on nothing any more to the service, and with ``down`` nothing to the browser."""
        self._up.clear()
        if down:
            self._down.clear()

    def go_on(self) -> None:
        """Pass on what has waited, and all that follows."""
        self._up.set()
        self._down.set()

    async def connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serve one connection of the browser."""
        task = asyncio.current_task()
        assert task is not None
        self._open.add(task)
        writers = [writer]
        with suppress(OSError, asyncio.CancelledError):
            behind_reader, behind_writer = await asyncio.open_connection("127.0.0.1", self._port)
            writers.append(behind_writer)
            async with asyncio.TaskGroup() as group:
                group.create_task(_pass_on(reader, behind_writer, self._up))
                group.create_task(_pass_on(behind_reader, writer, self._down))
        for one in writers:
            one.close()
            with suppress(OSError):
                await one.wait_closed()
        self._open.discard(task)

    async def close(self) -> None:
        """End all connections."""
        for task in list(self._open):
            task.cancel()
        await asyncio.gather(*self._open, return_exceptions=True)


async def _pass_on(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, may_pass: asyncio.Event) -> None:
    with suppress(OSError):
        while data := await reader.read(65536):
            await may_pass.wait()
            writer.write(data)
            await writer.drain()
    writer.close()


@asynccontextmanager
async def stalling_link(url: str) -> AsyncIterator[StallingLink]:
    """Lead to a service by another port of this machine."""
    link = StallingLink(urlsplit(url).port or 80)
    server = await asyncio.start_server(link.connect, "127.0.0.1", 0)
    link.url = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/"
    try:
        yield link
    finally:
        server.close()
        await link.close()
