"""The event stream: outbox, hub, WebSocket and server."""

from __future__ import annotations

import asyncio
import functools
import json
import os
import socket
from collections.abc import Callable
from typing import Any
from unittest.mock import create_autospec

import pytest
from fastapi import WebSocket
from hypothesis import given
from hypothesis import strategies as st
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed, InvalidStatus

from aos_gcs.api.convert.mission import MissionConverter
from aos_gcs.api.events.hub import EVENTS_KEPT, EventHub
from aos_gcs.api.events.outbox import Outbox
from aos_gcs.api.events.state import REVISIONS_KEPT, MissionState
from aos_gcs.api.models.messages import SERVER_MESSAGE, MissedEventsModel
from aos_gcs.api.models.mission import MissionModel
from aos_gcs.api.openapi import make_document
from aos_gcs.api.routers import events
from aos_gcs.api.routers.events import follow_events
from aos_gcs.api.server import serve
from aos_gcs.clock import LoopClock
from aos_gcs.errors import LinkError
from aos_gcs.mission.model.events import EventKind, PicturesRecord
from aos_gcs.mission.model.steps import PictureKind
from aos_gcs.ports import Severity
from tests.fakes.app import app_of, client_at, stream_at
from tests.fakes.mission import ScriptedMission
from tests.fakes.program import unused_port
from tests.timing import scaled_s


@pytest.fixture
async def mission() -> ScriptedMission:
    return ScriptedMission(LoopClock())


async def receive(websocket: ClientConnection) -> dict[str, Any]:
    """The next message that is no heartbeat; every one fits the published schema."""
    while True:
        text = await websocket.recv()
        SERVER_MESSAGE.validate_json(text)
        message: dict[str, Any] = json.loads(text)
        if message["kind"] != "heartbeat":
            return message


def missed(hub: EventHub, after: int) -> MissedEventsModel:
    return MissedEventsModel.model_validate_json(hub.missed_text(after))


def no_age() -> float:
    return 0.0


def no_name() -> str:
    return "-"


def greeting(seq: int = 0) -> Callable[[], tuple[int, str]]:
    return lambda: (seq, "hello")


async def test_outbox_greets_first_and_then_hands_events_on_in_order() -> None:
    outbox = Outbox(MissionState(), greeting(5), no_age, no_name)
    assert await outbox.take() == "hello"
    outbox.put(6, "one")
    outbox.put(7, "two")
    assert [await outbox.take(), await outbox.take()] == ["one", "two"]
    assert json.loads(outbox.heartbeat()) == {"kind": "heartbeat", "seq": 7, "mission_age_s": 0.0, "seen": "-"}


async def test_full_outbox_drops_its_oldest_events() -> None:
    outbox = Outbox(MissionState(), greeting(), no_age, no_name, capacity=2)
    await outbox.take()
    for seq in range(1, 6):
        outbox.put(seq, f"event {seq}")
    assert [await outbox.take(), await outbox.take()] == ["event 4", "event 5"]


async def test_changes_of_the_state_are_joined_while_a_client_is_busy(mission: ScriptedMission) -> None:
    state = MissionState()
    outbox = Outbox(state, lambda: (0, "hello" if state.update(shown(mission), 0.0) else ""), no_age, no_name)
    await outbox.take()
    first = shown(mission)
    vehicle = first.vehicles[0]
    for revision in range(1, 6):
        changed = vehicle.model_copy(update={"link_age_s": float(revision)})
        state.update(first.model_copy(update={"vehicles": [changed, *first.vehicles[1:]]}), float(revision))
    state.update(first.model_copy(update={"vehicles": [changed, *first.vehicles[1:]], "message": "wind"}), 6.0)
    outbox.put(1, "event")
    assert await outbox.take() == "event"
    assert json.loads(await outbox.take()) == {
        "seq": 1,
        "mission_age_s": 0.0,
        "seen": "-",
        "kind": "changes",
        "utc_s": 6.0,
        "mission": {"message": "wind"},
        "vehicles": [{"vehicle_id": 1, "link_age_s": 5.0}],
        "preflight": [],
    }


def shown(mission: ScriptedMission) -> MissionModel:
    return MissionConverter(mission.snapshot().origin).convert(mission.snapshot())


def test_a_state_that_is_the_same_makes_no_message(mission: ScriptedMission) -> None:
    state = MissionState()
    assert state.update(shown(mission), 0.0)
    assert not state.update(shown(mission), 1.0)


