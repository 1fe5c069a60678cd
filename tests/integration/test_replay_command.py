"""``aos-gcs replay`` as its users start it."""

from __future__ import annotations

import re
import signal
from pathlib import Path

import pytest

from tests.fakes.app import client_at
from tests.fakes.command_line import exit_status
from tests.fakes.program import running
from tests.fakes.recording import record


async def test_a_recorded_mission_is_served_until_ctrl_c(tmp_path: Path) -> None:
    await record(tmp_path / "mission")
    async with running(tmp_path / "run", "replay", str(tmp_path / "mission"), "--port", "0") as program:
        await program.until_logged("Dashboard for operators: ", 60)
        found = re.match(r"(http://[^/]+)/#code=(\S+)", program.operator_url)
        assert found is not None
        async with client_at(found[1]) as client:
            assert (await client.post("/api/replay", json={"time_s": 10.0})).status_code == 403
            assert (await client.post("/api/session", json={"code": found[2], "name": "Ada"})).status_code == 200
            assert (await client.post("/api/replay", json={"time_s": 10.0})).json()["time_s"] == 10.0
            assert (await client.get("/api/mission")).json()["phase"] == "scan"
        program.stop(signal.SIGINT)
        assert await program.ended(10.0) == 130


def test_a_folder_without_a_mission_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_status(["--log-level", "error", "replay", str(tmp_path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "is not a mission folder" in line
