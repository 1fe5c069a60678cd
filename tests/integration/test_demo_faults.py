"""What becomes of ``aos-gcs demo`` when its processes are killed or told to end in mid-mission."""

from __future__ import annotations

import os
import signal
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.mission.model.events import EventKind
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.store.reader import MissionReader
from tests.fakes.program import Program, gone, is_running, kill, running

SMALL = (
    *("--vehicles", "2", "--image-size", "64", "--trees-per-ha", "0", "--seed", "2", "--speed", "6"),
    *("--errors", "none", "--animals", "0", "--stones", "0"),
)
UNDER_WAY = "live: step 3"
START_TIMEOUT_S = 60


async def start_and_find_simulator(program: Program) -> int:
    await program.until_logged(UNDER_WAY, START_TIMEOUT_S)
    (simulator,) = await program.children("aos_gcs sim")
    return simulator


def check_readable(folder: Path, outcome: Outcome | None) -> None:
    with MissionReader(folder) as reader:
        recorded = reader.outcome()
        assert (None if recorded is None else recorded.outcome) == outcome
        assert len(reader.steps()) >= 2
        assert all(frame.load().image.any() for frame in reader.frames(2))
        assert any(event.kind is EventKind.SNAPSHOT for event in reader.events())
        assert reader.last_snapshot() is not None


def modes_commanded(folder: Path) -> dict[int, list[int]]:
    """Return the custom modes that each vehicle was told to take, from the log of the raw traffic."""
    (log,) = folder.rglob("*.tlog")
    connection = mavutil.mavlink_connection(str(log))
    modes: dict[int, list[int]] = {}
    while (message := connection.recv_match(type="COMMAND_LONG")) is not None:
        if message.command == mavlink.MAV_CMD_DO_SET_MODE:
            modes.setdefault(message.target_system, []).append(int(message.param2))
    connection.close()
    return modes


async def test_a_killed_simulator_ends_the_mission_with_one_clear_message(tmp_path: Path) -> None:
    async with running(tmp_path, "demo", *SMALL, "--headless", "--json") as program:
        kill(await start_and_find_simulator(program))
        code = await program.ended(60)
    assert code == 1
    assert program.log.count("All vehicles are lost") == 1
    assert "Traceback" not in program.log
    result = program.result()
    assert result["found"] is False
    assert result["landed"] == 0
    check_readable(program.mission_folder, Outcome.FAILED)


async def test_a_killed_demo_leaves_a_readable_record_and_no_simulator(tmp_path: Path) -> None:
    async with running(tmp_path, "demo", *SMALL, "--headless", "--json") as program:
        simulator = await start_and_find_simulator(program)
        try:
            program.stop(signal.SIGKILL)
            assert await program.ended(10) == -signal.SIGKILL
            await gone(simulator)
        finally:
            kill(simulator)
    assert program.output == ""
    check_readable(program.mission_folder, None)


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def beset_demo(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Program]:
    """One flight for the tests below: one after the other, they kill what works beside it, until it has landed."""
    folder = tmp_path_factory.mktemp("beset")
    async with running(folder, "demo", *SMALL, "--port", "0", "--exit-when-done", "--json") as program:
        await program.until_logged(UNDER_WAY, START_TIMEOUT_S)
        yield program


@pytest.mark.asyncio(loop_scope="module")
async def test_a_demo_goes_on_when_its_image_workers_are_killed(beset_demo: Program) -> None:
    workers = await beset_demo.children("aos_gcs.workers.child")
    assert len(workers) == 3, "image analysis, image decoding, and the map of the searched ground"
    for pid in workers:
        kill(pid)
    await beset_demo.until_logged("has ended (SIGKILL)", START_TIMEOUT_S)
    await beset_demo.until_logged("live: step 8", START_TIMEOUT_S)
    assert not [pid for pid in workers if await is_running(pid)]


@pytest.mark.asyncio(loop_scope="module")
async def test_a_demo_flies_on_and_lands_when_its_dashboards_process_is_killed_and_then_stopped(
    beset_demo: Program,
) -> None:
    program = beset_demo
    kill(await program.child("runtime.dashboard.process", START_TIMEOUT_S))
    await program.until_logged("has ended (SIGKILL) and is replaced. The mission goes on", START_TIMEOUT_S)
    successor = await program.child("runtime.dashboard.process", START_TIMEOUT_S)
    os.kill(successor, signal.SIGSTOP)
    assert await program.ended(120) == 0, program.log
    assert not await is_running(successor)
    assert program.result()["landed"] == 2
    assert "Traceback" not in program.log
    assert "link lost" not in program.log
    check_readable(program.mission_folder, Outcome.FOUND)


async def test_a_demo_told_to_end_in_flight_sends_all_home_first(tmp_path: Path) -> None:
    async with running(tmp_path, "demo", *SMALL, "--headless", "--json") as program:
        simulator = await start_and_find_simulator(program)
        program.stop(signal.SIGTERM)
        code = await program.ended(30)
        assert not await is_running(simulator)
    assert code == 128 + signal.SIGTERM
    assert "Traceback" not in program.log
    check_readable(program.mission_folder, Outcome.ABORTED)
    modes = modes_commanded(program.mission_folder)
    assert {vehicle_id: last[-1] for vehicle_id, last in modes.items()} == dict.fromkeys(
        (1, 2), mavlink.COPTER_MODE_RTL
    )