def test_who_is_far_behind_gets_the_whole_state(mission: ScriptedMission) -> None:
    state, model = MissionState(), shown(mission)
    for revision in range(REVISIONS_KEPT + 2):
        state.update(model.model_copy(update={"elapsed_s": float(revision)}), 0.0)
    assert json.loads(state.message_since(2, 0, 0.0, ""))["kind"] == "changes"
    whole = json.loads(state.message_since(1, 0, 0.0, ""))
    assert whole["kind"] == "snapshot"
    assert len(whole["mission"]["vehicles"]) == len(model.vehicles)


def test_a_vehicle_that_is_gone_is_told_with_the_whole_state(mission: ScriptedMission) -> None:
    state, model = MissionState(), shown(mission)
    state.update(model, 0.0)
    state.update(model.model_copy(update={"vehicles": model.vehicles[1:]}), 0.0)
    assert json.loads(state.message_since(1, 0, 0.0, ""))["kind"] == "snapshot"


def test_of_preflight_only_checks_that_have_changed_are_sent(mission: ScriptedMission) -> None:
    state, model = MissionState(), shown(mission)
    state.update(model, 0.0)
    changed = model.preflight[3].model_copy(update={"text": "much better"})
    checks = [changed if one == model.preflight[3] else one for one in model.preflight]
    state.update(model.model_copy(update={"preflight": checks}), 1.0)
    message = json.loads(state.message_since(1, 0, 0.0, ""))
    assert (message["mission"], message["preflight"]) == ({}, [changed.model_dump(mode="json")])
    state.update(model.model_copy(update={"preflight": checks[1:]}), 2.0)
    both = json.loads(state.message_since(1, 0, 0.0, ""))
    assert len(both["mission"]["preflight"]) == len(checks) - 1
    assert both["preflight"] == []


@given(st.lists(st.lists(st.tuples(st.integers(1, 4), st.integers(0, 2)), max_size=4), min_size=1), st.data())
def test_changes_lead_from_any_revision_to_the_present_one(
    revisions: list[list[tuple[int, int]]], data: st.DataObject
) -> None:
    state, values, told = MissionState(), dict.fromkeys(range(1, 5), 0), []
    for changes in [[], *revisions]:
        values |= dict(changes)
        state.update(mission_of(values), 0.0)
        told.append((state.revision, dict(values)))
    revision, known = data.draw(st.sampled_from(told))
    if revision == state.revision:
        return
    message = json.loads(state.message_since(revision, 0, 0.0, ""))
    SERVER_MESSAGE.validate_python(message)
    changed = message["vehicles"] if message["kind"] == "changes" else message["mission"]["vehicles"]
    assert known | {one["vehicle_id"]: one["satellites"] for one in changed} == values


class StillClock(LoopClock):
    def __init__(self) -> None:
        pass

    def utc_s(self) -> float:
        return 0.0


@functools.cache
def any_mission() -> MissionModel:
    return shown(ScriptedMission(StillClock(), vehicles=1))


def mission_of(satellites: dict[int, int]) -> MissionModel:
    snapshot = any_mission()
    template = snapshot.vehicles[0]
    vehicles = [template.model_copy(update={"vehicle_id": key, "satellites": n}) for key, n in satellites.items()]
    return snapshot.model_copy(update={"vehicles": vehicles})


async def test_events_lost_before_the_hub_bring_the_whole_state(mission: ScriptedMission) -> None:
    hub = EventHub(mission)
    running = asyncio.create_task(hub.run())
    with hub.connect() as outbox:
        await outbox.take()
        await asyncio.sleep(0)
        mission.notify(Severity.INFO, "the first one")
        await outbox.take()
        for number in range(300):  # the mission keeps 256 for each subscriber
            mission.notify(Severity.INFO, f"notice {number}")
        await outbox.take()
        assert json.loads(outbox.heartbeat())["seq"] > 2, "the client must see that something is missing"
        assert missed(hub, 1).hello is not None
    running.cancel()


async def test_a_client_that_was_away_fetches_what_it_has_missed(mission: ScriptedMission) -> None:
    async with serve(app_of(mission), port=0) as address, client_at(address.url) as client:
        for number in range(5):
            mission.notify(Severity.INFO, f"notice {number}")
        while (back := (await client.get("/api/events", params={"after": 3})).json())["seq"] < 5:
            pass  # the events are on their way
        assert [event["notice"]["text"] for event in back["events"]] == ["notice 3", "notice 4"]
        assert [event["seq"] for event in back["events"]] == [4, 5]
        assert (back["seq"], back["hello"], back["mission_id"]) == (5, None, "scripted-1")
        assert (await client.get("/api/events", params={"after": 5})).json()["events"] == []
        from_elsewhere = (await client.get("/api/events", params={"after": 99})).json()
        assert from_elsewhere["hello"]["seq"] == 5
        assert (await client.get("/api/events", params={"after": -1})).status_code == 422


