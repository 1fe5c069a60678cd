"""The loop of missions in virtual time."""

from __future__ import annotations

import asyncio
import threading

import pytest

from aos_gcs.runtime.simulated.virtual_time import run


def test_what_is_handed_to_a_thread_is_computed_at_once() -> None:
    async def work() -> tuple[int, float]:
        loop = asyncio.get_running_loop()
        begin_s = loop.time()
        return await asyncio.to_thread(threading.get_ident), loop.time() - begin_s

    assert run(work()) == (threading.get_ident(), 0.0)


def test_errors_of_such_work_reach_the_one_who_waits() -> None:
    async def work() -> None:
        await asyncio.to_thread(int, "no number")

    with pytest.raises(ValueError, match="no number"):
        run(work())
