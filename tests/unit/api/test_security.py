"""Foreign web pages cannot command vehicles."""

from __future__ import annotations

import httpx
import pytest

from aos_gcs.api.access.request_checks import refusal
from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.actions import Action
from tests.fakes.app import OperatorClient, app_of
from tests.fakes.mission import ScriptedMission


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        ("127.0.0.1:8080", "http://127.0.0.1:8080"),
        ("localhost:8080", "http://localhost:8080"),
        ("[::1]:8080", "http://[::1]:8080"),
        ("192.168.4.1:8080", "http://192.168.4.1:8080"),
        ("field-laptop:8080", "http://field-laptop:8080"),
        ("127.0.0.1:8080", None),
    ],
)
def test_own_pages_and_programs_may_pass(host: str, origin: str | None) -> None:
    headers = {"host": host} | ({"origin": origin} if origin else {})
    assert refusal(headers, {"field-laptop"}, check_origin=True) is None


@pytest.mark.parametrize(
    "host",
    [
        "evil.example:8080",
        "",
        "127.0.0.1.evil.example",
        "[::1",
        "localhost.evil.example",
        "127.0.0.1:99999",
        "localhost:x",
    ],
)
def test_foreign_names_of_this_machine_are_refused(host: str) -> None:
    reason = refusal({"host": host}, (), check_origin=False)
    assert reason is not None
    assert reason.error_id == "unknown_host"


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        "null",
        "http://127.0.0.1:9999",
        "http://localhost:8080",
        "file://127.0.0.1:8080",
        "http://[::1",
    ],
)
def test_foreign_origins_are_refused(origin: str) -> None:
    headers = {"host": "127.0.0.1:8080", "origin": origin}
    reason = refusal(headers, (), check_origin=True)
    assert reason is not None
    assert reason.error_id == "cross_origin"


async def test_foreign_post_changes_nothing() -> None:
    mission = ScriptedMission(LoopClock())
    transport = httpx.ASGITransport(app_of(mission))
    async with OperatorClient(transport=transport, base_url="http://127.0.0.1:8080") as client:
        body = {"action": Action.START}
        foreign = await client.post("/api/mission/actions", json=body, headers={"Origin": "http://evil.example"})
        assert foreign.status_code == 403
        assert foreign.json()["id"] == "cross_origin"
        rebound = await client.get("/api/mission", headers={"Host": "evil.example"})
        assert rebound.status_code == 403
        assert mission.actions == []
        own = await client.post("/api/mission/actions", json=body, headers={"Origin": "http://127.0.0.1:8080"})
        assert own.status_code == 200
