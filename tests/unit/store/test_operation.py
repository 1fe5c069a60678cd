"""Sorties of an operation: their list, their frames and their replay, directly and through the API."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path

import httpx
import pytest

from aos_gcs.api.app import create_app
from aos_gcs.api.events.hub import EventHub
from aos_gcs.clock import LoopClock
from aos_gcs.errors import InputDataError
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.mission.next_sortie import carried_findings
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.runtime.recorded.operation import Operation, ReplayedOperation
from aos_gcs.store.database import MissionDatabase
from aos_gcs.store.operation import read_operation
from aos_gcs.store.schema import DATABASE_NAME, MANIFEST_NAME
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission
from tests.fakes.recording import START_UTC_S, HandClock, record
from tests.fakes.viewed_step import record_viewed_step

FIRST, SECOND, STRANGER = "a-first", "b-second", "c-stranger"
SECOND_MANIFEST = {"operation": FIRST, "sortie": 2}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two sorties of an operation, a mission of its own, and what is none."""
    missions = tmp_path_factory.mktemp("missions")
    asyncio.run(record(missions / FIRST))
    asyncio.run(record(missions / SECOND, length_s=20, vehicles=4, manifest=SECOND_MANIFEST))
    asyncio.run(record(missions / STRANGER, length_s=2))
    (missions / "plans").mkdir()
    (missions / "notes.txt").write_text("not a mission")
    return missions


@pytest.fixture
async def client(recorded: Path) -> AsyncIterator[httpx.AsyncClient]:
    """Client of a replay of the second sortie."""
    with ReplayedOperation(recorded / SECOND, LoopClock()) as operation:
        shown = operation.replay
        viewer = await operation.viewer(SECOND)
        app = create_app(shown, replay=shown, viewer=viewer, operation=operation, sortie_choice=operation)
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://localhost") as client:
            yield client


@pytest.mark.parametrize("shown", [FIRST, SECOND])
def test_the_sorties_of_an_operation_are_found_from_each_of_them(recorded: Path, shown: str) -> None:
    first, second = read_operation(recorded / shown)
    assert [(first.mission_id, first.number), (second.mission_id, second.number)] == [(FIRST, 1), (SECOND, 2)]
    assert (first.duration_s, second.duration_s) == (40.0, 20.0)
    assert first.start_utc_s == pytest.approx(START_UTC_S, abs=1.0)
    assert first.steps > second.steps
    assert (first.outcome, first.findings, first.confirmed) == (Outcome.OPEN, 1, 0)


def test_a_mission_that_none_has_followed_is_the_only_sortie(recorded: Path) -> None:
    assert [sortie.mission_id for sortie in read_operation(recorded / STRANGER)] == [STRANGER]


@pytest.mark.parametrize(("name", "content"), [(MANIFEST_NAME, b"[]"), (MANIFEST_NAME, b"{"), (DATABASE_NAME, b"?")])
async def test_a_damaged_sortie_is_left_out_but_not_the_one_that_is_asked_for(
    tmp_path: Path, name: str, content: bytes
) -> None:
    await record(tmp_path / FIRST, length_s=2)
    await record(tmp_path / SECOND, length_s=2, manifest=SECOND_MANIFEST)
    (tmp_path / SECOND / name).write_bytes(content)
    assert [sortie.mission_id for sortie in read_operation(tmp_path / FIRST)] == [FIRST]
    with pytest.raises(InputDataError, match=SECOND):
        read_operation(tmp_path / SECOND)


async def test_clients_are_told_the_sorties(client: httpx.AsyncClient) -> None:
    sorties = (await client.get("/api/operation")).json()["sorties"]
    assert [sortie["mission_id"] for sortie in sorties] == [FIRST, SECOND]
    assert sorties[0]["folder"] == FIRST
    assert (sorties[0]["findings"], sorties[0]["covered_percent"]) == (1, None)


