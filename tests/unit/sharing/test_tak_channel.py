"""The channel to TAK: connections that fail, stand still or come back, and what waits meanwhile."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager

import pytest

from aos_gcs.mission.model.sharing import ChannelState
from aos_gcs.sharing.channel import ChannelError
from aos_gcs.sharing.settings import TakSettings
from aos_gcs.sharing.tak import channel as tak_channel
from aos_gcs.sharing.tak.channel import TakChannel
from aos_gcs.sharing.tak.events import ping_xml
from tests.fakes.sharing import parsed, running, seen
from tests.unit.sharing.test_tak import PONG, PONG_UTC_S, finding, snapshot


class FakeConnection:
    """Takes events until it is told to fail."""

    answers = True

    def __init__(self) -> None:
        self.batches: list[list[bytes]] = []
        self.incoming: asyncio.Queue[bytes] = asyncio.Queue()
        self.failure: ChannelError | None = None
        self.is_closed = False

    async def send(self, events: Sequence[bytes]) -> int:
        if self.failure is not None:
            raise self.failure
        self.batches.append(list(events))
        return len(events)

    async def receive(self) -> bytes:
        return await self.incoming.get()

    async def close(self) -> None:
        self.is_closed = True

    def uids(self) -> list[str]:
        return [parsed(event).get("uid", "") for batch in self.batches for event in batch]


class Network:
    """A server that is there or not."""

    def __init__(self) -> None:
        self.is_up = True
        self.attempts = 0
        self.connections: list[FakeConnection] = []

    async def connect(self, _settings: TakSettings) -> FakeConnection:
        self.attempts += 1
        if not self.is_up:
            raise ChannelError("The server refuses the connection.")
        self.connections.append(FakeConnection())
        return self.connections[-1]


@asynccontextmanager
async def sharing(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[tuple[TakChannel, Network]]:
    network = Network()
    monkeypatch.setattr(tak_channel, "connect", network.connect)
    now_s = asyncio.get_running_loop().time
    channel = TakChannel(TakSettings("tcp://host:8087"), None, now_s, lambda: PONG_UTC_S)
    channel.put(seen(published_at_s=math.inf))
    async with running(channel.run()):
        yield channel, network


@pytest.mark.looptime
async def test_a_server_that_comes_back_is_told_everything_within_ten_seconds(monkeypatch: pytest.MonkeyPatch) -> None:
    async with sharing(monkeypatch) as (channel, network):
        await asyncio.sleep(5.0)
        assert channel.status.state is ChannelState.CONNECTED
        network.is_up = False
        network.connections[0].failure = ChannelError("The server has closed the connection.")
        await asyncio.sleep(600.0)
        assert channel.status.state is ChannelState.FAILED
        assert network.connections[0].is_closed
        assert network.attempts < 200
        network.is_up = True
        await asyncio.sleep(10.0)
        assert channel.status.state is ChannelState.CONNECTED
        first = [parsed(event).get("uid") for batch in network.connections[-1].batches[:2] for event in batch]
        assert {"aos-gcs.vehicle.1", "aos-gcs.area"} <= set(first)
        assert len(first) < 20


@pytest.mark.looptime
async def test_a_clock_that_is_an_hour_off_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    async with sharing(monkeypatch) as (channel, network):
        await asyncio.sleep(3.0)
        network.connections[0].incoming.put_nowait(PONG.replace(b"T12:", b"T13:"))
        await asyncio.sleep(0.1)
        assert "The server's clock is 60 min ahead of this machine's" in channel.status.text
        network.connections[0].incoming.put_nowait(PONG)
        await asyncio.sleep(0.1)
        assert "clock" not in channel.status.text


@pytest.mark.looptime
async def test_a_server_that_accepts_and_never_answers_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    async with sharing(monkeypatch) as (channel, network):
        await asyncio.sleep(30.0)
        assert "answers no pings" not in channel.status.text
        await asyncio.sleep(10.0)
        assert "answers no pings" in channel.status.text
        network.connections[0].incoming.put_nowait(PONG)
        await asyncio.sleep(2.0)
        assert "answers no pings" not in channel.status.text


@pytest.mark.looptime
async def test_a_server_that_returns_our_pings_is_alive_and_those_of_others_tell_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with sharing(monkeypatch) as (channel, network):
        await asyncio.sleep(40.0)
        incoming = network.connections[0].incoming
        incoming.put_nowait(ping_xml("another", PONG_UTC_S))
        await asyncio.sleep(2.0)
        assert "answers no pings" in channel.status.text
        (ours, *_) = network.connections[0].batches[0]
        incoming.put_nowait(ours)
        await asyncio.sleep(2.0)
        assert "answers no pings" not in channel.status.text
        # It is our own time that comes back: nothing is said of the server's clock.
        assert "clock" not in channel.status.text


@pytest.mark.looptime
async def test_what_waits_for_a_slow_server_is_the_newest_state_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    async with sharing(monkeypatch) as (channel, network):
        await asyncio.sleep(1.5)
        for second in range(1000):
            channel.put(seen(snapshot(findings=(finding(second + 1),)), published_at_s=math.inf))
        await asyncio.sleep(1.5)
        found = [uid for uid in network.connections[0].uids() if "finding" in uid]
        assert set(found) == {"aos-gcs.scripted-1.finding.1000"}
