"""``aos-gcs run`` as a process of its own: without vehicles, told to end, killed, frozen, with a simulated swarm."""

from __future__ import annotations

import asyncio
import json
import signal
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from aos_drivers.mavlink.service import open_mavlink
from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Clock, DriverContext, Fleet, FlightMode
from aos_gcs.store.reader import MissionReader
from tests.fakes.program import Program, running, unused_port
from tests.timing import scaled_s

CONFIGURATION = """
clock_speed = {speed}
[link]
urls = ["udpin://127.0.0.1:{port}"]
[mission]
vehicle_ids = [1, 2, 3]
area_deg = [[48.30007, 14.29966], [48.30007, 14.30034], [48.30079, 14.30034], [48.30079, 14.29966]]
origin_deg = [48.3, 14.3, 260.0]
auto_start = true
auto_return = true
[detection]
stop_at_first = true
[preflight]
upload_fence = true
set_return_height = true
[deadlines]
connect_s = {connect_s}
capture_s = {capture_s}
[safety]
max_link_age_s = {age_s}
max_position_age_s = {age_s}
[api]
enabled = false
[record]
folder = "{folder}"
"""


@pytest.fixture
def free_port() -> int:
    return unused_port()


def write_file(folder: Path, port: int, *, connect_s: float, speed: float = 1.0) -> str:
    file = folder / "mission.toml"
    text = CONFIGURATION.format(
        port=port,
        speed=speed,
        connect_s=connect_s,
        capture_s=20.0 * speed,
        age_s=3.0 * speed,
        folder=(folder / "missions").as_posix(),
    )
    file.write_text(text, encoding="utf-8")
    return str(file)


async def test_without_vehicles_it_ends_on_the_ground_and_says_so(tmp_path: Path, free_port: int) -> None:
    async with running(tmp_path, "run", write_file(tmp_path, free_port, connect_s=0.5)) as program:
        assert await program.ended(60) == 1
    assert program.output.startswith("failed: ")
    assert "0 of 3" in program.output
    assert str(program.mission_folder) in program.output
    assert "Traceback" not in program.log
    with MissionReader(program.mission_folder) as reader:
        outcome, final = reader.outcome(), reader.last_snapshot()
    assert outcome is not None
    assert outcome.outcome is Outcome.FAILED
    assert final is not None
    assert final.phase is Phase.DONE


async def test_told_to_end_it_does_so_quietly(tmp_path: Path, free_port: int) -> None:
    async with running(tmp_path, "run", write_file(tmp_path, free_port, connect_s=60.0)) as program:
        await program.until(lambda: list(program.missions.glob("*/mission.sqlite")) != [], 60)
        program.stop(signal.SIGTERM)
        assert await program.ended(30) == 128 + signal.SIGTERM
    assert "Traceback" not in program.log


@pytest.mark.slow
async def test_a_simulated_swarm_is_led_like_any_other(tmp_path: Path, free_port: int) -> None:
    link, speed = f"udpout://127.0.0.1:{free_port}", 10.0
    world = ("--trees-per-ha", "30", "--seed", "2", "--image-size", "192", "--errors", "none")
    service_file = write_file(tmp_path, free_port, connect_s=60.0 * speed, speed=speed)
    async with (
        running(tmp_path / "sim", "sim", "--vehicles", "3", "--link", link, "--speed", str(speed), *world),
        running(tmp_path, "run", service_file) as program,
    ):
        assert await program.ended(110) == 0, program.log
    assert program.output.startswith("found: ")
    with MissionReader(program.mission_folder) as reader:
        final = reader.last_snapshot()
    assert final is not None
    assert [vehicle.task for vehicle in final.vehicles] == [Task.LANDED] * 3


# --- killed and frozen ----------------------------------------------------------------------------------------------

SLOW_SPEED = 5.0
"""Speed at which no failsafe acts on a busy machine's delays alone."""
FAILSAFE_S = 10.0


@dataclass
class Search:
    """A service in the search, its vehicles, and somebody who listens to them and never speaks as a ground station."""

    program: Program
    witness: Fleet
    clock: Clock
    report_file: Path

    def report(self) -> dict[str, Any]:
        """Return what the simulator knows."""
        report: dict[str, Any] = json.loads(self.report_file.read_text(encoding="utf-8"))
        return report

    def modes(self) -> set[FlightMode]:
        return {vehicle.state.mode for vehicle in self.witness.vehicles().values()}

    async def all_return_by_themselves(self) -> None:
        await self._until(lambda: self.modes() == {FlightMode.RETURN}, 60.0)

    async def all_landed_apart(self) -> None:
        await self._until(lambda: self.report()["landed"] == 3, 120.0)
        assert self.report()["min_separation_m"] >= 1.5

    async def _until(self, condition: Callable[[], bool], timeout_s: float) -> None:
        async with asyncio.timeout(scaled_s(timeout_s)):
            while not condition():
                await self.clock.sleep(1.0)


@asynccontextmanager
async def searching(folder: Path) -> AsyncIterator[Search]:
    port, witness_port = unused_port(), unused_port()
    simulator = (
        *("sim", "--vehicles", "3", "--speed", str(SLOW_SPEED), "--trees-per-ha", "0", "--image-size", "64"),
        *("--errors", "none"),
        *("--link", f"udpout://127.0.0.1:{port}", "--link", f"udpout://127.0.0.1:{witness_port}"),
        *("--param", f"FS_GCS_TIMEOUT={FAILSAFE_S}", "--param", "RTL_ALT=6000"),
        *("--report-file", str(folder / "report.json")),
    )
    clock = LoopClock(SLOW_SPEED)
    silent = DriverContext(clock, is_healthy=lambda: False, notify=lambda _: None)
    service_file = write_file(folder, port, connect_s=60.0 * SLOW_SPEED, speed=SLOW_SPEED)
    async with (
        open_mavlink([f"udpin://127.0.0.1:{witness_port}"], silent) as witness,
        running(folder / "sim", *simulator),
        running(folder, "run", service_file) as program,
    ):
        await program.until_logged("Scanning", 120.0)
        yield Search(program, witness, clock, folder / "report.json")


@pytest.mark.slow
async def test_vehicles_of_a_service_that_is_killed_come_home_by_themselves(tmp_path: Path) -> None:
    async with searching(tmp_path) as search:
        search.program.stop(signal.SIGKILL)
        await search.all_return_by_themselves()
        await search.all_landed_apart()
    with MissionReader(search.program.mission_folder) as reader:
        assert reader.outcome() is None
        assert reader.last_snapshot() is not None
        changed = {record.vehicle_id: dict(record.former) for record in reader.settings()}
    former = {"RTL_ALT": 6000.0, "RTL_CLIMB_MIN": 0.0}
    assert changed == {1: former, 2: former, 3: former}, "to be set back by hand"


@pytest.mark.slow
async def test_a_service_frozen_until_the_failsafe_acts_finds_its_vehicles_on_their_way_home(tmp_path: Path) -> None:
    async with searching(tmp_path) as search:
        search.program.stop(signal.SIGSTOP)
        await search.all_return_by_themselves()
        search.program.stop(signal.SIGCONT)
        await search.program.until_logged("left the swarm: its", 30.0)
        await search.all_landed_apart()
        assert await search.program.ended(60.0) in {0, 1}
    assert "Traceback" not in search.program.log
    with MissionReader(search.program.mission_folder) as reader:
        final = reader.last_snapshot()
        restored = {record.vehicle_id for record in reader.settings() if record.is_restored}
    assert final is not None
    assert [vehicle.task for vehicle in final.vehicles] == [Task.LANDED] * 3
    assert restored == {1, 2, 3}
