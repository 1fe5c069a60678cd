"""A recorded mission at any time of it, directly and through the API."""

from __future__ import annotations

import asyncio
import json
import math
import shutil
import sqlite3
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import httpx
import pytest

from aos_gcs.api.app import create_app
from aos_gcs.api.events.hub import EventHub
from aos_gcs.clock import LoopClock
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.mission.model.checks import CheckStatus
from aos_gcs.mission.model.events import Event, EventKind, JumpRecord, NoticeRecord
from aos_gcs.mission.model.steps import PictureKind
from aos_gcs.ports import Severity
from aos_gcs.store.database import MissionDatabase
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.replay import MissionReplay
from tests.fakes.mission import STEP_INTERVAL_S, ScriptedMission
from tests.fakes.recording import LENGTH_S, START_UTC_S, record


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Event]]:
    folder = tmp_path_factory.mktemp("missions") / "recorded"
    return folder, asyncio.run(record(folder))


@pytest.fixture
async def replay(recording: tuple[Path, list[Event]]) -> AsyncIterator[MissionReplay]:
    with MissionReader(recording[0]) as reader:
        yield MissionReplay(reader, LoopClock())


def before(events: list[Event], kind: EventKind, time_s: float) -> list[Any]:
    start_utc_s = events[0].utc_s
    return [event.data for event in events if event.kind is kind and event.utc_s <= start_utc_s + time_s]


def write_events(folder: Path, events: list[Event]) -> None:
    database = MissionDatabase(folder, {})
    database.write([partial(MissionDatabase.add_event, event=event) for event in events])
    database.close()


@pytest.mark.parametrize("time_s", [0.0, 12.3, 39.9, 17.0, 1.0, 1e9, -5.0])
async def test_everything_is_as_of_that_time(
    replay: MissionReplay, recording: tuple[Path, list[Event]], time_s: float
) -> None:
    events = recording[1]
    replay.seek(time_s=25.0)
    replay.seek(time_s=time_s)
    known_s = min(max(time_s, 0.0), float(LENGTH_S))
    assert replay.replay().time_s == pytest.approx(known_s)
    assert replay.snapshot() == before(events, EventKind.SNAPSHOT, known_s)[-1]
    assert list(replay.steps()) == before(events, EventKind.STEP, known_s)
    shown = before(events, EventKind.PICTURES, known_s)
    picture = replay.picture(PictureKind.THERMAL)
    assert (picture.step if picture else None) == (shown[-1].step if shown else None)


async def test_the_timeline_names_phases_and_steps(replay: MissionReplay) -> None:
    line = replay.timeline()
    assert line.start_utc_s == START_UTC_S
    phases = [str(phase) for _, phase in line.phases]
    assert phases[:4] == ["arm", "takeoff", "line", "scan"]
    assert [step for _, step in line.steps] == list(range(1, len(line.steps) + 1))
    times_s = [time_s for time_s, _ in line.steps]
    assert times_s[1] - times_s[0] == pytest.approx(STEP_INTERVAL_S)


async def test_the_timeline_marks_notices_and_findings(
    replay: MissionReplay, recording: tuple[Path, list[Event]]
) -> None:
    line = replay.timeline()
    assert [record for _, record in line.notices] == before(recording[1], EventKind.NOTICE, LENGTH_S)
    ((found_at_s, finding),) = line.findings
    replay.seek(time_s=found_at_s - 1.5)
    assert replay.snapshot().findings == ()
    replay.seek(time_s=found_at_s + 1.5)
    assert [one.finding_id for one in replay.snapshot().findings] == [finding.finding_id]


def at_odd_moments(events: list[Event]) -> list[Event]:
    """Spread events as a clock stamps them: between the tenths of a second, the last one just after one of them."""
    return [replace(event, utc_s=START_UTC_S + 1.003 * (event.utc_s - START_UTC_S) - 0.08) for event in events]


async def test_who_goes_to_a_moment_that_the_api_names_sees_what_happened_then(
    recording: tuple[Path, list[Event]], tmp_path: Path
) -> None:
    events = at_odd_moments(recording[1])
    write_events(tmp_path / "odd", events)
    with MissionReader(tmp_path / "odd") as reader:
        replay = MissionReplay(reader, LoopClock())
        async with client_of(replay) as client:
            line = (await client.get("/api/replay")).json()
            end_s = line["replay"]["duration_s"]
            assert (await client.post("/api/replay", json={"time_s": end_s})).json()["time_s"] == end_s
            assert replay.snapshot() == before(events, EventKind.SNAPSHOT, math.inf)[-1]
            for step in line["steps"]:
                await client.post("/api/replay", json={"time_s": step["time_s"]})
                assert replay.steps()[-1].step == step["step"]
            for phase in line["phases"]:
                await client.post("/api/replay", json={"time_s": phase["time_s"]})
                assert replay.snapshot().phase == phase["phase"]