@pytest.mark.parametrize("away", [1, 7, 300, EVENTS_KEPT])
async def test_whoever_comes_back_gets_exactly_what_it_has_missed(mission: ScriptedMission, away: int) -> None:
    async with serve(app_of(mission), port=0) as address, client_at(address.url) as client:
        url = f"ws://127.0.0.1:{address.port}/api/events"
        async with stream_at(url) as websocket:
            hello = await receive(websocket)
            for number in range(5):
                mission.notify(Severity.INFO, f"seen {number}")
                seq = (await receive(websocket))["seq"]
        for number in range(away):
            mission.notify(Severity.INFO, f"missed {number}")
            await asyncio.sleep(0)
        async with stream_at(url) as websocket:
            again = await receive(websocket)
        answer = await client.get("/api/events", params={"after": seq})
    MissedEventsModel.model_validate_json(answer.text)
    back = answer.json()
    assert [event["notice"]["text"] for event in back["events"]] == [f"missed {number}" for number in range(away)]
    assert [event["seq"] for event in back["events"]] == list(range(seq + 1, again["seq"] + 1))
    assert (back["hello"], back["mission_id"]) == (None, hello["mission"]["mission_id"])


@pytest.mark.looptime
async def test_after_a_gap_beyond_the_store_the_whole_state_comes(mission: ScriptedMission) -> None:
    hub = EventHub(mission)
    running = asyncio.create_task(hub.run())
    await asyncio.sleep(0)
    for number in range(EVENTS_KEPT + 1):
        mission.notify(Severity.INFO, f"notice {number}")
        await asyncio.sleep(0)
    await asyncio.sleep(0.01)
    assert missed(hub, 0).hello is not None
    assert len(missed(hub, 1).events) == EVENTS_KEPT
    running.cancel()


async def test_each_picture_has_an_address_of_its_own_also_within_a_step(mission: ScriptedMission) -> None:
    hub = EventHub(mission)
    running = asyncio.create_task(hub.run())
    await asyncio.sleep(0)
    record = PicturesRecord(1, (PictureKind.VIEWS,), 0.0, 0.0, 9.0, 9.0)
    mission.make_step()
    for _ in range(2):
        mission.stream.publish(EventKind.PICTURES, record)
    await asyncio.sleep(0)
    events = [event for event in missed(hub, 0).events if event.kind == "pictures"]
    urls = [picture.url for event in events for picture in event.pictures if picture.kind is PictureKind.VIEWS]
    assert urls == [f"/api/mission/pictures/views.png?step=1&seq={event.seq}" for event in events]
    assert len(set(urls)) == 3
    assert [one.url for one in hub.hello().pictures if one.kind is PictureKind.VIEWS] == urls[-1:]
    running.cancel()


async def test_hello_brings_the_state_and_events_follow(mission: ScriptedMission) -> None:
    mission.make_step()
    async with serve(app_of(mission), port=0) as address:
        async with stream_at(f"ws://127.0.0.1:{address.port}/api/events") as websocket:
            hello = await receive(websocket)
            assert (hello["kind"], hello["seq"], hello["schema_version"]) == ("hello", 0, 5)
            assert [step["step"] for step in hello["steps"]] == [hello["latest_step"]["step"]] == [1]
            assert {picture["kind"] for picture in hello["pictures"]} == set(PictureKind)
            mission.make_step()
            mission.notify(Severity.WARNING, "wind", 2)
            received = [await receive(websocket) for _ in range(3)]
            assert [message["kind"] for message in received] == ["step", "pictures", "notice"]
            assert [message["seq"] for message in received] == [1, 2, 3]
        async with stream_at(f"ws://127.0.0.1:{address.port}/api/events") as websocket:
            hello = await receive(websocket)
            assert [one["text"] for one in hello["notices"]] == ["wind"]
            assert hello["notices"][0]["utc_s"] == pytest.approx(received[-1]["utc_s"], abs=1.0)


