"""The pulse of a station whose dashboard's process dies, stands still or spins: measured in real time."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from aos_gcs.mission.model.actions import Action
from tests.fakes.api_process import Station, station
from tests.fakes.pulse import beating

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
    module = {"module": "tests.fakes.spinning_api"} if fault is spin else {}
    async with station(tmp_path, **module) as flight:
        await flight.mission.act(Action.START, None)
        async with beating():
            await fault(flight)  # type: ignore[operator]
        flown_s = flight.mission.elapsed_s
    assert flown_s >= 3.0, "the mission goes on"
