"""The WebSocket of live pictures: what it sends, to whom, and that no viewer delays another."""

from __future__ import annotations

import asyncio
import contextlib
import json
import struct
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from aos_gcs.api.access.accounts import AccountFile
from aos_gcs.api.access.peer_limits import FOLLOWERS_PER_PEER
from aos_gcs.api.models.wall import WallMessage
from aos_gcs.api.openapi import make_document
from aos_gcs.api.routers import wall as wall_router
from aos_gcs.api.server import serve
from aos_gcs.clock import LoopClock
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission
from tests.fakes.wall import START_UTC_S, WIDTH_PX, CountedWorker, GrowingRecord, make_wall, utc_s
from tests.timing import scaled_s


@pytest.fixture
async def url(record: GrowingRecord, worker: CountedWorker) -> AsyncIterator[str]:
    async with serving(record, worker) as url:
        yield url


@contextlib.asynccontextmanager
async def serving(record: GrowingRecord, worker: CountedWorker, **options: Any) -> AsyncIterator[str]:
    mission = ScriptedMission(LoopClock())
    app = app_of(mission, wall=make_wall(mission, record.folder, worker), **options)
    async with serve(app, port=0) as address:
        yield f"ws://127.0.0.1:{address.port}/api/wall"


async def watch(stream: ClientConnection, *tiles: str, **more: Any) -> None:
    await stream.send(json.dumps({"kind": "watch", "tiles": tiles, **more}))


async def take(stream: ClientConnection, *, answers: bool = True) -> tuple[WallMessage, list[bytes]]:
    """Return the next message: its head, and its files."""
    async with asyncio.timeout(scaled_s(10.0)):
        message = await stream.recv()
    assert isinstance(message, bytes)
    (length,) = struct.unpack("!I", message[:4])
    head = WallMessage.model_validate_json(message[4 : 4 + length])
    files, begin = [], 4 + length
    for picture in head.pictures:
        files.append(message[begin : begin + picture.bytes])
        begin += picture.bytes
    assert begin == len(message)
    if answers:
        await stream.send(json.dumps({"kind": "shown", "number": head.number}))
    return head, files


async def take_pictures(stream: ClientConnection) -> tuple[WallMessage, list[bytes]]:
    """Return the next message that has pictures."""
    while not (taken := await take(stream))[0].pictures:
        pass
    return taken


async def test_the_tiles_that_are_chosen_come_with_place_time_and_scale(record: GrowingRecord, url: str) -> None:
    record.add(3, START_UTC_S, bands=("red", "green", "blue", "thermal"))
    async with connect(url) as stream:
        await watch(stream, "3.thermal", "3.colour")
        head, files = await take_pictures(stream)
        assert head.tiles == ["3.colour", "3.thermal"]
        assert [picture.tile for picture in head.pictures] == ["3.thermal", "3.colour"]
        thermal, colour = head.pictures
        assert (thermal.palette, colour.palette, colour.scale) == ("inferno", None, None)
        assert thermal.scale is not None
        assert thermal.scale.celsius
        assert (thermal.utc_s, thermal.width_px, thermal.at_camera) == (START_UTC_S, WIDTH_PX, False)
        assert thermal.latitude_deg is not None
        assert all(file.startswith(b"\xff\xd8") for file in files)
        assert set(head.ages_s) == {"3.colour", "3.thermal"}
        assert (head.live, head.refused) == (True, "")
        await watch(stream, "3.thermal", large=True)
        assert (await take_pictures(stream))[0].pictures[0].width_px == WIDTH_PX + 8


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ('{"kind": "watch", "tiles": ["3.depth"]}', "3.depth"),
        ('{"kind": "watch", "tiles": ["1.colour", "2.colour"], "large": true}', "large"),
        ('{"kind": "watch", "tiles": ["1.colour"], "rate_hz": -1}', "rate_hz"),
        ('{"kind": "watch"}', "tiles"),
        ('{"kind": "fly"}', "kind"),
        ("no JSON", "JSON"),
    ],
)
async def test_what_is_wrong_is_named_and_the_stream_goes_on(
    record: GrowingRecord, url: str, text: str, names: str
) -> None:
    record.add(1, START_UTC_S)
    async with connect(url) as stream:
        await stream.send(text)
        while not (head := (await take(stream))[0]).refused:
            pass
        assert names in head.refused
        await watch(stream, "1.colour")
        assert (await take_pictures(stream))[0].refused == ""