async def test_slow_client_does_not_hold_up_the_others(
    mission: ScriptedMission, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(events, "SEND_TIMEOUT_S", scaled_s(60.0))  # it reads nothing as long as the quick one takes
    message_count = 400
    async with serve(app_of(mission), port=0) as address:
        url = f"ws://127.0.0.1:{address.port}/api/events"
        async with stream_at(url, max_queue=1) as slow, stream_at(url) as quick:
            assert (await receive(quick))["kind"] == "hello"
            # The slow one reads nothing: its socket fills, then its outbox.
            for number in range(message_count):
                mission.notify(Severity.INFO, f"notice {number} " + 50_000 * "x")
                latest = await receive(quick)
                assert latest["notice"]["text"].startswith(f"notice {number} ")
                assert latest["seq"] == number + 1
            numbers = []
            async with asyncio.timeout(scaled_s(30.0)):
                while not numbers or numbers[-1] < message_count:
                    numbers.append((await receive(slow))["seq"])
            assert len(numbers) < message_count, "the slow client must have lost some"
            assert numbers == sorted(numbers)


async def test_silence_is_filled_with_heartbeats(mission: ScriptedMission) -> None:
    async with (
        serve(app_of(mission), port=0) as address,
        stream_at(f"ws://127.0.0.1:{address.port}/api/events") as websocket,
    ):
        await receive(websocket)
        heartbeat = json.loads(await websocket.recv())
        assert (heartbeat["kind"], heartbeat["seq"]) == ("heartbeat", 0)


async def test_all_that_tells_of_the_state_says_how_old_the_mission_is(mission: ScriptedMission) -> None:
    now_s = 100.0
    hub = EventHub(mission, now_s=lambda: now_s)
    running = asyncio.create_task(hub.run())
    await asyncio.sleep(0)
    with hub.connect() as outbox:
        await outbox.take()
        now_s = 101.0
        mission.advance(0.1)
        await asyncio.sleep(0)  # the mission's last sign of life
        now_s = 107.5
        mission.notify(Severity.WARNING, "a driver lives longer than its mission")
        await outbox.take()
        assert json.loads(outbox.heartbeat())["mission_age_s"] == 6.5
        mission.elapsed_s += 1.0
        with hub.connect() as late:
            assert json.loads(await late.take())["mission_age_s"] == 6.5
        # What the late one's greeting has found out is news for the others, but no sign of life either.
        changes = json.loads(await outbox.take())
        assert (changes["kind"], changes["mission_age_s"]) == ("changes", 6.5)
        mission.advance(0.1)
        await asyncio.sleep(0)
        assert json.loads(outbox.heartbeat())["mission_age_s"] == 0.0
    running.cancel()


async def test_foreign_pages_cannot_listen(mission: ScriptedMission) -> None:
    async with serve(app_of(mission), port=0) as address:
        url = f"ws://127.0.0.1:{address.port}/api/events"
        with pytest.raises(InvalidStatus) as refused:
            await stream_at(url, origin="http://evil.example")
        assert refused.value.response.status_code == 403


async def test_server_ends_with_open_connections_and_frees_its_port(mission: ScriptedMission) -> None:
    async with serve(app_of(mission), port=unused_port(socket.SOCK_STREAM)) as address:
        websocket = await stream_at(f"ws://127.0.0.1:{address.port}/api/events")
        await receive(websocket)
    with pytest.raises(ConnectionClosed):
        await receive(websocket)
    async with serve(app_of(mission), port=address.port) as again:
        assert again.url == f"http://127.0.0.1:{address.port}/"


async def test_port_in_use_is_told_before_anything_starts(mission: ScriptedMission) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(
            LinkError, match=rf"port {port} is in use by process {os.getpid()} \(.*\): stop it or choose"
        ):
            async with serve(app_of(mission), port=port):
                pass


async def test_a_connection_that_the_server_has_closed_ends_quietly(mission: ScriptedMission) -> None:
    """The server closes connections when it ends, also between two messages."""
    websocket = create_autospec(WebSocket, instance=True)
    websocket.send_text.side_effect = RuntimeError('Cannot call "send" once a close message has been sent.')
    websocket.receive.side_effect = asyncio.Event().wait
    async with asyncio.timeout(scaled_s(30.0)):
        await follow_events(websocket, EventHub(mission))
    websocket.send_text.assert_called_once()


def test_document_publishes_the_messages() -> None:
    schemas = make_document()["components"]["schemas"]
    kinds = set(schemas["ServerMessage"]["discriminator"]["mapping"])
    assert kinds == {"hello", "changes", "heartbeat", "answer"} | {str(kind) for kind in EventKind} - {"jump"}
    for reference in schemas["ServerMessage"]["oneOf"]:
        assert reference["$ref"].removeprefix("#/components/schemas/") in schemas
