"""Connections that are being made when the server ends."""

from __future__ import annotations

import asyncio
import socket

import pytest

from aos_gcs.api.acceptor import Acceptor
from aos_gcs.api.access.connection_limits import CONNECTIONS_PER_PEER, ConnectionLimits
from aos_gcs.api.server import listen


@pytest.mark.parametrize("rounds", [2, 3])
async def test_connection_in_the_making_is_given_up_when_the_server_ends(rounds: int) -> None:
    limits = ConnectionLimits(lambda: 0.0)
    with listen("127.0.0.1", 0) as listener:
        acceptor = Acceptor(listener, limits, lambda _: asyncio.Protocol())
        with socket.create_connection(listener.getsockname()) as client:
            for _ in range(rounds):  # the loop accepts it in the first, and begins to make it in the next
                await asyncio.sleep(0)
            acceptor.close()
            await acceptor.wait_closed()
            await asyncio.sleep(0)
            client.settimeout(1.0)
            assert client.recv(1) == b""
    assert all(limits.admit("127.0.0.1") for _ in range(CONNECTIONS_PER_PEER)), "it is still counted"
