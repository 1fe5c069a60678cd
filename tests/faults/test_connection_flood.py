"""Holds of an operator while hostile connections stand at the dashboard, some behind the operator's own address."""

from __future__ import annotations

import asyncio
import multiprocessing
from pathlib import Path
from urllib.parse import urlsplit

import httpx
import pytest
from websockets.sync.client import connect

from aos_gcs.mission.model.actions import Action
from tests.benchmarks.bench_connections import attack, hold_by_request, hold_by_stream
from tests.fakes.api_process import CODE, station
from tests.timing import scaled_s

pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]

CONNECTIONS = 1000
HOLDS = 3


async def test_an_operator_holds_all_through_an_attack_on_the_dashboard(tmp_path: Path) -> None:
    """Every hold is answered, and carried out once."""
    context = multiprocessing.get_context("spawn")
    async with station(tmp_path) as flight:
        await flight.mission.act(Action.START, None)
        flight.mission.actions.clear()
        async with httpx.AsyncClient(base_url=flight.url) as client:
            (await client.post("/api/session", json={"code": CODE, "name": "Ada"})).raise_for_status()
            await client.get("/api/mission")
            cookies = client.cookies
        port, begin, answers = urlsplit(flight.url).port, context.Event(), context.Queue()
        attackers = [
            context.Process(target=attack, args=(port, number, CONNECTIONS, begin, answers), daemon=True)
            for number in range(2)
        ]
        for attacker in attackers:
            attacker.start()
        try:
            async with asyncio.timeout(scaled_s(120.0)):
                await asyncio.to_thread(hold_through, flight.url, cookies, begin, answers)
        finally:
            for attacker in attackers:
                attacker.kill()
                attacker.join()
    assert flight.mission.actions == [(Action.HOLD, None)] * 2 * HOLDS


def hold_through(url: str, cookies: httpx.Cookies, begin: object, answers: object) -> None:
    """Hold by both ways once the attackers have tried all of their connections."""
    cookie = "; ".join(f"{name}={value}" for name, value in cookies.items())
    with connect(f"{url.replace('http', 'ws')}api/events", additional_headers={"Cookie": cookie}) as stream:
        begin.set()  # type: ignore[attr-defined]
        for _ in range(2):
            answers.get()  # type: ignore[attr-defined]
        for number in range(HOLDS):
            hold_by_stream(stream, f"stream-{number:04}")
            hold_by_request(url, cookies)
