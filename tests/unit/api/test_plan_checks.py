"""Checking plans: for everybody, at a bounded cost; whatever changes something is for operators."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from aos_gcs.api.access.body_limit import MAX_BODY_BYTES
from aos_gcs.api.access.operators import Role
from aos_gcs.api.access.plan_check_turns import MAX_PER_CLIENT, MAX_PER_ROLE, PlanChecks, TooManyChecksError
from aos_gcs.clock import LoopClock
from tests.fakes.app import app_of
from tests.fakes.mission import ORIGIN, ScriptedMission

CODE = "correct-horse"
SIDE_DEG = 1e-3
AREA = [
    {"latitude_deg": ORIGIN.latitude_deg + north * SIDE_DEG, "longitude_deg": ORIGIN.longitude_deg + east * SIDE_DEG}
    for north, east in ((0, 0), (0, 1), (1, 1), (1, 0))
]
PLAN: dict[str, Any] = {"vehicles": 6, "area": AREA}


@pytest.fixture
async def client(tmp_path: Path) -> AsyncIterator[httpx.AsyncClient]:
    """An observer's."""
    mission = ScriptedMission(LoopClock())
    app = app_of(mission, plans_folder=tmp_path / "plans", operator_code=CODE)
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://127.0.0.1:8080") as client:
        yield client


async def test_an_observer_sees_problems_and_estimate(client: httpx.AsyncClient) -> None:
    good = await client.post("/api/plan/check", json=PLAN)
    assert good.status_code == 200
    assert good.json()["estimate"]["flight_s"] > 0.0
    bad = await client.post("/api/plan/check", json=PLAN | {"area": []})
    assert [problem["field"] for problem in bad.json()["problems"]] == ["area"]


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("POST", "/api/plan/apply"),
        ("POST", "/api/plan/import"),
        ("PUT", "/api/plans/mine"),
        ("DELETE", "/api/plans/mine"),
        ("POST", "/api/plan/check/"),
        ("POST", "/api//plan/check"),
    ],
)
async def test_an_observer_changes_nothing(client: httpx.AsyncClient, method: str, path: str) -> None:
    response = await client.request(method, path, json=PLAN)
    assert (response.status_code, response.json()["id"]) == (403, "operators_only")


async def test_foreign_pages_cannot_have_plans_checked(client: httpx.AsyncClient) -> None:
    response = await client.post("/api/plan/check", json=PLAN, headers={"Origin": "http://elsewhere.example"})
    assert (response.status_code, response.json()["id"]) == (403, "cross_origin")


async def test_bodies_that_are_too_large_are_refused_by_what_they_announce_and_by_what_comes(
    client: httpx.AsyncClient,
) -> None:
    announced = await client.post("/api/plan/check", content=b" " * (MAX_BODY_BYTES + 1))
    assert (announced.status_code, announced.json()["id"]) == (413, "too_large")

    async def endless() -> AsyncIterator[bytes]:
        while True:
            yield b" " * 65536

    assert (await client.post("/api/plan/check", content=endless())).status_code == 413


async def test_a_client_waits_for_its_own_checks_and_is_refused_beyond_them() -> None:
    checks, order = PlanChecks(), []
    release = asyncio.Event()

    async def ask(role: Role, client: str) -> None:
        async with checks.turn(role, client):
            order.append((role, client))
            await release.wait()

    async with asyncio.TaskGroup() as group:
        for _ in range(MAX_PER_CLIENT):
            group.create_task(ask(Role.OBSERVER, "a"))
        await asyncio.sleep(0)
        with pytest.raises(TooManyChecksError, match="Try again"):
            await ask(Role.OBSERVER, "a")
        group.create_task(ask(Role.OBSERVER, "b"))
        group.create_task(ask(Role.OPERATOR, "a"))
        await asyncio.sleep(0)
        # One of all observers; the operator waits for none of them.
        assert order == [(Role.OBSERVER, "a"), (Role.OPERATOR, "a")]
        release.set()
    assert sorted(order) == sorted([*[(Role.OBSERVER, "a")] * 2, (Role.OBSERVER, "b"), (Role.OPERATOR, "a")])
    await ask(Role.OBSERVER, "a")


async def test_all_observers_together_are_bounded() -> None:
    checks = PlanChecks()

    async def ask(client: str) -> None:
        async with checks.turn(Role.OBSERVER, client):
            await asyncio.Event().wait()

    tasks = [asyncio.create_task(ask(str(number))) for number in range(MAX_PER_ROLE)]
    await asyncio.sleep(0)
    with pytest.raises(TooManyChecksError):
        await ask("one more")
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
    async with checks.turn(Role.OBSERVER, "one more"):
        pass


async def test_a_plan_that_would_take_minutes_to_check_is_refused_in_words(client: httpx.AsyncClient) -> None:
    forest = {"canopy_height_m": 18.0, "crown_base_m": 4.4, "occluder_size_m": 1.4, "occlusion": 0.85}
    slow = PLAN | {"vehicles": 100, "search_speed_mps": 0.1, "rate_hz": 10.0, "forest": forest, "lowest_layer_m": 40.0}
    answer = await client.post("/api/plan/check", json=slow)
    assert answer.status_code == 200
    (problem,) = [one for one in answer.json()["problems"] if one["blocking"]]
    assert problem["field"] == "search_speed_mps"


async def test_a_check_that_runs_out_of_memory_is_refused_in_words(
    client: httpx.AsyncClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    def exhausted(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr("aos_gcs.api.routers.plans.propose", exhausted)
    answer = await client.post("/api/plan/check", json=PLAN)
    assert answer.status_code == 422
    assert "more memory than the station has" in answer.json()["message"]


async def test_a_proposed_geofence_may_have_more_corners_than_one_that_is_sent(
    client: httpx.AsyncClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("aos_gcs.api.convert.plans.homes", lambda *_: {})
    angles = [math.tau * index / 490 for index in range(490)]
    area = [
        {
            "latitude_deg": ORIGIN.latitude_deg + SIDE_DEG * math.cos(angle),
            "longitude_deg": ORIGIN.longitude_deg + SIDE_DEG * math.sin(angle),
        }
        for angle in angles
    ]
    answer = await client.post("/api/plan/check", json=PLAN | {"area": area})
    assert answer.status_code == 200
    fence = answer.json()["fence"]
    assert len(fence) > 500
    sent = await client.post("/api/plan/check", json=PLAN | {"area": area, "fence": fence})
    assert sent.status_code == 422
