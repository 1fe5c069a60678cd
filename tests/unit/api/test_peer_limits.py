"""No address keeps the service from the others, or from its operators."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
from collections.abc import AsyncIterator
from typing import NoReturn

import httpx
import pytest
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed, InvalidStatus

from aos_gcs.api import limited_protocol
from aos_gcs.api.access import connection_limits
from aos_gcs.api.access.connection_limits import (
    CONNECTIONS_IN_ALL,
    CONNECTIONS_PER_PEER,
    NEW_PER_S,
    ON_PROBATION,
    ConnectionLimits,
)
from aos_gcs.api.access.peer_limits import BURST, FOLLOWERS_PER_PEER, REQUESTS_PER_S, PeerLimits
from aos_gcs.api.access.turns import BEGUN_PER_ROUND, Turns
from aos_gcs.api.server import ServerAddress, serve
from aos_gcs.clock import LoopClock
from tests.fakes.app import app_of, client_at, stream_at
from tests.fakes.mission import ScriptedMission

CODE = "larch-and-spruce"
ONE, OTHER = "10.0.0.1", "10.0.0.2"


class HandTime:
    """Real seconds that pass by hand."""

    now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
async def address(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[ServerAddress]:
    """A server that waits for first requests for as long as the test takes."""
    monkeypatch.setattr(limited_protocol, "FIRST_REQUEST_WITHIN_S", 3600.0)
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
    time = HandTime()
    limits = ConnectionLimits(time)
    admitted = [limits.admit(ONE) for _ in range(200)]
    assert sum(one is not None for one in admitted) == CONNECTIONS_PER_PEER
    first = admitted[0]
    assert first is not None
    limits.leave(first)
    limits.leave(first)
    assert limits.admit(ONE) is not None
    assert limits.admit(ONE) is None, "what has left is counted once"
    time.now_s += 60.0
    for number in range(CONNECTIONS_IN_ALL - CONNECTIONS_PER_PEER):
        assert limits.admit(f"10.1.{number // 250}.{number % 250}") is not None
    assert limits.admit(OTHER) is None
    limits.know(OTHER)
    assert limits.admit(OTHER) is not None


def test_strangers_open_so_many_connections_per_second() -> None:
    time = HandTime()
    limits = ConnectionLimits(time)

    def opened() -> int:
        """Connections that are admitted of many, each of which ends at once."""
        admitted = [limits.admit(f"10.1.0.{number % 250}") for number in range(2000)]
        for one in admitted:
            if one is not None:
                limits.leave(one)
        return sum(one is not None for one in admitted)

    opened()
    time.now_s += 1.0
    assert opened() == NEW_PER_S
    limits.know(ONE)
    assert limits.admit(ONE) is not None


def test_behind_the_address_of_an_attacker_the_newest_connections_are_tried_for_operators() -> None:
    limits = ConnectionLimits(HandTime())
    limits.know(ONE)
    counted = [limits.admit(ONE) for _ in range(CONNECTIONS_PER_PEER)]
    assert all(one is not None and not one.is_on_probation for one in counted)
    closed, waiting = list[int](), []
    for number in range(ON_PROBATION):
        admission = limits.admit(ONE)
        assert admission is not None
        assert admission.is_on_probation
        admission.close = lambda number=number: closed.append(number)  # type: ignore[misc]
        waiting.append(admission)
    limits.trust(waiting[0])
    assert not waiting[0].is_on_probation
    assert limits.admit(ONE) is not None
    assert closed == [], "that of the operator has left its place"
    assert limits.admit(ONE) is not None
    assert closed == [1]


async def test_requests_begin_a_few_per_round_of_the_loop() -> None:
    turns, begun = Turns(), list[int]()

    async def request(number: int) -> None:
        await turns.wait()
        begun.append(number)

    requests = [asyncio.create_task(request(number)) for number in range(50)]
    requests[3].cancel()
    counts = [0]
    while len(begun) < 49:
        await asyncio.sleep(0)
        counts.append(len(begun))
    assert max(after - before for before, after in itertools.pairwise(counts)) == BEGUN_PER_ROUND
    assert begun == sorted(begun)


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
        async with client_at(address.url) as client:
            assert (await client.get("/api/mission")).status_code == 200


async def test_an_operator_is_heard_behind_the_address_of_an_attacker(
    address: ServerAddress, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The attacker opens all that an address may have, and more without end; a new connection still holds all."""
    monkeypatch.setattr(connection_limits, "CONNECTIONS_PER_PEER", 4)
    monkeypatch.setattr(connection_limits, "ON_PROBATION", 4)
    async with contextlib.AsyncExitStack() as stack:
        async with client_at(address.url) as client:
            await client.post("/api/session", json={"code": CODE, "name": "Ada"})
            assert (await client.get("/api/mission")).status_code == 200
            cookies = client.cookies
        streams = []
        for _ in range(20):
            reader, writer = await asyncio.open_connection("127.0.0.1", address.port)
            stack.callback(writer.close)
            streams.append((reader, writer))
        async with client_at(address.url) as stranger:
            refused = await stranger.get("/api/mission")
            assert (refused.status_code, refused.json()["id"]) == (429, "too_many_connections")
            assert refused.headers["connection"] == "close"
        async with client_at(address.url, cookies=cookies) as operator:
            answer = await operator.post("/api/mission/actions", json={"action": "hold"})
            assert answer.status_code == 200
        with contextlib.suppress(ConnectionError):
            assert await streams[4][0].read() == b"", "the oldest that had brought nothing has given way"
        assert not streams[0][0].at_eof()


async def test_a_stream_that_sends_more_than_pages_do_is_closed(address: ServerAddress) -> None:
    async with stream_at(f"ws://127.0.0.1:{address.port}/api/events") as stream:
        await stream.recv()
        with pytest.raises(ConnectionClosed):
            await _send_without_end(stream)


async def _send_without_end(stream: ClientConnection) -> NoReturn:
    while True:
        await stream.send("x" * 1000)


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
    async with contextlib.AsyncExitStack() as stack, client_at(address.url) as client:
        for _ in range(FOLLOWERS_PER_PEER):
            await stack.enter_async_context(stream_at(url))
        with pytest.raises(InvalidStatus):
            await stream_at(url)
        await client.post("/api/session", json={"code": CODE, "name": "Ada"})
        cookie = "; ".join(f"{name}={value}" for name, value in client.cookies.items())
        await stack.enter_async_context(stream_at(url, additional_headers={"Cookie": cookie}))


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
