"""The event stream and the journal that writes it down."""

from __future__ import annotations

import asyncio
from dataclasses import replace

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.mission.events import EventStream, Subscription
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.events import Event, EventKind, NoticeRecord
from aos_gcs.mission.model.phase import Phase
from aos_gcs.ports import Notice, Severity
from tests.fakes.mission_flight import MemoryRecorder, prepare

pytestmark = pytest.mark.looptime


def notice(text: str) -> NoticeRecord:
    return NoticeRecord(Severity.INFO, text, None, 0.0)


async def drained(subscription: Subscription) -> list[Event]:
    subscription.close()
    return [event async for event in subscription]


async def test_every_subscriber_gets_every_event_in_order() -> None:
    stream = EventStream(LoopClock())
    with stream.subscribe() as one, stream.subscribe() as other:
        for text in "abc":
            stream.publish(EventKind.NOTICE, notice(text))
        for subscription in (one, other):
            events = await drained(subscription)
            assert [event.seq for event in events] == [1, 2, 3]
            assert [event.data.text for event in events] == ["a", "b", "c"]


async def test_a_slow_subscriber_loses_its_own_oldest_events_only() -> None:
    stream = EventStream(LoopClock())
    with stream.subscribe(capacity=2) as slow, stream.subscribe() as quick:
        for text in "abcde":
            stream.publish(EventKind.NOTICE, notice(text))
        assert slow.dropped == 3
        assert [event.seq for event in await drained(slow)] == [4, 5]
        assert quick.dropped == 0
        assert len(await drained(quick)) == 5


async def test_nothing_arrives_before_or_after_the_subscription() -> None:
    stream = EventStream(LoopClock())
    stream.publish(EventKind.NOTICE, notice("before"))
    with stream.subscribe() as subscription:
        stream.publish(EventKind.NOTICE, notice("during"))
    stream.publish(EventKind.NOTICE, notice("after"))
    assert [event.data.text for event in await drained(subscription)] == ["during"]


async def test_a_waiting_reader_is_woken_by_an_event_and_by_the_end() -> None:
    stream = EventStream(LoopClock())
    texts: list[str] = []

    async def read(subscription: Subscription) -> None:
        async for event in subscription:
            texts.append(event.data.text)

    with stream.subscribe() as subscription:
        reader = asyncio.create_task(read(subscription))
        await asyncio.sleep(1.0)
        stream.publish(EventKind.NOTICE, notice("late"))
        await asyncio.sleep(1.0)
        assert texts == ["late"]
        subscription.close()
        await reader


async def test_the_time_of_notices_counts_from_the_start() -> None:
    clock = LoopClock(speed=10.0)
    journal, recorder = Journal(clock), MemoryRecorder()
    async with journal.recorded(recorder):
        await clock.sleep(50.0)
        journal.notice(Severity.INFO, "on the ground", track_id=4)
        assert journal.started_utc_s is None
        journal.start_timing()
        await clock.sleep(20.0)
        journal.take(Notice(Severity.WARNING, "low battery", 3))
    on_ground, in_flight = (event.data for event in recorder.events)
    assert on_ground.elapsed_s == 0.0
    assert in_flight.elapsed_s == pytest.approx(20.0, abs=0.1)
    assert in_flight.utc_s - on_ground.utc_s == pytest.approx(20.0, abs=0.1)
    assert (in_flight.severity, in_flight.vehicle_id) == (Severity.WARNING, 3)
    assert (on_ground.track_id, in_flight.track_id) == (4, None)
    assert journal.started_utc_s == pytest.approx(in_flight.utc_s - in_flight.elapsed_s, abs=0.01)


async def test_snapshots_are_thinned_on_the_disk_but_for_changes_of_the_phase() -> None:
    snapshot = prepare().view.snapshot()
    clock = LoopClock()
    journal, recorder = Journal(clock), MemoryRecorder()
    async with journal.recorded(recorder):
        for number in range(50):
            phase = Phase.CONNECT if number < 15 else Phase.PREFLIGHT
            journal.publish(EventKind.SNAPSHOT, replace(snapshot, phase=phase))
            journal.notice(Severity.INFO, str(number))
            await clock.sleep(0.1)
    snapshots = [event for event in recorder.events if event.kind is EventKind.SNAPSHOT]
    assert len(recorder.events) - len(snapshots) == 50
    assert 5 <= len(snapshots) <= 7
    first = next(event for event in snapshots if event.data.phase is Phase.PREFLIGHT)
    assert first.utc_s - snapshots[0].utc_s == pytest.approx(1.5, abs=0.05)


async def test_what_is_said_before_and_after_a_mission_is_recorded_with_the_last_state() -> None:
    snapshot = prepare().view.snapshot()
    clock = LoopClock()
    journal, recorder = Journal(clock), MemoryRecorder()
    journal.notice(Severity.INFO, "heard")
    async with journal.recorded(recorder):
        journal.notice(Severity.INFO, "landed")
    journal.notice(Severity.INFO, "between")
    async with journal.recorded(recorder):
        for message in ("confirmed", "commented"):
            journal.publish(EventKind.SNAPSHOT, replace(snapshot, message=message))
            await clock.sleep(0.1)
    told = [event.data.text if event.kind is EventKind.NOTICE else event.data.message for event in recorder.events]
    assert told == ["heard", "landed", "between", "confirmed", "commented"]


async def broken_off(journal: Journal, recorder: MemoryRecorder) -> None:
    async with journal.recorded(recorder):
        journal.notice(Severity.CRITICAL, "the last words")
        raise KeyError


async def test_the_last_events_are_written_when_the_mission_breaks_off() -> None:
    journal, recorder = Journal(LoopClock()), MemoryRecorder()
    with pytest.raises(ExceptionGroup):
        await broken_off(journal, recorder)
    assert [event.data.text for event in recorder.events] == ["the last words"]
