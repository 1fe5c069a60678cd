"""The server's own socket."""

from __future__ import annotations

import socket

import pytest

from aos_gcs.api.access.guess_throttle import FREE_GUESSES
from aos_gcs.api.server import listen, serve
from aos_gcs.clock import LoopClock
from aos_gcs.errors import LinkError
from tests.fakes.app import app_of, client_at
from tests.fakes.mission import ScriptedMission


def test_answers_are_not_held_back_by_the_kernel() -> None:
    with (
        listen("127.0.0.1", 0) as listener,
        socket.create_connection(listener.getsockname()),
        listener.accept()[0] as accepted,
    ):
        assert accepted.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_a_port_in_use_is_refused_with_the_remedy() -> None:
    with listen("127.0.0.1", 0) as listener, pytest.raises(LinkError, match="--port"):
        listen("127.0.0.1", listener.getsockname()[1])


async def test_host_that_is_not_ours_is_told() -> None:
    app = app_of(ScriptedMission(LoopClock()))
    with pytest.raises(LinkError, match=r"cannot listen on 203\.0\.113\.1 port 0"):
        async with serve(app, host="203.0.113.1", port=0):
            pass


async def test_addresses_that_a_client_claims_are_not_believed() -> None:
    app = app_of(ScriptedMission(LoopClock()), operator_code="larch-and-spruce")
    async with serve(app, port=0) as address, client_at(address.url) as client:
        for number in range(FREE_GUESSES + 2):
            headers = {"X-Forwarded-For": f"10.0.0.{number}"}
            answer = await client.post("/api/session", json={"code": "guess", "name": "x"}, headers=headers)
        assert answer.status_code == 429
