"""A target that moves, followed by a whole mission on a fake fleet, in virtual time."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest

from aos_gcs.mission.model.phase import Outcome
from tests.fakes.mission_flight import EXACT, TARGET, flying, prepare

SPEED_MPS = 4.0

pytestmark = pytest.mark.virtual


async def test_a_runner_is_found_and_the_estimate_runs_along() -> None:
    flight = prepare(errors=EXACT)
    place = flight.fleet.members[1].target_enu_m
    assert place is not None
    assert all(vehicle.target_enu_m is place for vehicle in flight.fleet.members.values())

    async def run_west() -> None:
        before_s = flight.clock.now_s()
        while True:
            await flight.clock.sleep(0.05)
            now_s = flight.clock.now_s()
            if any(step.target_enu_m for step in flight.view.steps()):
                place[0] -= SPEED_MPS * (now_s - before_s)
            before_s = now_s

    async with flying(flight) as run:
        running = asyncio.ensure_future(run_west())
        assert await run is Outcome.FOUND
        running.cancel()
    steps = [step for step in flight.view.steps() if step.target_enu_m is not None]
    assert steps[-1].target_enu_m is not None
    assert steps[-1].target_enu_m[0] < TARGET[0] - 3.0
    target = flight.view.snapshot().target
    assert target is not None
    assert target.velocity_enu_mps is not None
    assert target.velocity_enu_mps[0] == pytest.approx(-SPEED_MPS, abs=1.0)
    assert np.hypot(*np.subtract(target.position_enu_m[:2], steps[-1].target_enu_m[:2])) < 0.5