@pytest.mark.looptime
async def test_what_is_played_comes_once_and_in_order(
    replay: MissionReplay, recording: tuple[Path, list[Event]]
) -> None:
    running = asyncio.create_task(replay.run())
    with replay.subscribe() as events:
        replay.seek(speed=10.0, playing=True)
        await asyncio.sleep(5.0)
        assert replay.replay().time_s == float(LENGTH_S)
        assert not replay.replay().playing
        replay.seek(time_s=0.0)
        heard = []
        async for event in events:
            if event.kind is EventKind.JUMP:
                break
            if event.kind is not EventKind.SNAPSHOT:
                heard.append(event.data)
    running.cancel()
    recorded = [event.data for event in recording[1] if event.kind is not EventKind.SNAPSHOT]
    assert heard == [data for data in recorded if data not in before(recording[1], EventKind.NOTICE, 0.0)]


async def test_a_jump_brings_the_notices_before_it(replay: MissionReplay) -> None:
    with replay.subscribe() as events:
        replay.seek(time_s=15.0)
        jump = await anext(events)
    assert isinstance(jump.data, JumpRecord)
    assert [notice.text for notice in jump.data.notices][-2:] == ["second 0", "second 10"]


@pytest.mark.parametrize("speed", [0.0, 1e3, float("nan")])
async def test_speeds_out_of_range_are_refused(replay: MissionReplay, speed: float) -> None:
    with pytest.raises(ConfigurationError, match="speed"):
        replay.seek(speed=speed)


async def test_older_recordings_have_no_pictures(recording: tuple[Path, list[Event]], tmp_path: Path) -> None:
    write_events(tmp_path / "old", recording[1])
    with MissionReader(tmp_path / "old") as reader:
        old = MissionReplay(reader, LoopClock())
        old.seek(time_s=30.0)
        assert old.picture(PictureKind.INTEGRAL) is None


async def test_notices_of_older_recordings_have_the_times_of_their_events(
    recording: tuple[Path, list[Event]], tmp_path: Path
) -> None:
    """Older notices lack their own times."""
    events = [
        replace(event, data=replace(event.data, utc_s=0.0)) if isinstance(event.data, NoticeRecord) else event
        for event in recording[1]
    ]
    write_events(tmp_path / "old", events)
    with MissionReader(tmp_path / "old") as reader:
        old = MissionReplay(reader, LoopClock())
        with old.subscribe() as shown:
            old.seek(time_s=15.0)
            jump = await anext(shown)
    assert isinstance(jump.data, JumpRecord)
    times = {event.data.text: event.utc_s for event in events if isinstance(event.data, NoticeRecord)}
    assert [notice.utc_s for notice in jump.data.notices][-2:] == [times["second 0"], times["second 10"]]


async def test_a_recording_without_state_cannot_be_shown(tmp_path: Path) -> None:
    MissionDatabase(tmp_path / "empty", {}).close()
    with MissionReader(tmp_path / "empty") as reader, pytest.raises(InputDataError, match="no snapshot"):
        MissionReplay(reader, LoopClock())


def damaged(recording: Path, folder: Path, after_s: float) -> Path:
    """Copy a recording whose snapshots cannot be read after a time, apart from the last one."""
    shutil.copytree(recording, folder)
    connection = sqlite3.connect(folder / "mission.sqlite")
    (last,) = connection.execute("SELECT max(seq) FROM events WHERE kind = 'snapshot'").fetchone()
    connection.execute(
        "UPDATE events SET data = '{\"phase\": \"scan\"}' WHERE kind = 'snapshot' AND utc_s > ? AND seq < ?",
        (START_UTC_S + after_s, last),
    )
    connection.commit()
    connection.close()
    return folder


async def test_what_is_damaged_is_not_gone_to(recording: tuple[Path, list[Event]], tmp_path: Path) -> None:
    with MissionReader(damaged(recording[0], tmp_path / "damaged", 20.0)) as reader:
        replay = MissionReplay(reader, LoopClock())
        replay.seek(time_s=10.0)
        async with client_of(replay) as client:
            refused = await client.post("/api/replay", json={"time_s": 30.0})
            assert refused.status_code == 422
            assert "mission.sqlite: event" in refused.json()["message"]
            assert (await client.get("/api/replay")).json()["replay"]["time_s"] == 10.0


@pytest.mark.looptime
async def test_play_stops_before_what_is_damaged_and_says_so(
    recording: tuple[Path, list[Event]], tmp_path: Path
) -> None:
    with MissionReader(damaged(recording[0], tmp_path / "damaged", 20.0)) as reader:
        replay = MissionReplay(reader, LoopClock())
        running = asyncio.create_task(replay.run())
        with replay.subscribe() as events:
            replay.seek(time_s=18.0, playing=True)
            told = ""
            async for event in events:
                if isinstance(event.data, NoticeRecord) and event.data.severity is Severity.CRITICAL:
                    told = event.data.text
                    break
        assert "Replay stopped" in told
        assert not replay.replay().playing
        assert 20.0 <= replay.replay().time_s <= 21.0
        assert not running.done()
        running.cancel()


