"""The service's clock, on the virtual time of the event loop."""

from __future__ import annotations

import asyncio

import pytest

from aos_gcs.clock import LoopClock

pytestmark = pytest.mark.looptime


@pytest.mark.parametrize("speed", [0.5, 1.0, 20.0])
async def test_sleep_and_now_agree_at_any_speed(speed: float) -> None:
    clock, loop = LoopClock(speed), asyncio.get_running_loop()
    before_s, utc_s = loop.time(), clock.utc_s()
    await clock.sleep(10.0)
    assert clock.now_s() == pytest.approx(10.0, abs=1e-2 * speed)
    assert loop.time() - before_s == pytest.approx(10.0 / speed, abs=1e-2)
    assert clock.utc_s() - utc_s == pytest.approx(10.0, abs=1e-2 * speed)


async def test_a_timeout_ends_at_the_time_of_the_clock() -> None:
    clock = LoopClock(speed=10.0)
    await clock.sleep(5.0)
    with pytest.raises(TimeoutError):
        async with clock.timeout_at(25.0):
            await clock.sleep(1000.0)
    assert clock.now_s() == pytest.approx(25.0, abs=0.1)


async def test_a_timeout_that_is_over_already_ends_at_once() -> None:
    clock = LoopClock()
    await clock.sleep(5.0)
    with pytest.raises(TimeoutError):
        async with clock.timeout_at(1.0):
            await clock.sleep(1000.0)
    assert clock.now_s() == pytest.approx(5.0, abs=0.1)


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan")])
async def test_a_speed_must_be_positive(speed: float) -> None:
    with pytest.raises(ValueError, match="speed must be positive"):
        LoopClock(speed)
