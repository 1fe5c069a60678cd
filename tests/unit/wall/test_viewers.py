"""Viewers of the wall: how often they are told what, and that those who are told the same share it."""

from __future__ import annotations

import asyncio
from contextlib import ExitStack

import numpy as np
import pytest

from aos_gcs.api.convert.wall import SHARED_FOR_S, WallMessages
from aos_gcs.errors import InputDataError
from aos_gcs.wall.board import FEW_VIEWERS, GAP_OF_MANY_S, GAP_S, Wall
from aos_gcs.wall.model import TileKind, TileName
from aos_gcs.wall.watch import HEARTBEAT_S, Watch
from tests.fakes.wall import (
    START_UTC_S,
    CountedWorker,
    GrowingRecord,
    loop_time_s,
    next_pictures,
    running,
    utc_s,
)

pytestmark = pytest.mark.looptime(idle_timeout=60)

FIRST = TileName(1, TileKind.COLOUR)
SECOND = TileName(2, TileKind.COLOUR)


async def test_no_more_pictures_than_the_rate_and_a_slow_viewer_has_the_newest(
    wall: Wall, record: GrowingRecord, worker: CountedWorker
) -> None:
    async with running(wall):
        with wall.watch() as quick, wall.watch() as slow:
            quick.choose((FIRST,))
            slow.choose((FIRST,))
            counts = asyncio.create_task(_picture_times_s(quick, 10.0))
            for number in range(50):  # five per second
                record.add(1, utc_s(), grey=number)
                await asyncio.sleep(0.2)
            late = await next_pictures(slow)
            shown_at_utc_s = late.pictures[FIRST].utc_s
            times_s = await counts
    assert 15 <= len(times_s) <= 21
    assert len(worker.rendered) <= 21
    assert utc_s() - shown_at_utc_s < 1.0
    assert len(late.pictures) == 1


async def _picture_times_s(watch: Watch, duration_s: float) -> list[float]:
    times_s: list[float] = []
    try:
        async with asyncio.timeout(duration_s):
            while True:
                await next_pictures(watch)
                times_s.append(utc_s())
    except TimeoutError:
        return times_s


@pytest.mark.parametrize(("viewers", "gap_s"), [(FEW_VIEWERS, GAP_S), (FEW_VIEWERS + 1, GAP_OF_MANY_S)])
async def test_many_viewers_get_fewer_messages_that_have_all_pictures(
    wall: Wall, record: GrowingRecord, viewers: int, gap_s: float
) -> None:
    async with running(wall):
        with ExitStack() as stack:
            watches = [stack.enter_context(wall.watch()) for _ in range(viewers)]
            for watch in watches:
                watch.choose((FIRST, SECOND))
            times_s = asyncio.create_task(_picture_times_s(watches[-1], 10.0))
            for number in range(50):
                record.add(1 + number % 2, utc_s())
                await asyncio.sleep(0.2)
            gaps_s = np.diff(await times_s)
    assert gaps_s.min() >= gap_s - 1e-6
    assert np.median(gaps_s) <= gap_s + 0.1


async def test_those_who_are_told_the_same_share_one_message(wall: Wall, record: GrowingRecord) -> None:
    record.add(1, START_UTC_S)
    messages = WallMessages(wall, loop_time_s)
    async with running(wall):
        with wall.watch() as one, wall.watch() as other:
            one.choose((FIRST,))
            other.choose((FIRST,))
            update, same = await next_pictures(one), await next_pictures(other)
            first = messages.message(update, refused="", after=0)
            assert messages.message(same, refused="", after=0) is first
            assert messages.message(same, refused="no", after=0) is not first
            assert messages.message(update, refused="", after=first.number).number > first.number  # not the same twice
            latest = messages.message(update, refused="", after=0)
            await asyncio.sleep(2.0 * SHARED_FOR_S)
            assert messages.message(same, refused="", after=0).number > latest.number  # its ages would be old


async def test_a_viewer_may_ask_for_fewer(wall: Wall, record: GrowingRecord) -> None:
    async with running(wall):
        with wall.watch() as watch:
            watch.choose((FIRST,), rate_hz=0.5)
            counts = asyncio.create_task(_picture_times_s(watch, 10.0))
            for _ in range(50):
                record.add(1, utc_s())
                await asyncio.sleep(0.2)
            assert 4 <= len(await counts) <= 6


async def test_heartbeats_come_without_pictures(wall: Wall) -> None:
    async with running(wall):
        with wall.watch() as watch:
            watch.choose((FIRST,))
            await watch.take()
            begin_s = utc_s()
            assert (await watch.take()).shown == {}
            assert utc_s() - begin_s == pytest.approx(HEARTBEAT_S)


async def test_too_many_tiles_and_several_large_ones_are_refused(wall: Wall) -> None:
    with wall.watch() as watch:
        with pytest.raises(InputDataError, match="tiles: at most 24"):
            watch.choose(tuple(TileName(one, TileKind.COLOUR) for one in range(25)))
        with pytest.raises(InputDataError, match="large"):
            watch.choose((FIRST, SECOND), is_large=True)
