"""Waits for the disk: a slow disk is told from a station that is itself late."""

from __future__ import annotations

import asyncio
from contextlib import suppress

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.patience import patience
from tests.fakes.hand_time import stand_still

pytestmark = pytest.mark.looptime


async def test_a_wait_ends_at_its_limit_on_a_loop_that_is_on_time() -> None:
    started_s = asyncio.get_running_loop().time()
    with pytest.raises(TimeoutError):
        async with patience(1.0) as wait:
            await asyncio.sleep(60.0)
    assert asyncio.get_running_loop().time() - started_s == pytest.approx(1.0, abs=0.01)
    assert not wait.is_own_fault


async def test_time_in_which_the_loop_stands_still_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    answered = asyncio.Event()
    async with patience(1.0) as wait:
        await asyncio.sleep(0.2)
        stand_still(monkeypatch, 1.5)
        asyncio.get_running_loop().call_later(0.3, answered.set)
        await answered.wait()
    assert wait.late_s == pytest.approx(1.5, abs=0.1)


async def test_a_loop_that_is_late_again_and_again_still_ends_the_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    started_s = asyncio.get_running_loop().time()
    with suppress(TimeoutError):
        async with patience(1.0) as wait:
            for _ in range(10):
                stand_still(monkeypatch, 0.9)
                await asyncio.sleep(0.06)
    assert asyncio.get_running_loop().time() - started_s < 5.0
    assert wait.is_own_fault


@pytest.mark.parametrize(
    ("stall_s", "words"), [(0.0, "The disk does not answer: step 4"), (1.5, "This station is overloaded: step 4")]
)
async def test_the_notice_names_what_was_late(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, stall_s: float, words: str
) -> None:
    async with Journal(LoopClock()).with_disk_timeout("step 4"):
        await asyncio.sleep(0.1)
        stand_still(monkeypatch, stall_s)
        await asyncio.Event().wait()
    assert caplog.messages[-1].startswith(f"{words} may be missing in the record")
