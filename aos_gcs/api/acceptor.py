"""Takes connections from the socket that listens; for those beyond the limits nothing is made."""

from __future__ import annotations

import asyncio
import socket
import ssl
from collections.abc import Callable
from functools import partial
from typing import Final

from aos_gcs.api.access.connection_limits import AcceptedConnection, ConnectionLimits
from aos_gcs.api.plain_http import TLS_HANDSHAKE, plain_answer

BACKLOG: Final = 4096
"""Connections that wait to be taken; those that find no room are tried again by their clients after a second."""
_AT_ONCE: Final = 16
"""Connections that are made in one round of the event loop: each takes it a tenth of a millisecond or two."""
_REFUSED_AT_ONCE: Final = 256
"""Connections that are refused in one round, a hundredth of a millisecond each."""
_AGAIN_S: Final = 0.2
_HANDSHAKE_WITHIN_S: Final = 10.0
_HEAD_BYTES: Final = 8192


class Acceptor:
    """Accepts connections until closed.

    Args:
        listener: socket that listens.
        limits: say which connections are admitted.
        make_protocol: makes the protocol of an admitted connection.
        tls: encryption; None: connections are not encrypted. With it, plain requests are sent on to ``https``.
    """

    def __init__(
        self,
        listener: socket.socket,
        limits: ConnectionLimits,
        make_protocol: Callable[[AcceptedConnection], asyncio.Protocol],
        tls: ssl.SSLContext | None = None,
    ) -> None:
        self._listener = listener
        self._limits = limits
        self._make_protocol = make_protocol
        self._tls = tls
        self._loop = asyncio.get_running_loop()
        self._making: set[asyncio.Task[None]] = set()
        self._pause: asyncio.TimerHandle | None = None
        listener.setblocking(False)
        listener.listen(BACKLOG)
        self._begin()

    def close(self) -> None:
        """Accept nothing more, and give up the connections that are being made: nobody would close them later."""
        if self._pause is not None:
            self._pause.cancel()
        self._loop.remove_reader(self._listener)
        for making in self._making:
            making.cancel()

    async def wait_closed(self) -> None:
        """Wait until the connections that were being made are given up."""
        if self._making:
            await asyncio.wait(self._making)

    def _begin(self) -> None:
        self._loop.add_reader(self._listener, self._accept)

    def _accept(self) -> None:
        made = refused = 0
        while made < _AT_ONCE and refused < _REFUSED_AT_ONCE:
            try:
                connection, address = self._listener.accept()
            except (BlockingIOError, ConnectionAbortedError):
                return
            except OSError:  # no file descriptor or no memory is left: others have to end first
                self._loop.remove_reader(self._listener)
                self._pause = self._loop.call_later(_AGAIN_S, self._begin)
                return
            admission = self._limits.admit(address[0])
            if admission is None:
                connection.close()
                refused += 1
                continue
            made += 1
            connection.setblocking(False)
            task = self._loop.create_task(self._make(connection, admission))
            admission.close = partial(_cancel, task)  # until there is a transport
            self._making.add(task)
            task.add_done_callback(partial(self._end_making, connection, admission))

    async def _make(self, connection: socket.socket, admission: AcceptedConnection) -> None:
        try:
            if self._tls is not None and not await self._is_encrypted(connection):
                await self._send_on(connection)
                self._give_up(connection, admission)
                return
            limit_s = None if self._tls is None else _HANDSHAKE_WITHIN_S
            await self._loop.connect_accepted_socket(
                lambda: self._make_protocol(admission), connection, ssl=self._tls, ssl_handshake_timeout=limit_s
            )
        except (OSError, TimeoutError):
            self._give_up(connection, admission)

    def _end_making(self, connection: socket.socket, admission: AcceptedConnection, task: asyncio.Task[None]) -> None:
        self._making.discard(task)
        if task.cancelled():  # perhaps before it began
            self._give_up(connection, admission)

    def _give_up(self, connection: socket.socket, admission: AcceptedConnection) -> None:
        self._limits.leave(admission)
        connection.close()

    async def _is_encrypted(self, connection: socket.socket) -> bool:
        """Return whether a client begins to encrypt, without taking anything from the connection."""
        async with asyncio.timeout(_HANDSHAKE_WITHIN_S):
            while True:
                readable = self._loop.create_future()
                self._loop.add_reader(connection, _note, readable)
                try:
                    await readable
                    first = connection.recv(1, socket.MSG_PEEK)
                except BlockingIOError:
                    continue
                finally:
                    self._loop.remove_reader(connection)
                return first[:1] == bytes([TLS_HANDSHAKE])

    async def _send_on(self, connection: socket.socket) -> None:
        """Tell a client without encryption where to go."""
        async with asyncio.timeout(_HANDSHAKE_WITHIN_S):
            head = await self._loop.sock_recv(connection, _HEAD_BYTES)
            if head:
                await self._loop.sock_sendall(connection, plain_answer(head))


def _cancel(task: asyncio.Task[None]) -> None:
    task.cancel()


def _note(readable: asyncio.Future[None]) -> None:
    if not readable.done():
        readable.set_result(None)