async def test_another_sortie_is_replayed_from_its_beginning(client: httpx.AsyncClient) -> None:
    assert (await client.post("/api/replay", json={"time_s": 9.0})).json()["time_s"] == 9.0
    answer = await client.post("/api/replay", json={"mission_id": FIRST})
    assert answer.json() == {"time_s": 0.0, "duration_s": 40.0, "speed": 1.0, "playing": False}
    mission = (await client.get("/api/mission")).json()
    assert (mission["mission_id"], len(mission["vehicles"])) == (FIRST, 8)
    assert len((await client.get("/api/replay")).json()["steps"]) > 3
    # Both are still sorties of the operation, and the way back is open.
    assert (await client.post("/api/replay", json={"mission_id": SECOND, "time_s": 5.0})).json()["time_s"] == 5.0
    assert len((await client.get("/api/mission")).json()["vehicles"]) == 4


async def test_the_steps_that_clients_are_told_are_those_of_the_sortie_shown(recorded: Path) -> None:
    with ReplayedOperation(recorded / FIRST, LoopClock()) as operation:
        operation.replay.seek(time_s=40.0)
        hub = EventHub(operation.replay, operation.replay)
        running = asyncio.create_task(hub.run())
        await asyncio.sleep(0)
        many = len(hub.hello().steps)
        assert await operation.show(SECOND)
        operation.replay.seek(time_s=20.0)
        await asyncio.sleep(0.01)
        assert 0 < len(hub.hello().steps) < many
        running.cancel()


@pytest.mark.parametrize("name", [STRANGER, "no-such-mission", "../a-first", "."])
async def test_only_sorties_of_the_operation_can_be_chosen(client: httpx.AsyncClient, name: str) -> None:
    answer = await client.post("/api/replay", json={"mission_id": name})
    assert (answer.status_code, answer.json()["id"]) == (404, "not_found")
    assert (await client.get(f"/api/viewer/1?mission_id={name}")).status_code == 404
    assert (await client.get("/api/mission")).json()["mission_id"] == SECOND


async def test_a_sortie_that_cannot_be_shown_leaves_the_replay_where_it_is(tmp_path: Path) -> None:
    await record(tmp_path / FIRST, length_s=2)
    MissionDatabase(tmp_path / SECOND, SECOND_MANIFEST).close()
    with ReplayedOperation(tmp_path / FIRST, LoopClock()) as operation:
        operation.replay.seek(time_s=1.0)
        with pytest.raises(InputDataError, match="no snapshot"):
            await operation.show(SECOND)
        assert operation.replay.snapshot().mission_id == FIRST
        assert operation.replay.replay().time_s == 1.0


async def test_a_replay_of_one_mission_has_no_others_to_choose() -> None:
    app = app_of(ScriptedMission(HandClock()))
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://localhost") as client:
        assert (await client.get("/api/operation")).status_code == 404


async def test_frames_and_findings_of_earlier_sorties_are_seen_in_a_later_one(tmp_path: Path) -> None:
    earlier = await record_viewed_step(tmp_path)
    mission = ScriptedMission(HandClock())
    mission.mission_id = "later"
    await record(tmp_path / "later", length_s=2, manifest={"operation": "m", "sortie": 2})
    found = await mission.add_finding((0.0, 0.0, 0.0), "seen by hand")
    found = replace(found, step=1)
    mission.findings = Findings(carried_findings([found], "m"))

    operation = Operation(tmp_path / "later")
    app = app_of(mission, viewer=await operation.viewer("later"), operation=operation)
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://localhost") as client:
        picture = await client.get("/api/findings/1/integral.png")
        assert (picture.status_code, picture.headers["content-type"]) == (200, "image/png")
        frame = "/api/viewer/1/frames/1/colour.png"
        assert (await client.get(frame)).status_code == 422, "the later mission has not recorded this step"
        of_earlier = await client.get(frame, params={"mission_id": earlier.name})
        assert of_earlier.status_code == 200
        assert of_earlier.headers["cache-control"].endswith("immutable")
