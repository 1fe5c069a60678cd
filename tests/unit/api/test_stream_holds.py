"""Holds on the event stream, which is open when a browser has no connection left for a request."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import httpx
import pytest
from argon2 import PasswordHasher
from websockets.asyncio.client import ClientConnection, connect

from aos_gcs.api.access import passwords
from aos_gcs.api.access.accounts import AccountFile
from aos_gcs.api.access.roles import Role
from aos_gcs.api.once import KEPT, Once
from aos_gcs.api.server import ServerAddress, serve
from aos_gcs.clock import LoopClock
from aos_gcs.errors import MissionError
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Phase
from tests.fakes.app import app_of, client_at, stream_at
from tests.fakes.mission import ScriptedMission
from tests.timing import scaled_s

CODE = "larch-and-spruce"
PRESS = "press-0001"
PASSWORD = "larch and spruce"  # noqa: S105 - of the tests


@pytest.fixture
async def mission() -> ScriptedMission:
    mission = ScriptedMission(LoopClock())
    mission.phase = Phase.SCAN
    return mission


@pytest.fixture
async def address(mission: ScriptedMission) -> AsyncIterator[ServerAddress]:
    async with serve(app_of(mission, operator_code=CODE), port=0) as address:
        yield address


@pytest.fixture
async def operator(address: ServerAddress) -> AsyncIterator[httpx.AsyncClient]:
    async with client_at(address.url) as client:
        await client.post("/api/session", json={"code": CODE, "name": "Ada"})
        yield client


def stream_of(address: ServerAddress, client: httpx.AsyncClient | None = None) -> connect:
    cookie = "" if client is None else "; ".join(f"{name}={value}" for name, value in client.cookies.items())
    return stream_at(f"ws://127.0.0.1:{address.port}/api/events", additional_headers={"Cookie": cookie})


async def answer(stream: ClientConnection) -> dict[str, Any]:
    async for text in stream:
        message: dict[str, Any] = json.loads(text)
        if message["kind"] == "answer":
            return message
    raise AssertionError("the stream has ended")


async def test_one_press_by_both_ways_is_one_hold_with_one_answer(
    mission: ScriptedMission, address: ServerAddress, operator: httpx.AsyncClient
) -> None:
    async with stream_of(address, operator) as stream:
        await stream.send(json.dumps({"kind": "hold", "request_id": PRESS}))
        first = await answer(stream)
        assert (first["request_id"], first["status"], first["error"]) == (PRESS, 200, None)
        # The copy is late, as behind pictures that a browser waits for.
        again = await operator.post("/api/mission/actions", json={"action": "hold", "request_id": PRESS})
        assert again.json() == first["response"]
        assert mission.actions == [(Action.HOLD, None)]
        assert mission.operators == ["Ada"]
        await stream.send(json.dumps({"kind": "hold", "request_id": "press-0002"}))
        await answer(stream)
        assert len(mission.actions) == 2


async def test_an_observers_hold_is_refused_and_other_messages_are_ignored(
    mission: ScriptedMission, address: ServerAddress, operator: httpx.AsyncClient
) -> None:
    async with stream_of(address) as stream:
        for text in ("", "[1]", '{"kind": "land"}', '{"kind": "hold", "request_id": ""}', "\x00"):
            await stream.send(text)
        await stream.send(b"\xff\x00")
        await stream.send(json.dumps({"kind": "hold", "request_id": PRESS}))
        refused = await answer(stream)
    assert (refused["status"], refused["error"]["id"], refused["response"]) == (403, "operators_only", None)
    async with stream_of(address, operator) as stream:
        await operator.delete("/api/session")
        await stream.send(json.dumps({"kind": "hold", "request_id": PRESS}))
        assert (await answer(stream))["status"] == 403, "a session ends for its streams, too"
    assert mission.actions == []


async def test_a_hold_goes_on_when_its_client_is_gone_and_its_refusal_comes_again() -> None:
    once, calls = Once(), list[int]()
    is_done = asyncio.Event()

    async def hold() -> str:
        calls.append(1)
        await is_done.wait()
        return "held"

    first = asyncio.create_task(once.run("a", hold))
    await asyncio.sleep(0)
    first.cancel()
    second = asyncio.create_task(once.run("a", hold))
    await asyncio.sleep(0)
    is_done.set()
    assert await second == "held"
    assert len(calls) == 1

    async def refuse() -> str:
        calls.append(2)
        raise MissionError("no")

    for _ in range(2):
        with pytest.raises(MissionError, match="no"):
            await once.run("b", refuse)
    assert calls.count(2) == 1
    for number in range(KEPT):
        await once.run(number, hold)
    await once.run("a", hold)
    assert len(calls) == KEPT + 3, "what is long past is forgotten"


async def test_an_operator_who_loses_the_account_loses_control(
    mission: ScriptedMission, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(passwords, "_hasher", lambda: PasswordHasher(time_cost=1, memory_cost=8, parallelism=1))
    accounts = AccountFile(tmp_path / "accounts.json")
    for name in ("Ada", "Robin"):
        accounts.add(name, Role.OPERATOR, PASSWORD, 0.0)
    # The clock stands still: nobody is gone because time has passed.
    app = app_of(mission, accounts=accounts, anyone_observes=True, now_s=lambda: 1000.0)
    async with serve(app, port=0) as address, AsyncExitStack() as stack:
        ada, robin = [await stack.enter_async_context(client_at(address.url)) for _ in range(2)]
        for name, client in (("Ada", ada), ("Robin", robin)):
            await client.post("/api/session", json={"name": name, "password": PASSWORD})
        stream = await stack.enter_async_context(stream_of(address, ada))
        await anext(aiter(stream))
        assert (await ada.post("/api/control/take", json={"reason": "wind"})).status_code == 200
        refused = await robin.post("/api/control/take", json={"reason": ""})
        assert refused.status_code == 422, "Ada has control, and is there"
        accounts.remove("Ada")
        async with asyncio.timeout(scaled_s(30.0)):
            while (await robin.post("/api/control/take", json={"reason": ""})).status_code != 200:
                await anext(aiter(stream))  # goes on: she observes, as anybody does