async def test_the_next_message_waits_for_the_answer_and_has_the_newest(record: GrowingRecord, url: str) -> None:
    async with connect(url) as stream:
        await watch(stream, "1.colour")
        head, _ = await take(stream, answers=False)
        for grey in range(5):
            record.add(1, START_UTC_S + grey, grey=grey)
            await asyncio.sleep(0.05)
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(0.2):
                await stream.recv()
        await stream.send(json.dumps({"kind": "shown", "number": head.number}))
        head, files = await take_pictures(stream)
        while head.pictures[0].utc_s < START_UTC_S + 4:  # the wall had not found it yet
            head, files = await take_pictures(stream)
        assert (len(head.pictures), len(files)) == (1, 1)


async def test_viewers_that_never_answer_or_never_read_are_closed_and_delay_nobody(
    record: GrowingRecord, url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(wall_router, "ANSWER_TIMEOUT_S", 0.3)
    record.add(1, START_UTC_S)
    async with connect(url) as silent, connect(url) as good:
        await watch(silent, "1.colour")
        await watch(good, "1.colour")
        await take_pictures(good)
        async with asyncio.timeout(scaled_s(5.0)):
            with contextlib.suppress(ConnectionClosed):
                while True:
                    await silent.recv()
        record.add(1, utc_s())
        assert (await take_pictures(good))[0].pictures


async def test_twenty_viewers_share_every_picture(record: GrowingRecord, worker: CountedWorker, url: str) -> None:
    async with contextlib.AsyncExitStack() as stack:
        streams = [await stack.enter_async_context(connect(url)) for _ in range(20)]
        for stream in streams:
            await watch(stream, "1.colour")
            await take(stream)
        record.add(1, utc_s())
        taken = await asyncio.gather(*map(take_pictures, streams))
    assert len({files[0] for _, files in taken}) == 1
    assert len(worker.rendered) == 1


async def test_viewers_are_limited_and_leave_the_event_streams_alone(record: GrowingRecord) -> None:
    async with serving(record, CountedWorker(), operator_code="code") as url, contextlib.AsyncExitStack() as stack:
        for _ in range(FOLLOWERS_PER_PEER):
            await stack.enter_async_context(connect(url))
        with pytest.raises(InvalidStatus):
            await connect(url)
        await stack.enter_async_context(connect(url.replace("wall", "events")))


async def test_where_everybody_has_an_account_visitors_see_nothing(record: GrowingRecord, tmp_path: Path) -> None:
    accounts = AccountFile(tmp_path / "accounts.json")
    async with serving(record, CountedWorker(), accounts=accounts) as url:
        with pytest.raises(InvalidStatus) as refused:
            await connect(url)
        assert refused.value.response.status_code in {401, 403}
    async with (
        serving(record, CountedWorker(), accounts=accounts, anyone_observes=True) as url,
        connect(url) as stream,
    ):
        await watch(stream, "1.colour")
        assert (await take(stream))[0].tiles == []


async def test_without_a_record_there_is_no_wall() -> None:
    app = app_of(ScriptedMission(LoopClock()))
    async with serve(app, port=0) as address:
        async with connect(f"ws://127.0.0.1:{address.port}/api/wall") as stream:
            with pytest.raises(ConnectionClosed) as closed:
                await stream.recv()
        assert closed.value.rcvd is not None
        assert "no live pictures" in closed.value.rcvd.reason
        async with httpx.AsyncClient(base_url=address.url) as client:
            hello = (await client.get("/api/events", params={"after": 10**6})).json()["hello"]
    assert hello["capabilities"]["wall"] is False


def test_the_document_has_the_messages_of_the_wall() -> None:
    schemas = make_document()["components"]["schemas"]
    assert {"WallMessage", "WallClientMessage", "TilePictureModel", "WallRequest"} <= schemas.keys()
