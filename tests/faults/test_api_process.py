"""The pulse of a station whose dashboard's process dies, stands still or spins: measured in real time."""

from __future__ import annotations

import asyncio
import itertools
import os
import signal
from pathlib import Path

import pytest

from aos_gcs.mission.health import LoopMonitor
from aos_gcs.mission.model.actions import Action
from tests.fakes.api_process import Station, station
from tests.faults.test_workers import MAX_GAP_S, beat

pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]


async def kill(flight: Station) -> None:
    for count in (1, 2):
        os.kill(await flight.process_id(), signal.SIGKILL)
        await flight.until_told("available again", count)


async def stop(flight: Station) -> None:
    os.kill(await flight.process_id(), signal.SIGSTOP)
    await flight.until_told("does not answer")
    await flight.until_told("available again")


async def spin(flight: Station) -> None:
    await flight.until_told("does not answer")
    await flight.until_told("available again")


@pytest.mark.parametrize("fault", [kill, stop, spin])
async def test_the_heartbeat_goes_on(tmp_path: Path, fault: object) -> None:
    monitor, beats_s = LoopMonitor(), list[float]()
    module = {"module": "tests.fakes.spinning_api"} if fault is spin else {}
    async with station(tmp_path, **module) as flight:
        await flight.mission.act(Action.START, None)
        tasks = [asyncio.create_task(one) for one in (monitor.run(lambda _: None), beat(monitor, beats_s))]
        await asyncio.sleep(2.0)
        await fault(flight)  # type: ignore[operator]
        await asyncio.sleep(2.0)
        flown_s = flight.mission.elapsed_s
        for task in tasks:
            task.cancel()
    gaps_s = [after - before for before, after in itertools.pairwise(beats_s)]
    assert len(gaps_s) >= 3
    assert max(gaps_s) <= MAX_GAP_S
    assert monitor.longest_stall_s == 0.0
    assert flown_s >= 3.0, "the mission goes on"