async def test_a_truncated_record_is_refused(recording: tuple[Path, list[Event]], tmp_path: Path) -> None:
    shutil.copytree(recording[0], tmp_path / "truncated")
    database = tmp_path / "truncated" / "mission.sqlite"
    database.write_bytes(database.read_bytes()[: database.stat().st_size // 2])
    with pytest.raises(InputDataError, match=r"mission\.sqlite is damaged"), MissionReader(database.parent) as reader:
        MissionReplay(reader, LoopClock())


@asynccontextmanager
async def client_of(replay: MissionReplay) -> AsyncIterator[httpx.AsyncClient]:
    transport = httpx.ASGITransport(create_app(replay, replay=replay))
    async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1:8080") as client:
        yield client


async def test_the_api_shows_and_moves_the_replay(replay: MissionReplay) -> None:
    async with client_of(replay) as client:
        moved = await client.post("/api/replay", json={"time_s": 20.0, "speed": 4.0})
        assert moved.json() == {"time_s": 20.0, "duration_s": 40.0, "speed": 4.0, "playing": False}
        mission = (await client.get("/api/mission")).json()
        assert mission["replay"] == moved.json()
        assert mission["allowed_actions"] == []
        assert len((await client.get("/api/mission/steps")).json()) == len(replay.steps()) > 0
        assert (await client.get("/api/mission/pictures/integral.png")).status_code == 200
        timeline = (await client.get("/api/replay")).json()
        assert timeline["replay"]["time_s"] == 20.0
        assert timeline["phases"][0]["phase"] == "arm"
        assert timeline["notices"][-1]["text"] == "second 30"
        assert [finding["finding_id"] for finding in timeline["findings"]] == [1]

        for path, order in (
            ("mission/actions", {"action": "hold"}),
            ("preflight/override", {"vehicle_id": 1, "check": "battery", "reason": "because"}),
            ("notices/acknowledge", {"notice_ids": [1]}),
        ):
            refused = await client.post(f"/api/{path}", json=order)
            assert (refused.status_code, refused.json()["id"]) == (409, "action_not_allowed")
            assert "only shows a mission" in refused.json()["message"]
        for body in ({"time_s": "soon"}, {"speed": -1}, {"speed": 1e6}, {"rewind": True}):
            assert (await client.post("/api/replay", json=body)).status_code == 422


async def test_a_mission_that_is_flown_has_no_replay() -> None:
    mission = ScriptedMission(LoopClock())
    transport = httpx.ASGITransport(create_app(mission))
    async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1:8080") as client:
        assert (await client.get("/api/replay")).status_code == 404
        assert (await client.get("/api/mission")).json()["replay"] is None


async def test_clients_are_greeted_anew_after_a_jump(replay: MissionReplay) -> None:
    hub = EventHub(replay, replay=replay)
    running = asyncio.create_task(hub.run())
    with hub.connect() as outbox:
        await outbox.take()
        await asyncio.sleep(0)
        replay.seek(time_s=20.0)
        hello = await outbox.take()
        assert '"kind":"hello"' in hello
        assert len(hub.hello().steps) == len(replay.steps())
        assert [notice.text for notice in hub.hello().notices][-1] == "second 10"
        assert json.loads(hub.missed_text(0))["hello"] is not None
    running.cancel()


def make_older(folder: Path) -> None:
    """Rewrite a recording as version 1 has written it."""
    connection = sqlite3.connect(folder / "mission.sqlite")
    for seq, text in connection.execute("SELECT seq, data FROM events WHERE kind = 'snapshot'").fetchall():
        snapshot = json.loads(text)
        snapshot["preflight"] = [
            {"vehicle_id": 1, "name": "link", "passed": True, "text": "heard 0.2 s ago"},
            {"vehicle_id": 1, "name": "battery", "passed": False, "text": "change the battery"},
        ]
        connection.execute("UPDATE events SET data = ? WHERE seq = ?", (json.dumps(snapshot), seq))
    connection.execute("ALTER TABLE frames DROP COLUMN time_sigma_s")
    connection.execute("DROP TABLE settings")
    connection.execute("PRAGMA user_version = 1")
    connection.commit()
    connection.close()


async def test_recordings_of_older_versions_can_be_shown(recording: tuple[Path, list[Event]], tmp_path: Path) -> None:
    shutil.copytree(recording[0], tmp_path / "older")
    make_older(tmp_path / "older")
    with MissionReader(tmp_path / "older") as reader:
        snapshot = MissionReplay(reader, LoopClock()).snapshot()
        assert [check.status for check in snapshot.preflight] == [CheckStatus.PASS, CheckStatus.FAIL]
        last = reader.last_snapshot()
        assert last is not None
        assert last.preflight == snapshot.preflight
        assert reader.settings() == ()
        assert {entry.time_sigma_s for entry in reader.frames()} <= {None}


async def test_recordings_of_newer_versions_are_refused(recording: tuple[Path, list[Event]], tmp_path: Path) -> None:
    shutil.copytree(recording[0], tmp_path / "newer")
    connection = sqlite3.connect(tmp_path / "newer" / "mission.sqlite")
    connection.execute("PRAGMA user_version = 99")
    connection.close()
    with pytest.raises(InputDataError, match="found version 99"):
        MissionReader(tmp_path / "newer")
