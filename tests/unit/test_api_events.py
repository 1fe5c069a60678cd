"""The event stream: outbox, hub, WebSocket and server."""

from __future__ import annotations

import asyncio
import json
import socket
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from aos_gcs.api.app import create_app
from aos_gcs.api.convert import mission as convert_mission
from aos_gcs.api.convert import notice as convert_notice
from aos_gcs.api.hub import EventHub
from aos_gcs.api.messages import SERVER_MESSAGE, NoticeMessage, SnapshotMessage
from aos_gcs.api.openapi import make_document
from aos_gcs.api.outbox import Outbox
from aos_gcs.api.server import serve
from aos_gcs.clock import LoopClock
from aos_gcs.errors import LinkError
from aos_gcs.mission.model import EventKind, NoticeRecord
from aos_gcs.ports import Severity
from tests.fakes.mission import ScriptedMission


@pytest.fixture
async def mission() -> ScriptedMission:
    return ScriptedMission(LoopClock())


def notice(number: int) -> NoticeMessage:
    record = NoticeRecord(Severity.INFO, f"notice {number}", None, 0.0)
    return NoticeMessage(seq=0, utc_s=0.0, notice=convert_notice(record))


def snapshot(mission: ScriptedMission, utc_s: float) -> SnapshotMessage:
    return SnapshotMessage(seq=0, utc_s=utc_s, mission=convert_mission(mission.snapshot()))


async def receive(websocket: ClientConnection) -> dict[str, Any]:
    """The next message that is no heartbeat; every one fits the published schema."""
    while True:
        text = await websocket.recv()
        SERVER_MESSAGE.validate_json(text)
        message: dict[str, Any] = json.loads(text)
        if message["kind"] != "heartbeat":
            return message


async def test_outbox_numbers_without_gaps_while_the_client_keeps_up() -> None:
    outbox = Outbox()
    outbox.put(notice(1))
    outbox.put(notice(2))
    assert [(await outbox.take()).seq, (await outbox.take()).seq] == [2, 3]


async def test_full_outbox_drops_its_oldest_and_leaves_a_gap() -> None:
    outbox = Outbox(capacity=2)
    for number in range(1, 6):
        outbox.put(notice(number))
    first, second = await outbox.take(), await outbox.take()
    assert isinstance(first, NoticeMessage)
    assert first.notice.text == "notice 4"
    assert (first.seq, second.seq) == (5, 6)


async def test_only_the_newest_snapshot_waits_and_none_is_missed(mission: ScriptedMission) -> None:
    outbox = Outbox(capacity=2)
    for utc_s in range(100):
        outbox.put(snapshot(mission, float(utc_s)))
    outbox.put(notice(1))
    first, second = await outbox.take(), await outbox.take()
    assert first.kind == "notice"
    assert isinstance(second, SnapshotMessage)
    assert (second.utc_s, second.seq) == (99.0, 3)


async def test_events_lost_before_the_hub_leave_a_gap_too(mission: ScriptedMission) -> None:
    hub = EventHub(mission)
    running = asyncio.create_task(hub.run())
    with hub.connect() as outbox:
        await asyncio.sleep(0)
        for number in range(300):  # the mission keeps 256 for each subscriber
            mission.notify(Severity.INFO, f"notice {number}")
        first = await outbox.take()
        mission.notify(Severity.INFO, "one more")
        assert first.seq > 2
    running.cancel()


async def test_hello_brings_the_state_and_events_follow(mission: ScriptedMission) -> None:
    mission.make_step()
    async with serve(create_app(mission), port=0) as address:
        async with connect(f"ws://127.0.0.1:{address.port}/api/events") as websocket:
            hello = await receive(websocket)
            assert (hello["kind"], hello["seq"], hello["schema_version"]) == ("hello", 1, 1)
            assert [step["step"] for step in hello["steps"]] == [1]
            assert {picture["kind"] for picture in hello["pictures"]} == {"integral", "thermal", "anomaly"}
            mission.make_step()
            mission.notify(Severity.WARNING, "wind", 2)
            received = [await receive(websocket) for _ in range(3)]
            assert [message["kind"] for message in received] == ["step", "pictures", "notice"]
            assert [message["seq"] for message in received] == [2, 3, 4]
        async with connect(f"ws://127.0.0.1:{address.port}/api/events") as websocket:
            hello = await receive(websocket)
            assert [one["text"] for one in hello["notices"]] == ["wind"]


async def test_slow_client_does_not_hold_up_the_others(mission: ScriptedMission) -> None:
    message_count = 400
    async with serve(create_app(mission), port=0) as address:
        url = f"ws://127.0.0.1:{address.port}/api/events"
        async with connect(url, max_queue=1) as slow, connect(url) as quick:
            assert (await receive(quick))["kind"] == "hello"
            # The slow one reads nothing: its socket fills, then its outbox.
            for number in range(message_count):
                mission.notify(Severity.INFO, f"notice {number} " + 50_000 * "x")
                latest = await receive(quick)
                assert latest["notice"]["text"].startswith(f"notice {number} ")
                assert latest["seq"] == number + 2
            numbers = []
            async with asyncio.timeout(30):
                while not numbers or numbers[-1] < message_count + 1:
                    numbers.append((await receive(slow))["seq"])
            assert len(numbers) < message_count + 1, "the slow client must have lost some"
            assert numbers == sorted(numbers)


async def test_silence_is_filled_with_heartbeats(mission: ScriptedMission) -> None:
    async with (
        serve(create_app(mission), port=0) as address,
        connect(f"ws://127.0.0.1:{address.port}/api/events") as websocket,
    ):
        await receive(websocket)
        assert json.loads(await websocket.recv()) == {"kind": "heartbeat", "seq": 1}


async def test_foreign_pages_cannot_listen(mission: ScriptedMission) -> None:
    async with serve(create_app(mission), port=0) as address:
        url = f"ws://127.0.0.1:{address.port}/api/events"
        with pytest.raises(InvalidStatus) as refused:
            await connect(url, origin="http://evil.example")  # type: ignore[arg-type]
        assert refused.value.response.status_code == 403


async def test_server_ends_with_open_connections_and_frees_its_port(mission: ScriptedMission) -> None:
    async with serve(create_app(mission), port=0) as address:
        websocket = await connect(f"ws://127.0.0.1:{address.port}/api/events")
        await receive(websocket)
    with pytest.raises(ConnectionClosed):
        await receive(websocket)
    async with serve(create_app(mission), port=address.port) as again:
        assert again.url == f"http://127.0.0.1:{address.port}/"


async def test_port_in_use_is_told_before_anything_starts(mission: ScriptedMission) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(LinkError, match=f"port {port} is in use: stop the other program or choose another port"):
            async with serve(create_app(mission), port=port):
                pass


async def test_host_that_is_not_ours_is_told(mission: ScriptedMission) -> None:
    with pytest.raises(LinkError, match=r"cannot listen on 203\.0\.113\.1 port 0"):
        async with serve(create_app(mission), host="203.0.113.1", port=0):
            pass


def test_document_publishes_the_messages() -> None:
    schemas = make_document()["components"]["schemas"]
    kinds = set(schemas["ServerMessage"]["discriminator"]["mapping"])
    assert kinds == {"hello", "heartbeat"} | {str(kind) for kind in EventKind}
    for reference in schemas["ServerMessage"]["oneOf"]:
        assert reference["$ref"].removeprefix("#/components/schemas/") in schemas
