"""The dashboard in a process of its own: commands, its death, its silence, and the death of the flight's process."""

from __future__ import annotations

import os
import signal
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import httpx
import pytest

from aos_gcs.config.model import ApiConfig
from aos_gcs.errors import LinkError
from aos_gcs.mission.model.actions import Action
from aos_gcs.ports import Severity
from aos_gcs.runtime.dashboard import supervisor as dashboard_supervisor
from aos_gcs.runtime.dashboard.start import ApiStart
from aos_gcs.runtime.processes import supervisor
from tests.fakes.api_process import CODE, Station, station
from tests.fakes.app import OperatorClient
from tests.fakes.program import gone, running
from tests.integration.test_run_service import unused_port, write_file

pytestmark = pytest.mark.timeout(180)


@asynccontextmanager
async def operator(station: Station) -> AsyncIterator[OperatorClient]:
    async with OperatorClient(base_url=station.url, timeout=60.0) as client:
        answer = await client.post("/api/session", json={"code": CODE, "name": "Ada"})
        assert answer.status_code == 200, answer.text
        yield client


async def notices(client: httpx.AsyncClient) -> list[str]:
    hello = (await client.get("/api/events", params={"after": 10**6})).json()["hello"]
    return [notice["text"] for notice in hello["notices"]]


async def test_operators_command_a_flight_in_another_process_and_stay_signed_in_when_theirs_is_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The process is killed first, and its successor stopped."""
    async with station(tmp_path) as flight, operator(flight) as client:
        flight.mission.notify(Severity.CRITICAL, "Vehicle 3 sinks")
        started = await client.post("/api/mission/actions", json={"action": "start"})
        assert started.status_code == 200, started.text
        assert flight.mission.operators == ["Ada"]
        refused = await client.post("/api/mission/actions", json={"action": "hold", "vehicle_ids": [99]})
        assert (refused.status_code, refused.json()["id"]) == (409, "action_not_allowed")
        first = await flight.process_id()
        os.kill(first, signal.SIGKILL)
        await flight.until_told("has ended (SIGKILL) and is replaced. The mission goes on")
        flight.mission.notify(Severity.WARNING, "Vehicle 4: gust")
        await flight.until_told("available again")
        assert await flight.process_id() != first
        held = await client.post("/api/mission/actions", json={"action": "hold"})
        assert held.status_code == 200, held.text
        assert flight.mission.actions == [(Action.START, None), (Action.HOLD, None)]
        told = await notices(client)
        assert {"Vehicle 3 sinks", "Vehicle 4: gust", "The dashboard is available again"} <= set(told)
        assert len((await client.get("/api/mission/steps")).json()) == len(flight.mission.steps())

        second = await flight.process_id()
        monkeypatch.setattr(supervisor, "SILENT_S", 2.0)
        os.kill(second, signal.SIGSTOP)
        await flight.until_told("does not answer and is replaced")
        monkeypatch.undo()  # a busy machine may keep the new process silent for longer
        await flight.until_told("available again", 2)
        assert await flight.process_id() != second
        assert (await client.get("/api/mission")).status_code == 200


async def test_a_process_that_cannot_be_started_is_told_before_anything_flies(tmp_path: Path) -> None:
    with pytest.raises(LinkError, match=r"cannot be started: has ended \(status 1\)"):
        async with station(tmp_path, module="tests.fakes.no_such_program"):
            pass


async def test_nothing_is_opened_where_it_is_switched_off(tmp_path: Path) -> None:
    start = ApiStart(ApiConfig(enabled=False), CODE, tmp_path, tmp_path)
    async with dashboard_supervisor.open_api_process(start, lambda _: None) as api:
        assert api is None


@pytest.fixture
def configuration(tmp_path: Path) -> str:
    """Write a configuration whose vehicles never come, with a dashboard."""
    file = Path(write_file(tmp_path, unused_port(), connect_s=60.0))
    file.write_text(file.read_text(encoding="utf-8").replace("enabled = false", "port = 0"), encoding="utf-8")
    return str(file)


async def test_it_ends_with_the_flights_process(tmp_path: Path, configuration: str) -> None:
    async with running(tmp_path, "run", configuration) as program:
        await program.until_logged("Dashboard for operators", 60)
        (pid,) = await program.children("aos_gcs.runtime.dashboard.process")
        program.stop(signal.SIGKILL)
        await program.ended(10)
        await gone(pid)
