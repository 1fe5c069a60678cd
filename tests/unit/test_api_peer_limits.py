"""No address keeps the service from the others, or from its operators."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator

import httpx
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from aos_gcs.api import limited_protocol
from aos_gcs.api.access.peer_limits import (
    BURST,
    CONNECTIONS_IN_ALL,
    CONNECTIONS_PER_PEER,
    FOLLOWERS_PER_PEER,
    REQUESTS_PER_S,
    PeerLimits,
)
from aos_gcs.api.server import ServerAddress, serve
from aos_gcs.clock import LoopClock
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission

CODE = "larch-and-spruce"
ONE, OTHER = "10.0.0.1", "10.0.0.2"


class HandTime:
    """Real seconds that pass by hand."""

    now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
async def address() -> AsyncIterator[ServerAddress]:
    async with serve(app_of(ScriptedMission(LoopClock()), operator_code=CODE), port=0) as address:
        yield address


def test_requests_of_an_address_have_a_rate_and_a_burst() -> None:
    time = HandTime()
    limits = PeerLimits(time)
    assert sum(limits.take_request(ONE) for _ in range(2000)) == BURST
    assert limits.take_request(OTHER)
    time.now_s += 1.0
    assert sum(limits.take_request(ONE) for _ in range(2000)) == REQUESTS_PER_S


def test_connections_are_limited_per_address_and_in_all_but_for_operators() -> None:
    limits = PeerLimits(HandTime())
    assert sum(limits.begin_connection(ONE) for _ in range(200)) == CONNECTIONS_PER_PEER
    limits.end_connection(ONE)
    assert limits.begin_connection(ONE)
    for number in range(CONNECTIONS_IN_ALL - CONNECTIONS_PER_PEER):
        assert limits.begin_connection(f"10.1.{number // 250}.{number % 250}")
    assert not limits.begin_connection(OTHER)
    limits.know(OTHER)
    assert limits.begin_connection(OTHER)


def test_addresses_of_one_ipv6_network_count_together() -> None:
    limits = PeerLimits(HandTime())
    assert sum(limits.begin_following(f"2001:db8::{number:x}") for number in range(100)) == FOLLOWERS_PER_PEER
    assert limits.begin_following("2001:db8:0:1::1")


async def test_a_peer_with_too_many_connections_leaves_room_for_others(address: ServerAddress) -> None:
    async with contextlib.AsyncExitStack() as stack:
        for number in range(CONNECTIONS_PER_PEER + 10):
            reader, writer = await asyncio.open_connection("127.0.0.1", address.port, local_addr=("127.0.0.2", 0))
            stack.callback(writer.close)
            if number >= CONNECTIONS_PER_PEER:
                with contextlib.suppress(ConnectionError):
                    assert await reader.read() == b""
        async with httpx.AsyncClient(base_url=address.url) as client:
            assert (await client.get("/api/mission")).status_code == 200


async def test_a_connection_without_a_request_is_closed(
    address: ServerAddress, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limited_protocol, "FIRST_REQUEST_WITHIN_S", 0.05)
    reader, writer = await asyncio.open_connection("127.0.0.1", address.port)
    writer.write(b"GET /api/mission HTTP/1.1\r\nHost: ")
    with contextlib.suppress(ConnectionError):
        assert await reader.read() == b""
    writer.close()


async def test_observers_follow_the_events_so_many_times_and_operators_as_they_like(address: ServerAddress) -> None:
    url = f"ws://127.0.0.1:{address.port}/api/events"
    async with contextlib.AsyncExitStack() as stack, httpx.AsyncClient(base_url=address.url) as client:
        for _ in range(FOLLOWERS_PER_PEER):
            await stack.enter_async_context(connect(url))
        with pytest.raises(InvalidStatus):
            await connect(url)
        await client.post("/api/session", json={"code": CODE, "name": "Ada"})
        cookie = "; ".join(f"{name}={value}" for name, value in client.cookies.items())
        await stack.enter_async_context(connect(url, additional_headers={"Cookie": cookie}))


async def test_an_operator_is_heard_when_the_requests_of_their_address_are_used_up() -> None:
    app = app_of(ScriptedMission(LoopClock()), operator_code=CODE, now_s=HandTime())
    transport = httpx.ASGITransport(app)
    async with (
        httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1:8080") as observer,
        httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1:8080") as operator,
    ):
        await operator.post("/api/session", json={"code": CODE, "name": "Ada"})
        while app.state.limits.take_request("127.0.0.1"):
            pass
        refused = await observer.get("/api/mission")
        assert (refused.status_code, refused.json()["id"]) == (429, "too_many_requests")
        assert (await operator.post("/api/mission/actions", json={"action": "hold"})).status_code == 200
